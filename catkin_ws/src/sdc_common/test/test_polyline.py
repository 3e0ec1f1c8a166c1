import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sdc_common.geometry.polyline import Polyline

BENT = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]
COORDINATES = st.floats(-50.0, 50.0).map(lambda value: round(value, 3))
POINTS = st.lists(st.tuples(COORDINATES, COORDINATES), min_size=2, max_size=30)


def test_heading_at_a_corner_is_the_mean_of_both_segments():
    assert Polyline(BENT).headings == pytest.approx([0.0, math.pi / 4, math.pi / 2])


def test_headings_are_continuous_over_several_turns():
    angle = np.arange(0.0, 6.0 * math.pi, 0.1)
    spiral = Polyline(np.column_stack([np.cos(angle), np.sin(angle)]).tolist())
    assert np.abs(np.diff(spiral.headings)).max() < 0.11
    assert spiral.headings[-1] - spiral.headings[0] == pytest.approx(angle[-1], abs=0.2)


@pytest.mark.slow(3)
@given(POINTS, COORDINATES, COORDINATES)
def test_nearest_place_is_the_closest_of_all_segments(points, x, y):
    line = Polyline(points, extend=False)
    assume(line.s[-1] > 0.0)
    place = line.nearest(x, y)
    a, b = np.array(points[:-1]), np.array(points[1:])
    step = b - a
    square = np.maximum(np.sum(step * step, axis=1), 1e-300)
    fraction = np.clip(np.sum(((x, y) - a) * step, axis=1) / square, 0.0, 1.0)
    distances = np.hypot(*((x, y) - a - fraction[:, None] * step).T)
    assert place.distance_m == pytest.approx(distances.min(), abs=1e-9)
    assert math.dist(line.point_at(place.s_m), (x, y)) == pytest.approx(place.distance_m, abs=1e-9)


def test_cross_track_is_positive_to_the_left():
    assert Polyline(BENT).nearest(4.0, 0.5).cross_track_m == 0.5
    assert Polyline(BENT).nearest(4.0, -0.5).cross_track_m == -0.5


@pytest.mark.parametrize(
    ("extend", "s_m", "distance_m"), [(True, [-3.0, 24.0], 1.0), (False, [0.0, 20.0], None)]
)
def test_line_ends_at_its_points_unless_it_extends(extend, s_m, distance_m):
    line = Polyline(BENT, extend=extend)
    places = [line.nearest(-3.0, 1.0), line.nearest(9.0, 14.0)]
    assert [place.s_m for place in places] == s_m
    expected = [distance_m] * 2 if distance_m else [math.hypot(3, 1), math.hypot(1, 4)]
    assert [place.distance_m for place in places] == pytest.approx(expected)


def test_search_is_limited_to_the_given_segments():
    there_and_back = Polyline([(0.0, 0.0), (50.0, 0.0), (50.0, 1.0), (0.0, 1.0)])
    assert there_and_back.nearest(10.0, 0.0).s_m == 10.0
    assert there_and_back.nearest(10.0, 0.0, 2, 3).s_m == 91.0
    assert there_and_back.project(10.0, 0.0, 90.0, 5.0, 5.0).s_m == 91.0
    assert there_and_back.project(10.0, 0.0, 1000.0, 5.0, 5.0).segment == 2
    assert there_and_back.project(10.0, 0.0, -1000.0, 5.0, 5.0).segment == 0


def test_point_that_is_not_finite_has_no_place():
    place = Polyline(BENT).nearest(math.nan, 0.0)
    assert math.isnan(place.s_m)


def test_points_beyond_the_ends_continue_straight():
    line = Polyline(BENT)
    assert line.point_at(-2.0) == (-2.0, 0.0)
    assert line.point_at(23.0) == (10.0, 13.0)
    assert line.heading_at(-2.0) == 0.0
    assert line.heading_at(23.0) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("radius", [-30.0, -8.0, 8.0, 30.0])
def test_curvature_of_an_arc_is_the_inverse_of_its_radius(radius):
    angle = np.arange(0.0, 2.0, 1.0 / abs(radius))
    side = math.copysign(1.0, radius)
    arc = abs(radius) * np.column_stack([np.sin(angle), side * (1.0 - np.cos(angle))])
    line = Polyline(arc.tolist())
    for s in np.arange(2.0, line.s[-1] - 2.0, 0.7):
        assert line.curvature_at(s) == pytest.approx(1.0 / radius, rel=1e-3)
    for s in (0.0, line.s[-1]):  # the end segments have the heading of their middle there
        assert line.curvature_at(s) == pytest.approx(1.0 / radius, rel=0.6)


def test_place_has_the_heading_in_half_a_turn():
    west = Polyline([(0.0, 0.0), (-1.0, 0.0), (-2.0, -0.1), (-3.0, -1.0)])
    assert -math.pi <= west.nearest(-2.5, -0.5).heading_rad < math.pi
    assert west.nearest(-2.5, -0.5).heading_rad == pytest.approx(-math.pi + 0.58, abs=0.1)


def test_direction_changes_at_the_corner_and_heading_before_it():
    line = Polyline(BENT)
    assert [line.direction_at(s) for s in (-1.0, 9.9, 10.0, 25.0)] == [0.0, 0.0] + [math.pi / 2] * 2
    assert line.heading_at(9.9) > 0.7


def test_line_whose_points_coincide_has_a_place():
    point = Polyline([(1.0, 2.0), (1.0, 2.0)])
    assert point.point_at(0.0) == (1.0, 2.0)
    assert point.direction_at(0.0) == 0.0
    assert point.segment_at(0.0) == (0, 0.0)
    assert point.curvature_at(0.0) == 0.0
    assert Polyline([(0.0, 0.0), (5.0, 0.0), (5.0, 0.0)]).segment_at(5.0) == (0, 1.0)


def test_place_where_points_coincide_has_a_heading():
    line = Polyline([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 2.0)], extend=False)
    assert math.isfinite(line.nearest(1.1, -0.1, 1, 2).heading_rad)
