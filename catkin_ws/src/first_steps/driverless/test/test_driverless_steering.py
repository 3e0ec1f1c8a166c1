"""Test the steering geometry, the order of the route and the driver."""

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from driverless.driver import Driver, heading_error
from driverless.route import Route
from world.rules import checked
from world.waypoints import Waypoint

PI = math.pi
CONFIG = yaml.safe_load(
    (Path(__file__).resolve().parents[1] / "config" / "driverless.yaml").read_text()
)
coordinates, angles = st.floats(-1e3, 1e3), st.floats(-50.0, 50.0)


def driver(**overrides):
    return Driver(checked("driverless", {**CONFIG, **overrides}))


@given(coordinates, coordinates, angles, coordinates, coordinates)
def test_car_turned_by_the_heading_error_points_at_the_target(x, y, direction, target_x, target_y):
    error = heading_error(x, y, direction, Waypoint(0, target_x, target_y))
    assert -PI <= error <= PI
    distance = math.hypot(target_x - x, target_y - y)
    assert x + distance * math.cos(direction + error) == pytest.approx(target_x, abs=1e-6)
    assert y + distance * math.sin(direction + error) == pytest.approx(target_y, abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_run_up_begins_well_inside_the_turning_circle_and_ends_outside_it(side):
    student = driver(max_turn=0.1, reach_distance=20.0)
    # Steps of 10 u: the sharpest turn has a radius of 100 u, with its centre at (10, 100).
    student.set_map([Waypoint(0, 0.0, 100.0 * side)])
    student.step(0.0, 0.0, 0.0)
    assert student.step(10.0, 0.0, 0.0)[0] == 0.0, "the target is inside the circle"
    assert student.step(20.0, 0.0, 0.0)[0] == 0.0
    straight = [student.step(10.0 * i, 0.0, 0.0)[0] == 0.0 for i in range(3, 14)]
    assert straight == [True] * 7 + [False] * 4, "the target is outside from x = 100 on"


def visited(points, count, start=(-4.0, 0.0)):
    """Return the first `count` targets of a car that moves from each target to the next."""
    route = Route()
    route.set_map(points)
    target = route.update(*start, points, 1.0)
    order = []
    for _ in range(count):
        order.append((target.idx, target.x))
        target = route.update(target.x, target.y, points, 1.0)
    return order


def test_first_target_is_the_nearest_point():
    points = [Waypoint(i, 10.0 * i, 0.0) for i in range(10)]
    assert visited(points, 2, start=(62.0, 3.0)) == [(6, 60.0), (7, 70.0)]


@given(st.lists(st.integers(0, 20), min_size=1, max_size=20), st.floats(-30.0, 250.0))
def test_each_round_visits_every_point_once_in_order_of_idx(indices, start):
    points = [Waypoint(idx, 10.0 * place, 0.0) for place, idx in enumerate(indices)]
    order = visited(points, 2 * len(points), (start, 4.0))
    first, second = order[: len(points)], order[len(points) :]
    assert first == second
    begin = first.index(min(first))
    assert first[begin:] + first[:begin] == sorted((point.idx, point.x) for point in points)


def test_route_without_a_map_consists_of_sensed_points():
    route = Route()
    assert route.update(0.0, 0.0, set(), 1.0) is None
    route.add_sensed([Waypoint(5, 50.0, 0.0)])
    assert route.update(0.0, 0.0, set(), 1.0).idx == 5
    assert route.update(50.0, 0.0, {Waypoint(5, 50.0, 0.0)}, 1.0).idx == 5
    route.add_sensed([Waypoint(3, 30.0, 0.0)])
    assert route.update(50.0, 0.0, set(), 1.0).idx == 3, (
        "the lowest known idx follows the highest known one"
    )
    route.add_sensed([Waypoint(7, 70.0, 0.0)])
    assert route.update(50.0, 0.0, set(), 1.0).idx == 7, (
        "a new point with a higher idx comes before the lowest one"
    )


def test_route_without_a_map_removes_a_point_that_no_longer_exists():
    route = Route()
    points = [Waypoint(i, 10.0 * i, 0.0) for i in range(3)]
    route.add_sensed(points)
    assert route.update(0.0, 0.0, {points[0]}, 1.0).idx == 1
    assert route.update(10.0, 0.0, {points[0], points[2]}, 1.0).idx == 2
    assert route.update(20.0, 0.0, {points[2]}, 1.0).idx == 0
    assert route.update(0.0, 0.0, {points[0]}, 1.0).idx == 2


def test_new_map_keeps_the_progress():
    route = Route()
    points = [Waypoint(i, 10.0 * i, 0.0) for i in range(4)]
    route.set_map(points)
    assert route.update(20.0, 0.0, points, 1.0).idx == 3
    route.set_map([*points, Waypoint(4, 40.0, 0.0)])
    assert route.update(30.0, 0.0, points, 1.0).idx == 4
    route.set_map(points)
    assert route.update(30.0, 0.0, points, 1.0).idx == 0
    route.set_map([])
    assert route.update(30.0, 0.0, points, 1.0) is None


def test_step_turns_by_the_gain_times_the_heading_error():
    student = driver(turn_gain=0.5, max_turn=0.25)
    student.set_map([Waypoint(0, 100.0, 0.0), Waypoint(1, 300.0, 0.0)])
    assert student.step(0.0, 0.0, 0.1)[0] == pytest.approx(-0.05)
    assert student.step(0.0, 0.0, -1.0)[0] == 0.25


def test_search_drives_straight_and_turns_after_search_patience_steps():
    student = driver(search_patience=10, search_turn=2.4, max_turn=0.25)
    turns = [student.step(0.0, 0.0, 0.0)[0] for _ in range(40)]
    assert turns[:9] == [0.0] * 9
    assert sum(turns[9:19]) == pytest.approx(2.4, abs=0.25) and max(turns) == 0.25
