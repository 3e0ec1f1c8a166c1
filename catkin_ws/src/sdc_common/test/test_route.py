import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.route import Route


def circle(radius, angle, spacing=1.0):
    """An arc to the left from the origin, heading along x."""
    count = int(radius * angle / spacing) + 1
    turned = np.linspace(0.0, angle, count)
    return np.column_stack([radius * np.sin(turned), radius * (1.0 - np.cos(turned))])


@given(st.floats(-1e4, 1e4))
def test_wrapped_angle_has_the_same_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize("radius", [4.0, 10.0, 50.0])
def test_arc_has_the_curvature_and_length_of_its_circle(radius):
    route = Route(circle(radius, 1.5 * math.pi))
    inner = slice(6, -6)
    np.testing.assert_allclose(route.curvature[inner], 1.0 / radius, rtol=0.06)
    np.testing.assert_allclose(route.heading[inner], route.s[inner] / radius, atol=0.03)
    assert route.length_m == pytest.approx(1.5 * math.pi * radius, rel=0.01)


def test_locate_prefers_the_pass_in_the_cars_direction_then_the_earlier_one():
    there = np.column_stack([np.arange(0.0, 50.0), np.zeros(50)])
    back = np.column_stack([np.arange(49.0, 0.0, -1.0), np.full(49, 0.4)])
    route = Route(np.vstack([there, back]))
    assert route.locate(10.0, 0.3, 0.0).s_m == pytest.approx(10.0)
    assert route.locate(10.0, 0.1, math.pi).s_m > 60.0
    twice = Route(circle(20.0, 3.5 * math.pi))
    assert twice.locate(20.05, 20.0).s_m == pytest.approx(20.0 * math.pi / 2, abs=0.5)


@given(st.floats(0.0, 28.0), st.floats(-2.0, 2.0))
def test_point_next_to_the_route_is_located(s, offset):
    route = Route(circle(10.0, 3.0))
    angle = s / 10.0
    x = (10.0 - offset) * math.sin(angle)
    y = 10.0 - (10.0 - offset) * math.cos(angle)
    for place in (route.locate(x, y, angle), route.line.project(x, y, s, 3.0, 3.0)):
        assert place.s_m == pytest.approx(s, abs=0.1 + 0.02 * s)
        assert place.cross_track_m == pytest.approx(offset, abs=0.03)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0.0, 0.0]], "2 points"),
        (np.zeros((4, 3)), "2 points"),
        ([[0, 0], [1, 0], [1, 0]], "points 1 and the next of the route coincide"),
        ([[0, 0], [1, 0], [math.inf, 0]], "point 2 of the route is not finite"),
    ],
)
def test_points_that_are_no_route_are_refused(points, message):
    with pytest.raises(ValueError, match=message):
        Route(points)


def test_smoothing_damps_a_wave_by_the_law_of_a_gaussian():
    x = np.arange(0.0, 80.0, 0.1)
    wave = 2.0 * math.pi / 8.0
    route = Route(np.column_stack([x, 0.05 * np.sin(wave * x)]))
    expected = 0.05 * wave**2 * math.exp(-0.5 * wave**2)
    assert np.abs(route.curvature[100:-100]).max() == pytest.approx(expected, rel=0.06)


@pytest.mark.parametrize("length", [1.0, 2.0, 3.0, 30.0])
def test_route_in_the_other_direction_has_the_same_bends(length):
    points = circle(6.0, length / 6.0, spacing=0.25)
    route, back = Route(points), Route(points[::-1])
    np.testing.assert_allclose(back.curvature[::-1], -route.curvature, atol=1e-9)
    turned = back.heading[::-1] - route.heading
    np.testing.assert_allclose(turned, turned[0], atol=1e-9)
    assert math.cos(turned[0]) == pytest.approx(-1.0)


def test_last_point_up_to_an_arc_length():
    route = Route(np.column_stack([np.arange(6.0), np.zeros(6)]))
    places = [route.last_point_s(s) for s in (-1.0, 0.5, 3.0, 3.9, 99.0)]
    assert places == [0.0, 0.0, 3.0, 3.0, 5.0]
