"""Speeds of the path along a lane."""

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_perception.lane_curve import STEP_M, LaneCurve
from sdc_perception.lane_following import FollowingSettings, lane_path, stopping_path
from sdc_perception.lane_tracker import TrackedLane


@pytest.fixture
def settings():
    return FollowingSettings.read(node_config("sdc_perception", "lane_follower").__getitem__)


def lane(curvature=0.0, visible_m=40.0, confidence=1.0):
    curve = LaneCurve(-6.0, 0.0, 0.0, np.full(17, curvature))
    curvatures = np.full(len(curve.s_m), curvature)
    return TrackedLane(0.0, 0.0, curvature, confidence, visible_m, -6.0, curve.points_m, curvatures)


def at_car(path, settings):
    return path[round(settings.behind_m / STEP_M), 2]


def test_straight_lane_is_driven_at_the_planned_speed(settings):
    path = lane_path(lane(), settings)
    assert at_car(path, settings) == pytest.approx(10.0)
    assert path[-1, 2] == 0.0
    assert path[0, 0] < -2.0


@pytest.mark.parametrize("visible_m", [5.0, 10.0, 15.0])
def test_car_can_stop_within_the_visible_distance(settings, visible_m):
    speed = at_car(lane_path(lane(visible_m=visible_m), settings), settings)
    assert speed**2 / (2.0 * 2.5) <= visible_m + STEP_M
    assert speed > 0.9 * (2.0 * 2.5 * (visible_m - STEP_M)) ** 0.5


def test_bend_is_driven_with_the_lateral_acceleration(settings):
    path = lane_path(lane(curvature=0.1), settings)
    assert at_car(path, settings) == pytest.approx((3.0 / 0.1) ** 0.5, rel=0.01)


@pytest.mark.parametrize(
    ("confidence", "share"), [(1.0, 1.0), (0.6, 1.0), (0.4, 0.5), (0.2, 0.0), (0.1, 0.0)]
)
def test_car_slows_down_and_stops_as_confidence_falls(settings, confidence, share):
    path = lane_path(lane(confidence=confidence), settings)
    assert at_car(path, settings) == pytest.approx(10.0 * share)


def test_path_without_a_lane_stops_ahead():
    path = stopping_path(1.0, 2.0, np.pi / 2.0)
    assert path == pytest.approx(np.array([[1.0, 2.0, 0.0], [1.0, 4.0, 0.0]]))
