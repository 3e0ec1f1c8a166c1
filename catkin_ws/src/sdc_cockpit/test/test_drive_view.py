"""What the page shows of the newest messages of the car, its sensors, its road and the topics."""

import json
import math
import struct
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from page_messages import receive
from sdc_msgs.msg import BaseWaypoint, LaneOffset, Path, SpeedReason
from sensor_msgs.msg import NavSatFix, NavSatStatus, PointCloud2
from std_msgs.msg import Header

from sdc_cockpit.drive_view import (
    LANE_OFFSET,
    MISSION,
    ODOMETRY,
    SPEED_DETAIL,
    SPEED_REASON,
    DriveView,
)
from sdc_cockpit.road_view import RoadView
from sdc_cockpit.sensor_view import EGO, GNSS, SensorView
from sdc_cockpit.topic_feeds import Feed
from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.ros.odometry import GROUND_TRUTH, odometry_message
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.message_conversion import point_cloud_message


@pytest.fixture
def view():
    return DriveView(lambda: 100.0, lambda: None)


def odometry(y_m=0.0):
    return odometry_message(rospy.Time(), (0.0, y_m, 0.0), (0.0, 0.0, 0.0))


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


FRONT = EGO + "/lidar/front/point_cloud"
PLANAR = EGO + "/lidar/planar/point_cloud"


def cloud(points):
    header = Header(0, rospy.Time(1), "frame")
    return point_cloud_message(np.array(points, np.float32), None, header)


def test_topics_are_those_of_the_default_bridge():
    names = BRIDGE_VERSIONS["0.9.3"].sensors
    used = {"/carla/ego_vehicle" + names[name].topic for name in ("gnss", "lidar", "planar_lidar")}
    assert {feed.topic for feed in SensorView().feeds} == used


def test_points_are_placed_with_the_car():
    view = SensorView()
    assert view.state((0.0, 0.0, 0.0)) == {"fixes": [], "points": []}
    receive(view, PLANAR, cloud([[5.0, 1.0, 0.0, 1.0]]))
    assert view.state(None)["points"] == []
    (point,) = view.state((10.0, 20.0, 0.5 * math.pi))["points"]
    assert point == pytest.approx([9.0, 27.35, 0.6], abs=0.01)


def test_large_scan_is_thinned():
    view = SensorView()
    receive(view, FRONT, cloud(np.ones((16_000, 4))))
    assert 300 < len(view.state((0.0, 0.0, 0.0))["points"]) <= 400


def test_only_fixes_are_shown():
    view = SensorView()
    receive(view, GNSS, NavSatFix(status=NavSatStatus(status=NavSatStatus.STATUS_NO_FIX)))
    latitude, longitude = geodetic_from_map(3.0, -4.0)
    receive(view, GNSS, NavSatFix(latitude=latitude, longitude=longitude))
    assert view.state(None)["fixes"] == [pytest.approx([3.0, -4.0], abs=0.01)]
    receive(view, GNSS, NavSatFix(latitude=math.nan, longitude=longitude))
    assert len(view.state(None)["fixes"]) == 1
    view.clear()
    assert view.state(None)["fixes"] == []


def test_scan_with_other_fields_is_not_shown():
    view = SensorView()
    receive(view, FRONT, PointCloud2(point_step=12, width=1, height=1, data=bytes(12)))
    assert view.state((0.0, 0.0, 0.0))["points"] == []


def message(number):
    return SimpleNamespace(_buff=struct.pack("<III", number, 1, 0) + b"rest")


def test_messages_without_a_header_are_counted():
    seen = []
    feed = Feed("/topic", callback=seen.append)
    for number in (7, 9):
        feed.receive(message(number))
    assert feed.count == 2
    assert feed.newest is seen[-1]


def test_messages_that_a_burst_dropped_are_counted():
    for feed in (Feed("/topic", rests=True), Feed("/topic", picture=True)):
        for number in (7, 9):
            feed.receive(message(number))
        assert feed.count == 9


# An eight: the route crosses itself in the middle at a right angle.
ANGLE = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
EIGHT = np.column_stack([40.0 * np.sin(ANGLE), 40.0 * np.sin(ANGLE) * np.cos(ANGLE)])


def test_cross_track_error_at_a_crossing_is_that_of_the_own_pass():
    road = RoadView(EIGHT)
    yaws = np.arctan2(*np.diff(EIGHT, axis=0).T[::-1])
    beside = EIGHT[: len(yaws)] + 0.5 * np.column_stack([-np.sin(yaws), np.cos(yaws)])
    errors = [road.cross_track_m(x, y, yaw) for (x, y), yaw in zip(beside.tolist(), yaws)]
    assert np.abs(np.array(errors) - 0.5).max() < 0.05


def test_car_that_is_placed_elsewhere_is_found_again():
    road = RoadView(EIGHT)
    road.cross_track_m(*EIGHT[10], 0.0)
    assert road.cross_track_m(*EIGHT[300], 0.0) == pytest.approx(0.0, abs=1e-6)


def test_road_is_drawn_from_flat_lists_of_numbers():
    road = json.loads(RoadView(EIGHT).to_json())
    assert len(road["route"]) == 2 * len(EIGHT)
    assert len(road["surface"]) % 8 == len(road["edges"]) % 4 == len(road["dashes"]) % 4 == 0
    assert min(len(part) for part in road.values()) > 0
