"""The line of a road through waypoints that are coarse, rounded, noisy or uneven."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdc_common.geometry.road_line import arc_lengths, noise_of, road_line, road_route
from sdc_common.geometry.route import Route

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
def test_clothoid_has_its_curvature_at_any_spacing(radius_m, spacing_m):
    s, points, curvature = line_of([0.0, 2.0 * radius_m], [0.0, 1.0 / radius_m])
    route = road_route(every(points, spacing_m))
    inner = (route.s > 5.0) & (route.s < route.length_m - 5.0)
    expected = np.interp(route.s[inner], s, curvature)
    np.testing.assert_allclose(route.curvature[inner], expected, atol=0.05 / radius_m)


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


def rotated(points_m, angle_rad):
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return points_m @ np.array([[cosine, sine], [-sine, cosine]])


def distances(points_m, line_m):
    """Return the distances of points from a line of any points [m]."""
    line = Route(line_m).line
    return np.array([line.nearest(x, y).distance_m for x, y in points_m.tolist()])


def test_rounding_is_recognized_in_32_bit_coordinates_of_a_large_map():
    """The straights are along x and y, where rounded points have no deviation."""
    _, points, _ = line_of(
        [0.0, 60.0, 60.01, 107.12, 107.13, 160.0], [0, 0, 1 / 30, 1 / 30, 0, 0], 0.0
    )
    waypoints = np.round(every(points, 1.0) + [4000.0, 7000.0], 2)
    as_received = waypoints.astype(np.float32).astype(float)
    noise_m = noise_of(as_received, arc_lengths(as_received))
    assert noise_m == pytest.approx(0.01 / math.sqrt(12.0), rel=1e-6)


def test_bends_beside_a_corner_keep_their_shape():
    _, points, _ = line_of([0.0, 40.0], [1.0 / 30.0] * 2)
    before = every(points, 5.0)
    after = before[-1] + rotated(before - before[0], -1.2)
    exact = np.vstack([points, before[-1] + rotated(points - points[0], -1.2)])
    line = road_line(np.vstack([before, after[1:]]))
    distance, _ = cKDTree(exact).query(line)
    assert distance.max() < 0.05
    assert distances(before[-1:], line).max() < 1e-6


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize(
    ("radius_m", "straight_m", "arc_m", "at_m", "within_m"),
    [
        # A short bend between long straights.
        (30.0, 50.0, 10.0, (0, 50, 55, 60, 85, 110), 0.01),
        # Long steps before and in a bend, and after it.
        (30.0, 100.0, 45.0, (70, *range(100, 145, 5), 155, 195), 0.15),
        # A bend whose last step is short.
        (30.0, 0.0, 53.0, (0, 12, 24, 36, 48, 53, 75), 0.05),
        # A bend that begins in the middle of a long step.
        (50.0, 100.0, 75.0, (90, *range(110, 175, 5)), 0.15),
    ],
)
def test_line_of_uneven_waypoints_stays_on_the_road(
    radius_m, straight_m, arc_m, at_m, within_m, backward
):
    knots = np.cumsum([0.0, straight_m, FINE_M, arc_m, FINE_M, 100.0])
    _, points, _ = line_of(knots, np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]) / radius_m)
    waypoints = points[np.round(np.array(at_m) / FINE_M).astype(int)]
    line = road_line(waypoints[::-1] if backward else waypoints)
    distance, _ = cKDTree(points).query(line)
    assert distance.max() < within_m
