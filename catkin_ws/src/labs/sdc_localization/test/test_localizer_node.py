"""The callbacks of the node, without a ROS master."""

import math
from pathlib import Path

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import Imu, JointState, NavSatFix

from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.ros.odometry import pose_and_speed
from sdc_localization.localizer import Localizer
from sdc_testing import load_script

SCRIPT = Path(__file__).resolve().parents[1] / "scripts" / "localizer.py"
LANE = np.column_stack([np.arange(0.0, 101.0), np.zeros(101)])
WHEELS = ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"]


class Published(list):
    def publish(self, message):
        self.append(message)


@pytest.fixture
def node(settings):
    found = object.__new__(load_script(str(SCRIPT)).LocalizerNode)
    found.localizer, found.waypoints = Localizer(settings), LANE
    found.radius_m = 0.35
    found.publisher, found.tf_publisher = Published(), Published()
    return found


def stamped(message, tick):
    message.header.stamp = rospy.Time(1, tick * 50_000_000)
    return message


def wheels(tick, speed=3.5):
    return stamped(JointState(name=WHEELS, velocity=[speed / 0.35] * 4), tick)


def fix(tick, x, y, status=0):
    message = stamped(NavSatFix(), tick)
    message.status.status = status
    message.latitude, message.longitude = (
        geodetic_from_map(x, y) if status >= 0 else (math.nan, math.nan)
    )
    message.position_covariance[0] = 1.0
    return message


def test_nothing_is_published_before_the_first_fix(node):
    node.answer(wheels(0), stamped(Imu(), 0), None, None)
    node.answer(wheels(1), stamped(Imu(), 1), fix(1, 0.0, 0.0, status=-1), None)
    assert node.publisher == []
    node.answer(wheels(2), stamped(Imu(), 2), fix(2, 10.0, 0.5), None)
    (message,) = node.publisher
    assert message.header.stamp == rospy.Time(1, 100_000_000)
    assert (message.header.frame_id, message.child_frame_id) == ("map", "ego_vehicle")
    assert pose_and_speed(message) == pytest.approx((10.0, 0.0, 0.0, 3.5), abs=1e-6)
    covariance = np.reshape(message.pose.covariance, (6, 6))[np.ix_((0, 1, 5), (0, 1, 5))]
    assert (covariance == node.localizer.estimate.covariance).all()
    assert np.count_nonzero(message.pose.covariance) == np.count_nonzero(covariance)
    assert node.tf_publisher[0].transforms[0].child_frame_id == "ego_vehicle"


def test_bad_messages_are_refused_and_the_node_goes_on(node):
    node.answer(stamped(JointState(), 0), stamped(Imu(), 0), fix(0, 10.0, 0.0), None)
    uncertain = fix(1, 10.0, 0.0)
    uncertain.position_covariance[0] = 0.0
    node.answer(wheels(1), stamped(Imu(), 1), uncertain, None)
    assert node.publisher == []
    node.answer(wheels(2), stamped(Imu(), 2), fix(2, 10.0, 0.0), None)
    assert len(node.publisher) == 1
