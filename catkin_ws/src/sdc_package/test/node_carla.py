#!/usr/bin/env python3
"""The software drives a world that is dressed as a newer CARLA bridge, and sees its road."""

import unittest

import rospy
import rostest
from carla_msgs.msg import CarlaEgoVehicleControl
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from sdc_common.testing.message_listener import MessageListener
from sdc_package.odometry import pose_and_speed

EGO = "/carla/hero"


class CarlaTest(unittest.TestCase):
    def test_car_drives_and_sees(self):
        command = MessageListener(EGO + "/vehicle_control_cmd", CarlaEgoVehicleControl)
        odometry = MessageListener(EGO + "/odometry", Odometry)
        mask = MessageListener("/camera/lane_mask", Image)
        driven = odometry.wait_for(lambda message: pose_and_speed(message)[0] > 20.0, seconds=60.0)
        self.assertLess(abs(pose_and_speed(driven)[1]), 0.5, "it keeps to its lane")
        mask.wait_for()
        heard = odometry.messages[0].header.stamp
        sent = command.wait_for(
            lambda message: message.throttle > 0.0 and message.header.stamp >= heard
        )
        self.assertEqual((sent.gear, sent.manual_gear_shift), (1, False))
        # Each command says which odometry it answers: what a bridge in synchronous mode waits for.
        self.assertIn(sent.header.stamp, [message.header.stamp for message in odometry.messages])

    def test_nothing_is_left_at_the_old_names(self):
        names = [name for name, _ in rospy.get_published_topics()]
        self.assertEqual([name for name in names if name.startswith("/carla/ego_vehicle/")], [])


if __name__ == "__main__":
    rospy.init_node("carla_test")
    rostest.rosrun("sdc_sim", "carla_test", CarlaTest)
