"""Test the sources of waypoints, the sensor, the lap counter and the complete simulation."""

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from world.car import Field
from world.laps import LapCounter
from world.rules import read_settings
from world.simulation import Simulation
from world.waypoints import Waypoint, check_route, ellipse, load_csv

PACKAGE = Path(__file__).resolve().parents[1]
CONFIG = yaml.safe_load((PACKAGE / "config" / "world.yaml").read_text())
SQUARE = [
    Waypoint(0, 0.0, 0.0),
    Waypoint(1, 100.0, 0.0),
    Waypoint(2, 100.0, 100.0),
    Waypoint(3, 0.0, 100.0),
]


def simulation(**overrides):
    return Simulation(read_settings({**CONFIG, **overrides}))


@given(st.integers(2, 500), st.floats(1.0, 1e4), st.floats(1.0, 1e4))
def test_ellipse_points_are_on_the_ellipse_in_order_of_idx(count, width, height):
    points = ellipse(count, width, height)
    assert [point.idx for point in points] == list(range(count))
    assert points[0][1:] == (width / 2.0, 0.0)
    for _, x, y in points:
        assert (2.0 * x / width) ** 2 + (2.0 * y / height) ** 2 == pytest.approx(1.0)


def test_packaged_csv_file_is_a_valid_route():
    path = str(PACKAGE / "data" / "figure_eight.csv")
    assert len(simulation(waypoints_path=path).waypoints) == 36


@pytest.mark.parametrize(
    "text, points",
    [
        ("1,2\n3,4\n", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("x,y\n1,2\n3,4", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("1,2,9.5,fast\n\n3,4,1,slow\n\n", [(0, 1.0, 2.0), (1, 3.0, 4.0)]),
        ("\ufeffidx, x, y\r\n7,1,2\r\n7,3,4\r\n", [(7, 1.0, 2.0), (7, 3.0, 4.0)]),
        ("y,x\n1,2\n", [(0, 2.0, 1.0)]),
        ("", []),
        ("x,y\n", []),
    ],
)
def test_load_csv_reads_valid_files(tmp_path, text, points):
    path = tmp_path / "route.csv"
    path.write_text(text, encoding="utf-8")
    assert load_csv(str(path)) == points


@pytest.mark.parametrize(
    "text, row, fix",
    [
        ("1,2\n3,nan\n", 2, "x,y in plain numbers"),
        ("x,y\n1,2\ninf,4\n", 3, "x,y in plain numbers"),
        ("1,2\n3\n", 2, "x,y in plain numbers"),
        ("1,2\nthree,4\n", 2, "x,y in plain numbers"),
        ("a,b\n1,2\n", 1, "call the columns x,y"),
        ("idx,x,y\n-1,2,3\n", 2, "0..65535"),
        ("idx,x,y\n65536,2,3\n", 2, "0..65535"),
        ("idx,x,y\n1.5,2,3\n", 2, "0..65535"),
    ],
)
def test_error_for_an_invalid_row_names_it_and_the_fix(tmp_path, text, row, fix):
    path = tmp_path / "route.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        load_csv(str(path))
    message = str(error.value)
    assert message.startswith(f"{path}: row {row}: ") and fix in message and "\n" not in message


@pytest.mark.parametrize(
    "make",
    [lambda path: None, lambda path: path.mkdir(), lambda path: path.write_bytes(b"\xff\xfe\x00")],
)
def test_error_for_an_unreadable_file_names_the_parameter(tmp_path, make):
    make(tmp_path / "route.csv")
    with pytest.raises(ValueError, match=r"^waypoints_path .*route\.csv: .*give a readable CSV"):
        load_csv(str(tmp_path / "route.csv"))


@pytest.mark.parametrize(
    "points, fix",
    [
        ([], "at least 2"),
        ([Waypoint(0, 1.0, 1.0)], "at least 2"),
        ([Waypoint(0, 0.0, 0.0), Waypoint(1, 400.5, 0.0)], "outside the walls"),
        ([Waypoint(0, 0.0, -226.0), Waypoint(1, 0.0, 0.0)], "outside the walls"),
        ([Waypoint(0, 0.0, 0.0), Waypoint(1, 20.0, 0.0)], "spread them"),
    ],
)
def test_check_route_refuses_routes_without_possible_laps(points, fix):
    with pytest.raises(ValueError, match=f"^route.csv: .*{fix}"):
        check_route(points, Field(800.0, 450.0, 20.0), 25.0, "route.csv")


def test_simulation_refuses_an_ellipse_larger_than_the_field():
    with pytest.raises(ValueError, match=r"~ellipse_width 900.*outside the walls"):
        simulation(ellipse_width=900.0)


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
