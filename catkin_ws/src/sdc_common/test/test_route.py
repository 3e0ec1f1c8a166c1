import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.route import Route


def circle(radius, angle, spacing=1.0, noise=0.0, seed=0):
    """An arc to the left from the origin, heading along x."""
    count = int(radius * angle / spacing) + 1
    turned = np.linspace(0.0, angle, count)
    points = np.column_stack([radius * np.sin(turned), radius * (1.0 - np.cos(turned))])
    return (
        points + np.random.default_rng(seed).normal(0.0, noise, points.shape) if noise else points
    )


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


def test_mirrored_route_has_opposite_curvature():
    points = circle(10.0, 3.0)
    left, right = Route(points), Route(points * [1.0, -1.0])
    np.testing.assert_allclose(left.curvature, -right.curvature, atol=1e-12)
    np.testing.assert_allclose(left.heading, -right.heading, atol=1e-12)


def test_recording_noise_makes_no_bend():
    route = Route(
        np.column_stack([np.arange(200.0), np.random.default_rng(3).normal(0.0, 0.02, 200)])
    )
    raw = np.abs(np.diff(np.diff(route.points[:, 1])))
    assert np.abs(route.curvature).max() < 0.4 * raw.max()


def test_route_of_two_points_is_straight():
    route = Route([[0.0, 0.0], [3.0, 4.0]])
    assert route.length_m == 5.0
    np.testing.assert_allclose(route.heading, math.atan2(4.0, 3.0))
    np.testing.assert_allclose(route.curvature, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "part"),
    [
        ([[0.0, 0.0]], "2 points"),
        (np.zeros((3, 2)), "coincide"),
        ([[0, 0], [math.nan, 1]], "finite"),
        (np.zeros((4, 3)), "2 points"),
    ],
)
def test_points_that_are_no_route_are_refused(points, part):
    with pytest.raises(ValueError, match=part):
        Route(points)


def test_cross_track_is_positive_to_the_left():
    route = Route([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]])
    place = route.project(4.0, 0.5, 4.0, 5.0, 5.0)
    assert (place.s_m, place.cross_track_m, place.distance_m) == pytest.approx((4.0, 0.5, 0.5))
    assert route.project(4.0, -0.5, 4.0, 5.0, 5.0).cross_track_m == pytest.approx(-0.5)


def test_project_searches_only_near_the_given_arc_length():
    there = np.column_stack([np.arange(0.0, 50.0), np.zeros(50)])
    back = np.column_stack([np.arange(49.0, 0.0, -1.0), np.full(49, 0.4)])
    route = Route(np.vstack([there, back]))
    assert route.project(10.0, 0.4, 10.0, 5.0, 10.0).s_m == pytest.approx(10.0)
    assert route.project(10.0, 0.0, 88.0, 5.0, 10.0).s_m == pytest.approx(
        49.0 + 0.4 + 39.0, abs=1.1
    )


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
    for place in (route.locate(x, y, angle), route.project(x, y, s, 3.0, 3.0)):
        assert place.s_m == pytest.approx(s, abs=0.1 + 0.02 * s)
        assert place.cross_track_m == pytest.approx(offset, abs=0.03)
