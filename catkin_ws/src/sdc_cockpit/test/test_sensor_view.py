"""Points of the lidars and positions of the GNSS on the page."""

import math

import numpy as np
import pytest
import rospy
from page_messages import receive
from sensor_msgs.msg import NavSatFix, NavSatStatus, PointCloud2
from std_msgs.msg import Header

from sdc_cockpit.sensor_view import GNSS, LIDARS, SensorView
from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.message_conversion import point_cloud_message

FRONT, PLANAR = LIDARS


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
