"""The geometry of the road: lines, folds, crossings, scenery and difficult routes."""

import numpy as np
import pytest
from arcs import route

from sdc_common.geometry.road_line import road_route
from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import lane_points, speed_colours

LEFT_TURN = route(40, (4, np.pi / 2), 40)
CROSSING = route(60, (15, 1.5 * np.pi), 60)
ROUNDABOUT = np.vstack([route(50, (20, 2 * np.pi)), route(50, (20.3, 2 * np.pi))[51:]])


def along(road):
    return np.linspace(0.0, road.length_m, int(2.0 * road.length_m) + 1)


def test_lines_of_a_straight_road_lie_at_their_offsets():
    road = Road([[0.0, 0.0], [0.0, 100.0]])
    offsets_m = road.right_edge_m, road.centre_line_m, road.left_edge_m
    for offset, x in zip(offsets_m, (1.75, -1.75, -5.25)):
        points, seen = lane_points(road, offset, along(road))
        assert seen.all()
        assert np.allclose(points[:, 0], x, atol=1e-9)
        assert np.allclose(points[[0, -1], 1], [0.0, 100.0], atol=1e-9)


def test_road_is_drawn_along_the_line_that_is_driven():
    angle = np.arange(0.0, 2.0, 0.2)
    coarse = 60.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    road = Road(coarse)
    inside = (road.s_m >= 0.0) & (road.s_m <= road.length_m)
    assert np.allclose(np.hypot(*(road.points_m[inside] - (0.0, 60.0)).T), 60.0, atol=0.02)
    assert road.between(road_route(coarse).points, -0.005, 0.005).all()


def test_direction_of_the_road_is_that_of_its_circle_or_where_it_turns_back_of_its_line():
    """At an end, half of the chord is missing, so that it has the heading of its middle."""
    angle = np.linspace(0.0, 2.0, 41)
    road = Road(20.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]))
    at = np.array([0.0, 1.0, 5.0, 20.0, 39.0, road.length_m])
    middles = np.array([0.75, 1.25, 5.0, 20.0, 0.5 * (37.5 + road.length_m), road.length_m - 0.75])
    headings = np.interp(at, road.s_m, road.heading_rad)
    np.testing.assert_allclose(headings, middles / 20.0, atol=5e-3)
    road = Road([[5.0, 3.0], [15.0, 3.0], [15.0, 3.2], [5.0, 3.2]])
    np.testing.assert_allclose(road.left[road.s_m < 9.5, 1], 1.0, atol=0.1)
    np.testing.assert_allclose(road.left[road.s_m > road.length_m - 9.5, 1], -1.0, atol=0.1)


def test_left_edge_hides_its_fold_in_a_turn_tighter_than_its_offset():
    road = Road(LEFT_TURN)
    points, seen = lane_points(road, road.left_edge_m, along(road))
    assert not seen.all()
    shown = points[seen]
    incoming = np.abs(shown[:, 1] - 5.25) < 0.1
    outgoing = np.abs(shown[:, 0] - (44.0 - 5.25)) < 0.1
    assert np.all(incoming | outgoing)
    assert shown[incoming, 0].max() < 38.75 + 0.3
    assert shown[outgoing, 1].min() > 5.25 - 0.3


def test_second_lap_is_the_same_road():
    angle = np.arange(0.0, 4.0 * np.pi, 0.02)
    road = Road(50.0 * np.column_stack([np.cos(angle), np.sin(angle)]))
    second = road.s_m > 2.0 * np.pi * 50.0 + 5.0
    inside = (road.s_m > 5.0) & (road.s_m < road.length_m - 5.0)
    assert road.repeats[second & inside].all()
    assert not road.repeats[(road.s_m > 5.0) & (road.s_m < 300.0)].any()


