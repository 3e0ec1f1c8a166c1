"""Speeds that traffic allows on the lane."""

import math

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_common.driving import DetectedObstacle
from sdc_perception.light_detection import GREEN, RED, YELLOW
from sdc_perception.light_tracker import TrackedLight
from sdc_perception.traffic_following import TrafficFollower, TrafficSettings

CAR = (0.0, 0.0, 0.0)
FRONT_M, POLE_BEYOND_M, SPARE_M = 2.35, 4.0, 0.4


@pytest.fixture
def follower():
    parameters = {
        **node_config("sdc_package", "local_planner"),
        **node_config("sdc_perception", "lane_follower"),
        **node_config("sdc_perception", "traffic_follower"),
    }
    return TrafficFollower(TrafficSettings.read(parameters.__getitem__))


@pytest.fixture
def rows():
    """A straight lane from 3 m behind to 32 m ahead of the car, at 10 m/s."""
    x = np.arange(-3.0, 32.0, 0.5)
    return np.column_stack([x, np.zeros(len(x)), np.full(len(x), 10.0)])


def body(x_m, y_m=0.0, speed_mps=0.0, yaw_rad=0.0, kind="car"):
    size = (4.7, 2.0) if kind == "car" else (0.5, 0.5)
    return DetectedObstacle(x_m, y_m, yaw_rad, *size, speed_mps, 1, kind)


def light(state, line_m, left_m=-2.7):
    return TrackedLight(1, state, line_m + POLE_BEYOND_M, left_m)


def stop_m(rows):
    """Return where the path stops, infinite if it does not."""
    slow = rows[rows[:, 2] == 0.0, 0]
    return slow[0] if len(slow) else math.inf


def test_free_lane_keeps_its_speeds(follower, rows):
    assert follower.limited(rows, CAR, 10.0, [], []) is rows
    far = follower.limited(rows, CAR, 10.0, [body(20.0, 4.0)], [light(GREEN, 20.0)])
    assert far == pytest.approx(rows)


def test_car_stops_behind_a_standing_car(follower, rows):
    limited = follower.limited(rows, CAR, 10.0, [body(30.0)], [])
    assert stop_m(limited) == pytest.approx(30.0 - 2.35 - 5.0 - SPARE_M - FRONT_M, abs=0.5)
    assert limited[:, :2] == pytest.approx(rows[:, :2])


@pytest.mark.parametrize("state", [RED, YELLOW])
def test_front_of_the_car_stops_before_the_line(follower, rows, state):
    front_m = stop_m(follower.limited(rows, CAR, 8.0, [], [light(state, 28.0)])) + FRONT_M
    assert 26.0 <= front_m <= 27.0


def test_light_of_another_road_or_behind_is_ignored(follower, rows):
    others = [light(RED, 20.0, 2.7), light(RED, 20.0, -8.0), light(RED, -2.0)]
    for other in others:
        assert follower.limited(rows, CAR, 8.0, [], [other]) == pytest.approx(rows)


def test_car_that_cannot_stop_for_yellow_drives_on(follower, rows):
    assert follower.limited(rows, CAR, 10.0, [], [light(YELLOW, 10.0)]) == pytest.approx(rows)
