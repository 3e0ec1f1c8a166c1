"""The show node without ROS: what it publishes for RViz; rviz.test shows it."""

import io
import math
from pathlib import Path

import pytest
import rospy
from sdc_msgs.msg import BaseWaypoint, LocalPath, Waypoint
from sdc_msgs.msg import Path as Mission
from sensor_msgs.msg import NavSatFix, NavSatStatus
from visualization_msgs.msg import Marker

from sdc_common.configuration import node_config
from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_testing.offline_node import offline_node

SCRIPT = Path(__file__).resolve().parents[1] / "scripts" / "show.py"


def received(message):
    """Return a message as a subscriber of any type receives it."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    found = rospy.AnyMsg().deserialize(buffer.getvalue())
    found._connection_header = {"type": message._type, "message_definition": message._full_text}
    return found


@pytest.fixture
def show(monkeypatch):
    config = {**node_config("sdc_sim", "show"), "path_rate_hz": 1e9}
    return offline_node(monkeypatch, str(SCRIPT), "Show", config)


def test_mission_is_shown_as_route_and_road(show):
    mission = Mission([BaseWaypoint(x, 2.0) for x in range(50)])
    show.receive["/planner/mission_waypoints"](received(mission))
    (route,), (road,) = show.published["/show/route"], show.published["/show/road"]
    assert route.header.frame_id == "map"
    places = [(pose.pose.position.x, pose.pose.position.y) for pose in route.poses]
    assert places == [(x, 2.0) for x in range(50)]
    assert [marker.ns for marker in road.markers] == ["grass", "asphalt", "lines"]
    for marker in road.markers:
        assert (marker.header.frame_id, marker.action) == ("map", Marker.ADD)
        assert len(marker.points) > 5
    assert {"/show/route", "/show/road", "/show/car"} <= show.latched


def test_fixes_are_shown_as_dots_in_the_map(show):
    receive = show.receive["/carla/ego_vehicle/gnss/front/gnss"]
    receive(NavSatFix(status=NavSatStatus(status=NavSatStatus.STATUS_NO_FIX)))
    latitude, longitude = geodetic_from_map(12.0, -7.0)
    receive(NavSatFix(latitude=latitude, longitude=longitude))
    (marker,) = show.published["/show/gnss"]
    assert marker.header.frame_id == "map"
    (point,) = marker.points
    assert math.hypot(point.x - 12.0, point.y + 7.0) < 1e-3


def test_local_path_is_coloured_by_speed(show):
    receive = show.receive["/planner/local_waypoints"]
    receive(received(LocalPath([Waypoint(x, 0.0, 10.0 - 5.0 * x) for x in (0.0, 1.0, 2.0)])))
    receive(received(LocalPath()))
    marker, removed = show.published["/show/local_path"]
    assert (marker.header.frame_id, marker.type) == ("map", Marker.LINE_STRIP)
    assert [point.x for point in marker.points] == [0.0, 1.0, 2.0]
    assert marker.colors[0].g > marker.colors[0].r
    assert marker.colors[2].r > marker.colors[2].g
    assert removed.action == Marker.DELETE


def test_car_is_as_long_as_the_vehicle(show):
    show.instance.run()
    (message,) = show.published["/show/car"]
    markers = message.markers
    assert {marker.header.frame_id for marker in markers} == {"ego_vehicle"}
    assert all(marker.frame_locked for marker in markers)
    assert len({(marker.ns, marker.id) for marker in markers}) == len(markers)
    ends = [(one.pose.position.x, 0.5 * one.scale.x) for one in markers]
    length_m = max(x + half for x, half in ends) - min(x - half for x, half in ends)
    assert length_m == pytest.approx(4.72, abs=0.05)
