#!/usr/bin/env python3
"""The workshop's first drive: constant, gentle, at every odometry, without any path."""

import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl

from sdc_common.testing.message_listener import MessageListener, wait_for_subscriber


class BasicControlTest(unittest.TestCase):
    def test_constant_command(self):
        publisher = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=1)
        command = MessageListener("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl)
        wait_for_subscriber(publisher)
        command.wait_for()  # the stop for want of odometry: it proves that commands arrive
        odometry = Odometry()
        odometry.header.stamp = rospy.Time.now()
        odometry.pose.pose.orientation.w = 1.0
        publisher.publish(odometry)
        answer = command.wait_for(lambda message: message.throttle > 0.0)
        self.assertEqual(answer.header.stamp, odometry.header.stamp)
        self.assertAlmostEqual(
            answer.throttle, rospy.get_param("/simple_controller/basic_throttle"), places=6
        )
        self.assertAlmostEqual(
            answer.steer, rospy.get_param("/simple_controller/basic_steer"), places=6
        )
        self.assertEqual(answer.brake, 0.0)


if __name__ == "__main__":
    rospy.init_node("basic_control_test")
    rostest.rosrun("sdc_package", "basic_control", BasicControlTest)
