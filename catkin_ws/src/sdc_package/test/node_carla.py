#!/usr/bin/python3
"""The nodes drive in a world with the topics of a newer CARLA bridge."""

import unittest

import rospy
import rostest
from carla_msgs.msg import CarlaEgoVehicleControl
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from sdc_package.odometry import pose_and_speed
from sdc_testing import MessageListener

EGO = "/carla/hero"


class CarlaTest(unittest.TestCase):
    def test_car_drives_and_receives_pictures(self):
        command = MessageListener(EGO + "/vehicle_control_cmd", CarlaEgoVehicleControl)
        odometry = MessageListener(EGO + "/odometry", Odometry)
        mask = MessageListener("/camera/lane_mask", Image)
        driven = odometry.wait_for(lambda message: pose_and_speed(message)[0] > 20.0, seconds=60.0)
        self.assertLess(abs(pose_and_speed(driven)[1]), 0.5, "the car stays on its lane")
        mask.wait_for()
        first = odometry.messages[0].header.stamp
        sent = command.wait_for(
            lambda message: message.throttle > 0.0 and message.header.stamp >= first
        )
        self.assertEqual((sent.gear, sent.manual_gear_shift), (1, False))
        # A bridge in synchronous mode waits for the command with the stamp of its odometry.
        self.assertIn(sent.header.stamp, [message.header.stamp for message in odometry.messages])

    def test_no_topic_has_the_old_name(self):
        names = [name for name, _ in rospy.get_published_topics()]
        self.assertEqual([name for name in names if name.startswith("/carla/ego_vehicle/")], [])


if __name__ == "__main__":
    rospy.init_node("carla_test")
    rostest.rosrun("sdc_package", "carla_test", CarlaTest)
