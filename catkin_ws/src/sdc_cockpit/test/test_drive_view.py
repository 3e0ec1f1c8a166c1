"""What the page shows of the newest messages."""

import pytest
from nav_msgs.msg import Odometry
from page_messages import receive
from sdc_msgs.msg import BaseWaypoint, LaneOffset, Path, SpeedReason

from sdc_cockpit.drive_view import (
    LANE_OFFSET,
    MISSION,
    ODOMETRY,
    SPEED_DETAIL,
    SPEED_REASON,
    DriveView,
)
from sdc_common.ros.odometry import GROUND_TRUTH


@pytest.fixture
def view():
    return DriveView(lambda: 100.0, lambda: None)


def odometry(y_m=0.0):
    message = Odometry()
    message.pose.pose.position.y = y_m
    message.pose.pose.orientation.w = 1.0
    return message


@pytest.mark.parametrize(
    ("reason", "shown"),
    [("traffic_light", "stops at a traffic light"), ("own_words", "own_words")]
    + [("x" * 99, "x" * 80)],
)
def test_reason_is_shown_in_words(view, reason, shown):
    receive(view, ODOMETRY, odometry(), 5.0)
    receive(view, SPEED_REASON, SpeedReason(reason=reason), 4.8)
    assert view.state()["reason"] == shown


def test_reason_names_because_of_whom(view):
    receive(view, ODOMETRY, odometry(), 5.0)
    receive(view, SPEED_DETAIL, SpeedReason(reason="yields to car 17 at junction 4"), 4.8)
    assert view.state()["reason"] is None
    receive(view, SPEED_REASON, SpeedReason(reason="right_of_way"), 4.8)
    shown = "gives way at a junction: yields to car 17 at junction 4"
    assert view.state()["reason"] == shown


def test_old_reason_is_not_shown(view):
    receive(view, SPEED_REASON, SpeedReason(reason="bend"), 5.0)
    assert view.state()["reason"] is None
    receive(view, ODOMETRY, odometry(), 5.9)
    assert view.state()["reason"] is not None
    receive(view, ODOMETRY, odometry(), 6.1)
    assert view.state()["reason"] is None


def test_distance_from_the_route_is_the_true_one_where_the_car_estimates_its_pose(view):
    route = Path(waypoints=[BaseWaypoint(float(x), 0.0) for x in range(-5, 20)])
    receive(view, MISSION, route, 5.0)
    receive(view, ODOMETRY, odometry(2.0), 5.0)
    assert view.state()["cross_track"] == pytest.approx(2.0)
    receive(view, GROUND_TRUTH, odometry(0.5), 5.0)
    assert view.state()["cross_track"] == pytest.approx(0.5)
    assert view.state()["pose"][1] == pytest.approx(2.0)


def test_offset_that_the_camera_measures_is_shown_while_it_sees_a_lane(view):
    receive(view, ODOMETRY, odometry(), 5.0)
    assert view.state()["lane_offset"] is None
    receive(view, LANE_OFFSET, LaneOffset(offset_m=-0.25), 4.9)
    assert view.state()["lane_offset"] == -0.25
    receive(view, ODOMETRY, odometry(), 6.0)
    assert view.state()["lane_offset"] is None
