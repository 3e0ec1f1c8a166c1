#!/usr/bin/env python3
"""The planner, then the controller stop for 3 s at 10 m/s: the car brakes within 0.5 s of silence, and drives on afterwards."""

import math
import unittest

import rospy
import rostest
from faults import Watch, stopped

SILENCE_S = 3.0
BRAKES_WITHIN_S = 0.5


class SilenceTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.watch = Watch(rospy.get_param("~waypoints_path"))

    def silence(self, node):
        """Stop the node at full speed: the car brakes in time."""
        self.watch.wait_for_speed(above_mps=9.8)
        since = self.watch.now()
        with stopped(node):
            end = since + SILENCE_S
            self.watch.odometry.wait_for(
                lambda odometry: odometry.header.stamp.to_sec() > end, 60.0
            )
            braked, stood = self.watch.braking_since(since), self.watch.stopped_since(since)
        print(
            f"{node} silent: braking after {braked:.2f} s, standing after {stood} s of simulated time"
        )
        self.assertLessEqual(braked, BRAKES_WITHIN_S, node)
        self.assertLess(self.watch.series(since)[-1, 1], 5.0, node)

    def test_planner_then_controller(self):
        self.silence("/local_planner")
        self.silence("/simple_controller")
        self.watch.wait_for(
            lambda x, y, _yaw, speed: (
                speed < 0.05 and math.dist((x, y), self.watch.route.points[-1]) < 2.0
            )
        )
        self.assertLess(self.watch.worst_error_m(), 0.5)
        print(f"worst error {self.watch.worst_error_m():.2f} m")


if __name__ == "__main__":
    rospy.init_node("silence_test")
    rostest.rosrun("sdc_sim", "silence_test", SilenceTest)
