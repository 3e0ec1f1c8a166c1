#!/usr/bin/env python3
"""A stack without stamps in lockstep: order decides; the test is the stack."""

import hashlib
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl

from sdc_common.testing.message_listener import MessageListener, wait_until

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000
LARGE = bytes(1_000_000)


class UnstampedTest(unittest.TestCase):
    def test_stack_without_stamps_starts_at_once_and_waits_for_no_timeout(self):
        # Some nodes wait for a time that is not zero before they publish or subscribe.
        wait_until(lambda: not rospy.Time.now().is_zero(), what="the time of the first tick")
        self.period = 1
        self.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        self.odometry = MessageListener(EGO + "/odometry", Odometry)
        rospy.Subscriber(EGO + "/odometry", Odometry, self.answer, tcp_nodelay=True)
        self.wait_for_ticks(300)
        self.period = 2
        self.wait_for_ticks(300)
        stamps = [odometry.header.stamp.to_nsec() // TICK_NS for odometry in self.odometry.messages]
        self.assertEqual(sorted(set(stamps)), list(range(1, stamps[-1] + 1)))

    def test_tick_waits_for_a_node_that_is_at_work(self):
        # The command comes at once; a planner that needs 20 ms would miss most of the ticks.
        self.period = 1
        self.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        self.odometry = MessageListener(EGO + "/odometry", Odometry)
        planned = []

        def plan(clock):
            limit_s = time.thread_time() + 0.02
            while time.thread_time() < limit_s:
                hashlib.sha256(LARGE)  # Other threads can run meanwhile.
            planned.append(clock.clock.to_nsec() // TICK_NS)

        # Not the odometry: rospy calls all callbacks of a topic one after another.
        planner = rospy.Subscriber("/clock", Clock, plan, queue_size=1, tcp_nodelay=True)
        self.addCleanup(planner.unregister)
        rospy.Subscriber(EGO + "/odometry", Odometry, self.answer, tcp_nodelay=True)
        wait_until(lambda: planned, what="the first path")
        self.wait_for_ticks(50)
        # The first two may overlap, and the first comes twice: the clock is latched.
        used = sorted(set(planned))
        self.assertGreaterEqual(len(used), 50)
        self.assertEqual(used, list(range(used[0], used[0] + len(used))))

    def answer(self, odometry):
        # A loop at a rate of its own does not answer the first odometry.
        tick = odometry.header.stamp.to_nsec() // TICK_NS
        if tick > 3 and tick % self.period == 0:
            self.command.publish(CarlaVehicleControl(throttle=0.3))

    def wait_for_ticks(self, ticks):
        last = self.odometry.wait_for().header.stamp if not self.odometry.messages else None
        last = last or self.odometry.messages[-1].header.stamp
        self.odometry.wait_for(
            lambda odometry: (odometry.header.stamp - last).to_nsec() >= ticks * TICK_NS, 60.0
        )


if __name__ == "__main__":
    rospy.init_node("unstamped_test")
    rostest.rosrun("sdc_sim", "unstamped_test", UnstampedTest)
