#!/usr/bin/python3
"""A suspended planner or controller makes the car brake in time; it resumes afterwards."""

import unittest

import rospy
import rostest
from faults import DriveRecord, suspended

SUSPENDED_S = 3.0
# After 0.3 to 0.4 s on a quiet machine, on which the nodes are never late.
BRAKES_WITHIN_S = 1.0
# The planned drive brakes more gently than this.
HARD_BRAKE = 0.4


class SilenceTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drive = DriveRecord(rospy.get_param("~waypoints_path"))

    def check_suspended(self, node):
        """Suspend the node at full speed: the car brakes in time."""
        self.drive.wait_for_speed(above_mps=9.8)
        since = self.drive.now()
        with suspended(node):
            end = since + SUSPENDED_S
            self.drive.odometry.wait_for(
                lambda odometry: odometry.header.stamp.to_sec() > end, 60.0
            )
            braked, stopped = (
                self.drive.braking_since(since, HARD_BRAKE),
                self.drive.stopped_since(since),
            )
        print(f"{node} suspended: brakes after {braked} s, stops after {stopped} s")
        self.assertIsNotNone(braked, node)
        self.assertLessEqual(braked, BRAKES_WITHIN_S, node)
        self.assertLess(self.drive.series(since)[-1, 1], 5.0, node)

    def test_car_brakes_and_resumes_when_planner_or_controller_is_suspended(self):
        self.check_suspended("/local_planner")
        self.check_suspended("/simple_controller")
        self.drive.wait_for_speed(above_mps=6.0)
        self.assertLess(self.drive.max_error_m(), 0.5)
        print(f"maximum error {self.drive.max_error_m():.2f} m")


if __name__ == "__main__":
    rospy.init_node("silence_test")
    rostest.rosrun("sdc_package", "silence_test", SilenceTest)
