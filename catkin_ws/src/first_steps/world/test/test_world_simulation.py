"""Test the sensor, the lap counter and the complete simulation."""

import math
from pathlib import Path

import pytest
import yaml

from world.laps import LapCounter
from world.settings import read_settings
from world.simulation import Simulation
from world.waypoints import Waypoint

CONFIG = yaml.safe_load((Path(__file__).resolve().parents[1] / "config" / "world.yaml").read_text())
SQUARE = [
    Waypoint(0, 0.0, 0.0),
    Waypoint(1, 100.0, 0.0),
    Waypoint(2, 100.0, 100.0),
    Waypoint(3, 0.0, 100.0),
]


def simulation(**overrides):
    return Simulation(read_settings({**CONFIG, **overrides}))


def sensed(car, points, sensor_range=100.0, front_only=False):
    """Return the numbers of the points that the sensor of a car detects."""
    world = simulation(sensor_range=sensor_range, sensor_front_only=front_only)
    world.place_car(*car)
    for point in points:
        world.add_waypoint(*point)
    first = CONFIG["waypoint_count"]  # the points of the ellipse come before
    return [point.idx - first for point in world.sensed() if point.idx >= first]


def test_sensor_detects_points_up_to_its_range():
    assert sensed((3.0, 4.0, 0.0), [(103.0, 4.0), (103.0, 4.001), (3.0, 4.0)]) == [0, 2]


@pytest.mark.parametrize(
    "direction, ahead", [(0.0, [0, 2, 3]), (math.pi / 4, [0, 2]), (3.1, [1, 2])]
)
def test_front_only_sensor_detects_points_ahead_and_at_the_sides(direction, ahead):
    points = [(10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0)]
    assert sensed((0.0, 0.0, direction), points, front_only=True) == ahead
    assert sensed((0.0, 0.0, direction), points) == [0, 1, 2, 3]


def laps_after(points, visits):
    counter = LapCounter(points, 10.0)
    completed = [counter.update(*visit) for visit in visits]
    assert sum(completed) == counter.laps
    return counter.laps


PLACES = [(p.x, p.y) for p in SQUARE]


@pytest.mark.parametrize(
    "order, laps",
    [
        ([0, 1, 2, 3], 0),
        ([0, 1, 2, 3, 0], 1),
        ([0, 1, 2, 3, 0, 1, 2, 3, 0], 2),
        ([2, 3, 0, 1, 2], 1),  # any point may be the start
        ([0, 1, 3, 0], 0),  # one left out
        ([0, 1, 3, 2, 3, 0], 1),  # other points in between do not matter
        ([3, 2, 1, 0, 3], 0),  # the opposite direction
        ([0, 0, 0, 0, 0, 0], 0),
    ],
)
def test_lap_counts_when_all_points_are_touched_in_order(order, laps):
    assert laps_after(SQUARE, [PLACES[i] for i in order]) == laps


def test_lap_counts_with_points_closer_than_the_touch_distance():
    points = [
        Waypoint(i, 100.0 * math.cos(0.02 * i), 100.0 * math.sin(0.02 * i)) for i in range(314)
    ]
    visits = [(100.0 * math.cos(0.1 * i), 100.0 * math.sin(0.1 * i)) for i in range(130)]
    assert laps_after(points, visits) == 2


def test_lap_does_not_count_when_the_car_is_moved_by_hand():
    world = simulation()
    for waypoint in [*world.waypoints, world.waypoints[0]]:
        world.place_car(waypoint.x, waypoint.y, 0.0)
        world.tick(1.0 / 30.0)
    assert world.lap_counter.laps == 0


def test_tick_moves_the_car_at_constant_speed_unless_paused():
    world = simulation(speed=90.0, start_direction=0.0)
    world.tick(1.0 / 30.0)
    assert world.car == (pytest.approx(3.0), 0.0, 0.0)
    world.is_paused = True
    car = world.car
    world.tick(1.0)
    world.steer(1.0)
    assert world.car == car


def test_car_placed_outside_the_walls_moves_to_the_nearest_position_inside():
    world = simulation()
    world.place_car(1e9, -1e9, 9.0)
    assert world.car == (390.0, -215.0, pytest.approx(9.0 - 2 * math.pi))


def test_added_waypoint_is_the_last_one_and_reset_removes_it():
    world = simulation()
    world.add_waypoint(10.0, 20.0)
    assert world.waypoints[-1] == (30, 10.0, 20.0) and len(world.waypoints) == 31
    with pytest.raises(ValueError, match="outside the walls"):
        world.add_waypoint(401.0, 0.0)
    world.tick(1.0)
    world.reset()
    assert (
        len(world.waypoints) == 30
        and world.car == (0.0, 0.0, CONFIG["start_direction"])
        and world.lap_counter.laps == 0
    )
