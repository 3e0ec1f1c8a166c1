#!/usr/bin/python3
"""Basic control: the controller answers each odometry with a constant command, without a path."""

import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl

from sdc_testing import MessageListener, wait_for_subscriber


class BasicControlTest(unittest.TestCase):
    def test_odometry_is_answered_with_the_constant_command(self):
        publisher = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=1)
        command = MessageListener("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl)
        wait_for_subscriber(publisher)
        command.wait_for()  # The stop without odometry shows that commands arrive.
        odometry = Odometry()
        odometry.header.stamp = rospy.Time.now()
        odometry.pose.pose.orientation.w = 1.0
        publisher.publish(odometry)
        answer = command.wait_for(lambda message: message.throttle > 0.0)
        self.assertEqual(answer.header.stamp, odometry.header.stamp)
        parameters = rospy.get_param("/simple_controller")
        self.assertAlmostEqual(answer.throttle, parameters["basic_throttle"], places=6)
        self.assertAlmostEqual(answer.steer, parameters["basic_steer"], places=6)
        self.assertEqual(answer.brake, 0.0)


if __name__ == "__main__":
    rospy.init_node("basic_control_test")
    rostest.rosrun("sdc_package", "basic_control", BasicControlTest)
