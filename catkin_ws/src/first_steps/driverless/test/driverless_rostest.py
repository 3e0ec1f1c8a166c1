#!/usr/bin/python3
"""Test the driver node: publish positions and points, receive steering commands."""

import math
import queue
import sys
import unittest

import rospy
import rostest
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from sdc_common.processes import wait_until
from sdc_testing import wait_for_subscriber

LIMIT_SECONDS = 30.0
SQUARE = [(0, 0.0, 0.0), (1, 100.0, 0.0), (2, 100.0, 100.0), (3, 0.0, 100.0)]


def to_message(points):
    return Waypoints([Waypoint(x=x, y=y, idx=idx) for idx, x, y in points])


class DriverlessTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("driverless_test")
        cls.commands, cls.targets = queue.Queue(), queue.Queue()
        rospy.Subscriber("/cmd", SteeringCommand, cls.commands.put, queue_size=100)
        targets = rospy.Subscriber("/target_waypoint", Waypoint, cls.targets.put, queue_size=100)
        cls.map = rospy.Publisher("/world_waypoints", Waypoints, queue_size=10, latch=True)
        cls.sensed = rospy.Publisher("/sensed_waypoints", Waypoints, queue_size=10)
        cls.car = rospy.Publisher("/car_position", CarPosition, queue_size=10)
        for publisher in (cls.map, cls.sensed, cls.car):
            wait_for_subscriber(publisher, LIMIT_SECONDS)
        wait_until(targets.get_num_connections, LIMIT_SECONDS, "the node's targets")

        # The connection of /cmd takes a moment too: publish until a command arrives.
        def command():
            cls.car.publish(x=-900.0, y=0.0, direction=0.0)
            return not cls.commands.empty()

        wait_until(command, LIMIT_SECONDS, "a command on /cmd")

    def setUp(self):
        """Remove the commands that answer positions of an earlier test."""
        while True:
            try:
                self.commands.get(timeout=0.3)
            except queue.Empty:
                return

    def answer(self, x, y, direction):
        self.car.publish(x=x, y=y, direction=direction)
        return self.commands.get(timeout=LIMIT_SECONDS).delta_direction

    def answer_once_known(self, x, y, direction, expected):
        """Publish the position until the expected command arrives.

        Map and position use two connections and arrive in any order.
        """
        wait_until(
            lambda: abs(self.answer(x, y, direction) - expected) < 1e-9,
            LIMIT_SECONDS,
            f"the command {expected}",
        )

    def test_node_turns_to_the_next_point_and_publishes_the_target(self):
        self.map.publish(to_message(SQUARE))
        self.answer_once_known(-50.0, 0.0, 0.1, -0.05)  # half of the heading error, to point 0
        self.assertEqual(self.answer(-50.0, 0.0, 2.0), -0.2)  # max_turn from the launch file
        self.answer_once_known(0.0, 0.0, 0.1, -0.05)  # reached: the next is point 1
        self.answer_once_known(100.0, 0.0, math.pi / 2 + 0.1, -0.05)  # to point 2
        self.answer_once_known(100.0, 100.0, -math.pi + 0.1, -0.05)  # to point 3, across the wrap
        self.answer_once_known(0.0, 100.0, -math.pi / 2 - 0.1, 0.05)  # the first follows the last
        seen = [self.targets.get(timeout=LIMIT_SECONDS).idx for _ in range(5)]
        self.assertEqual(seen, [0, 1, 2, 3, 0])

    def test_node_refuses_non_finite_messages_and_drives_on(self):
        self.map.publish(to_message([(0, math.nan, 0.0)]))
        self.sensed.publish(to_message([(0, 0.0, math.inf)]))
        self.car.publish(x=math.nan, y=0.0, direction=0.0)
        self.car.publish(x=0.0, y=0.0, direction=math.inf)
        answer = self.answer(50.0, 50.0, 0.3)
        self.assertTrue(abs(answer) <= 0.2)


if __name__ == "__main__":
    rostest.rosrun("driverless", "driverless_test", DriverlessTest, sys.argv)
