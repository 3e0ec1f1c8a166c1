#!/usr/bin/env python3
"""Each node is killed in the middle of one drive: the car stops or is unaffected, the node comes back, the drive completes."""

import json
import os
import shutil
import unittest

import rospy
import rostest
from faults import PATIENCE_S, Watch, kill, pid_of, wait_for_return

from sdc_common.testing.message_listener import wait_until

# Simulated time from the kill until the car stands, at most: it notices within 0.5 s, and brakes.
STANDS_WITHIN_S = 4.0
# The planned drive brakes more gently than this.
HARD_BRAKE = 0.4


class KillsTest(unittest.TestCase):
    def setUp(self):
        self.watch = Watch(rospy.get_param("~waypoints_path"))

    def killed_unaffected(self, node):
        """The node comes back and the car has not braked for it."""
        self.watch.wait_for_speed(above_mps=5.0)
        since = self.watch.now()
        wait_for_return(node, kill(node))
        self.assertIsNone(self.watch.stopped_since(since), node)
        self.assertGreater(self.watch.series(since)[:, 1].min(), 3.0, node)

    def killed_stops(self, node):
        """The node comes back; the car either stood soon or drove on before it had to. Then it drives again."""
        self.watch.wait_for_speed(above_mps=6.0)
        since = self.watch.now()
        wait_for_return(node, kill(node))
        self.watch.wait_for_speed(above_mps=6.0)
        braked, stood = self.watch.braking_since(since, HARD_BRAKE), self.watch.stopped_since(since)
        print(
            f"{node} killed: braking after {braked} s, standing after {stood} s of simulated time"
        )
        if stood is not None:
            self.assertLess(stood, STANDS_WITHIN_S, node)

    def test_each_node_in_turn(self):
        for node in ("/mission_planner", "/camera", "/referee"):
            self.killed_unaffected(node)
        self.killed_world()
        self.killed_stops("/simple_controller")
        self.watch.wait_for(lambda _x, y, _yaw, _speed: y > 15.0)
        self.watch.wait_for(lambda x, y, _yaw, _speed: 5.0 < x < 20.0 and abs(y) < 2.0)
        self.killed_stops("/local_planner")
        self.complete()

    def killed_world(self):
        """The world stands while nobody moves it, and goes on at the very place."""
        self.watch.wait_for_speed(above_mps=6.0)
        dead = kill("/sim")
        wait_for_return("/sim", dead)
        before = self.watch.odometry.messages[-1]
        after = self.watch.odometry.wait_for(
            lambda odometry: odometry.header.stamp > before.header.stamp, PATIENCE_S
        )
        self.assertLess((after.header.stamp - before.header.stamp).to_sec(), 0.5)
        moved_m = (
            (after.pose.pose.position.x - before.pose.pose.position.x) ** 2
            + (after.pose.pose.position.y - before.pose.pose.position.y) ** 2
        ) ** 0.5
        self.assertLess(moved_m, 1.0)
        self.watch.wait_for_speed(above_mps=6.0)

    def complete(self):
        path = rospy.get_param("~report")
        wait_until(lambda: os.path.exists(path), 120.0, f"the report {path}")
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        wait_until(lambda: pid_of("/referee") is None, PATIENCE_S, "the end of the referee")
        shutil.rmtree(os.path.dirname(path))
        self.assertEqual(report["status"], "completed", report)
        self.assertFalse(self.watch.clock_went_back())
        self.assertLess(self.watch.worst_error_m(), 0.5)
        self.assertLess(report["time_ratio"], 1.6, "no lap was driven twice")
        print(report, f"worst error {self.watch.worst_error_m():.2f} m")


if __name__ == "__main__":
    rospy.init_node("kills_test")
    rostest.rosrun("sdc_sim", "kills_test", KillsTest)