def test_edges_are_hidden_on_the_other_pass_of_a_crossing():
    road = Road(CROSSING)
    for offset in (road.right_edge_m, road.left_edge_m):
        points, seen = lane_points(road, offset, along(road))
        others = [np.abs(road.points_m - p).sum(axis=1).min() for p in points[seen][::10]]
        assert min(others) > 1.5
        assert 0.02 < 1.0 - seen.mean() < 0.3


def test_road_is_between_its_edges():
    road = Road(CROSSING)
    straight, left = road.at([20.0, 30.0])
    assert road.on_road(straight + 5.2 * left).all()
    assert not road.on_road(straight + 5.4 * left).any()
    assert road.between(straight + 1.9 * left, 1.9 - 1e-6, 1.9 + 1e-6).all()


def test_noise_does_not_turn_the_road():
    rng = np.random.RandomState(1)
    noisy = np.column_stack([np.arange(0.0, 200.0, 0.1), np.zeros(2000)])
    noisy += rng.normal(0.0, 0.03, (2000, 2))
    back_and_forth = np.repeat(noisy, 2, axis=0)
    back_and_forth[1::2, 0] -= 0.08
    road = Road(back_and_forth)
    assert np.abs(road.heading_rad).max() < 0.12
    assert np.ptp(lane_points(road, road.left_edge_m, along(road))[0][:, 1]) < 1.2


def test_colours_of_a_path_run_from_red_over_yellow_to_green():
    red, half, green, beyond = speed_colours([0.0, 5.0, 10.0, 30.0], 10.0)
    assert red[0] > 0.8 > red[1]
    assert half[0] > 0.8 and half[1] > 0.7
    assert green[1] > 0.7 > green[0]
    np.testing.assert_array_equal(green, beyond)
    assert speed_colours([], 10.0).shape == (0, 3)


LAPS = np.arange(31400) / 50.0
ROUTES = {
    "two points": [[0.0, 0.0], [25.0, 10.0]],
    "very short": [[0.0, 0.0], [0.3, 0.0]],
    "100,000 points": np.column_stack([np.arange(1e5), 300.0 * np.sin(np.arange(1e5) / 300.0)]),
    "100 laps": 50.0 * np.column_stack([np.cos(LAPS), np.sin(LAPS)]),
    "random walk": np.cumsum(np.random.RandomState(0).normal(size=(3000, 2)), axis=0),
    "there and back": [[0.0, 0.0], [50.0, 0.0], [0.0, 0.0]],
    "far away": [[1e6, -1e6], [1e6 + 300.0, -1e6]],
    "tight left": LEFT_TURN,
    "crossing": CROSSING,
    "roundabout": ROUNDABOUT,
}


@pytest.mark.parametrize("name", sorted(ROUTES))
def test_any_route_gives_a_finite_road_with_unit_normals(name):
    road = Road(ROUTES[name])
    assert np.isfinite(road.points_m).all() and np.isfinite(road.heading_rad).all()
    assert np.allclose(np.linalg.norm(road.left, axis=1), 1.0)
    assert np.all(np.diff(road.s_m) > 0.0)
    assert road.s_m[0] <= 0.0 and road.s_m[-1] >= road.length_m


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    "name", ["tight left", "crossing", "roundabout", "two points", "100 laps", "random walk"]
)
def test_scenery_is_off_every_pass_of_the_road_and_repeatable(name):
    road = Road(ROUTES[name])
    scenery, again = road.scenery(3), Road(ROUTES[name]).scenery(3)
    assert np.array_equal(scenery.position_m, again.position_m)
    assert np.array_equal(scenery.variant, again.variant)
    if name != "random walk":
        assert len(scenery) > 5
    rows = zip(scenery.kind, scenery.position_m, scenery.yaw_rad, scenery.size_m)
    for kind, position, yaw, size in rows:
        half = 0.5 * size[:2] if kind else np.array([0.4, 0.4])
        u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9)))
        c, s = np.cos(yaw), np.sin(yaw)
        x, y = u * half[0], v * half[1]
        body = position + np.column_stack([c * x - s * y, s * x + c * y])
        assert not road.on_road(body, margin_m=0.3).any()
