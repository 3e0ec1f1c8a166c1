"""The line of a road through waypoints that are coarse, rounded, noisy or uneven."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdc_common.geometry.road_line import road_line, road_route
from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, ideal_duration, speed_profile

FINE_M = 0.01
SPACINGS_M = (0.2, 0.4, 1.0, 2.0, 3.5, 5.0, 10.0, 20.0)
RADII_M = (15.0, 25.0, 60.0, 80.0, 250.0, 500.0)


def line_of(knots_m, curvatures, heading=0.3):
    """Return arc lengths, points and curvatures, every centimetre, of linear curvatures."""
    s = np.arange(0.0, knots_m[-1], FINE_M)
    curvature = np.interp(s, knots_m, curvatures)
    headings = heading + np.cumsum(curvature) * FINE_M
    points = np.column_stack([np.cumsum(np.cos(headings)), np.cumsum(np.sin(headings))]) * FINE_M
    return s, points, curvature


def bend(radius_m, transition_m, turn_rad, straight_m):
    """Return a straight, a clothoid, an arc, a clothoid and a straight."""
    arc_m = radius_m * turn_rad - transition_m
    knots = np.cumsum([0.0, straight_m, transition_m, arc_m, transition_m, straight_m])
    return line_of(knots, np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]) / radius_m)


def every(points_m, spacing_m):
    return points_m[:: int(round(spacing_m / FINE_M))]


def cases():
    return [(r, h) for r in RADII_M for h in SPACINGS_M if h <= r / 4.0]


@pytest.mark.parametrize(("radius_m", "spacing_m"), cases())
def test_circle_has_its_curvature_at_any_spacing(radius_m, spacing_m):
    length_m = min(1.5 * math.pi * radius_m, 600.0)
    _, points, _ = line_of([0.0, length_m], [1.0 / radius_m] * 2)
    route = road_route(every(points, spacing_m))
    inner = (route.s > 5.0) & (route.s < route.length_m - 5.0)
    np.testing.assert_allclose(route.curvature[inner], 1.0 / radius_m, rtol=0.05)


@pytest.mark.parametrize(("radius_m", "spacing_m"), cases())
def test_clothoid_has_its_curvature_at_any_spacing(radius_m, spacing_m):
    s, points, curvature = line_of([0.0, 2.0 * radius_m], [0.0, 1.0 / radius_m])
    route = road_route(every(points, spacing_m))
    inner = (route.s > 5.0) & (route.s < route.length_m - 5.0)
    expected = np.interp(route.s[inner], s, curvature)
    np.testing.assert_allclose(route.curvature[inner], expected, atol=0.05 / radius_m)


@pytest.mark.parametrize("speed_mps", [10.0, 25.0])
@pytest.mark.parametrize(("radius_m", "spacing_m"), cases())
def test_planned_time_does_not_depend_on_the_spacing(radius_m, spacing_m, speed_mps):
    limits = SpeedLimits(speed_mps, 3.0, 1.8, 2.5, 6.0)
    _, points, _ = bend(radius_m, max(0.5 * radius_m, 20.0), 2.0, 100.0)
    fine = Route(every(points, 1.0))
    route = road_route(every(points, spacing_m))
    scale = route.length_m / fine.length_m
    assert ideal_duration(route, speed_profile(route, limits)) == pytest.approx(
        scale * ideal_duration(fine, speed_profile(fine, limits)), rel=0.03
    )


def test_fine_and_exact_waypoints_are_the_line():
    _, points, _ = bend(15.0, 10.0, 1.5, 30.0)
    fine = every(points, 1.0).round(4)
    np.testing.assert_array_equal(road_line(fine), fine)


@pytest.mark.parametrize("spacing_m", [0.4, 1.0, 2.0, 5.0])
@pytest.mark.parametrize(
    ("rounding_m", "noise_m", "within_m"), [(0.01, 0.0, 0.02), (0.1, 0.0, 0.10), (0.0, 0.05, 0.15)]
)
@pytest.mark.parametrize(("radius_m", "transition_m"), [(60.0, 40.0), (300.0, 100.0)])
def test_noise_of_waypoints_makes_no_bend(
    radius_m, transition_m, spacing_m, rounding_m, noise_m, within_m
):
    _, points, curvature = bend(radius_m, transition_m, 1.5, 100.0)
    waypoints = every(points, spacing_m)
    if rounding_m:
        waypoints = np.round(waypoints / rounding_m) * rounding_m
    waypoints = waypoints + np.random.default_rng(1).normal(0.0, noise_m, waypoints.shape)
    route = road_route(waypoints)
    distance, nearest = cKDTree(points).query(route.points)
    assert distance.max() < within_m
    inner = (route.s > 10.0) & (route.s < route.length_m - 10.0)
    assert np.abs(route.curvature - curvature[nearest])[inner].max() < 0.25 / radius_m + 0.001


def test_rounding_on_straights_along_the_axes_is_recognized():
    """On most of this route, rounded points have no deviation."""
    _, points, _ = line_of(
        np.cumsum([0.0, 300.0, 40.0, 40.0, 40.0, 300.0]),
        np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]) / 50.0,
        heading=0.0,
    )
    route = road_route(np.round(every(points, 0.5), 1))
    assert np.abs(route.curvature).max() < 1.2 / 50.0


def test_long_straight_does_not_swing_out_before_a_bend():
    _, points, _ = bend(50.0, 0.01, 1.5, 200.0)
    in_bend = points[int(200.0 / FINE_M) : int((200.0 + 75.0) / FINE_M) : int(5.0 / FINE_M)]
    route = road_route(np.vstack([points[0], in_bend, points[-1]]))
    distance, _ = cKDTree(points).query(route.points)
    assert distance.max() < 0.3


def test_corner_of_straights_stays_a_corner():
    line = road_line(np.array([[0.0, 0.0], [50.0, 0.0], [50.0, 30.0]]))
    assert np.abs(np.minimum(np.abs(line[:, 1]), np.abs(line[:, 0] - 50.0))).max() < 1e-9
    assert [50.0, 0.0] in line.tolist()


def test_gap_in_a_bend_is_closed_along_the_bend():
    _, points, _ = line_of([0.0, 500.0], [1.0 / 300.0] * 2)
    fine = every(points, 1.0)
    route = road_route(np.vstack([fine[:200], fine[300:]]))
    distance, _ = cKDTree(points).query(route.points)
    assert distance.max() < 0.1


def test_points_of_the_line_are_evenly_spaced_whatever_the_waypoints():
    random = np.random.default_rng(5)
    steps = random.choice([0.001, 0.05, 0.3, 1.0, 7.0, 100.0], 60)
    line = road_line(np.column_stack([np.append(0.0, np.cumsum(steps)), np.zeros(61)]))
    gaps = np.diff(line[:, 0])
    assert gaps.max() <= 1.25 + 1e-9
    assert (gaps > 0.0).all()


def test_equal_waypoints_share_their_route_and_others_do_not():
    waypoints = np.column_stack([np.arange(30.0), np.zeros(30)])
    first = road_route(waypoints)
    assert road_route(waypoints.copy()) is first
    assert road_route(waypoints[::-1]).points[0].tolist() == [29.0, 0.0]
    waypoints[7, 1] = 0.5
    assert road_route(waypoints) is not first
    assert first.points[7, 1] == 0.0
