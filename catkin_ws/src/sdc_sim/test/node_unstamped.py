#!/usr/bin/python3
"""A stack without stamps in lockstep: order decides; the test is the stack."""

import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl

from sdc_common.processes import wait_until
from sdc_testing import MessageListener

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000


class UnstampedTest(unittest.TestCase):
    def test_first_command_answers_a_tick_and_a_tick_without_one_ends_after_the_timeout(self):
        # Some nodes wait for a time that is not zero before they publish or subscribe.
        wait_until(lambda: not rospy.Time.now().is_zero(), what="the time of the first tick")
        self.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        odometry = MessageListener(EGO + "/odometry", Odometry)
        rospy.Subscriber(EGO + "/odometry", Odometry, self.answer, tcp_nodelay=True)
        odometry.wait_for(lambda message: message.header.stamp.to_nsec() >= 160 * TICK_NS, 60.0)
        stamps = [message.header.stamp.to_nsec() // TICK_NS for message in odometry.messages]
        self.assertEqual(sorted(set(stamps)), list(range(1, stamps[-1] + 1)))

    def answer(self, odometry):
        tick = odometry.header.stamp.to_nsec() // TICK_NS
        if tick > 3 and tick % 50:
            self.command.publish(CarlaVehicleControl(throttle=0.3))


if __name__ == "__main__":
    rospy.init_node("unstamped_test")
    rostest.rosrun("sdc_sim", "unstamped_test", UnstampedTest)
