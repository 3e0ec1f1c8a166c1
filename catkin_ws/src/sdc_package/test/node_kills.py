#!/usr/bin/python3
"""Nodes of the car are killed during one drive: it stops or is unaffected, and completes."""

import json
import os
import shutil
import unittest

import rospy
import rostest
from faults import TIMEOUT_S, DriveRecord, kill, pid_of, wait_for_restart

from sdc_common.processes import wait_until

# Maximum simulated time from the kill to the stop: 0.5 s until the car brakes, and the braking.
STOPS_WITHIN_S = 4.0
# The planned drive brakes more gently than this.
HARD_BRAKE = 0.4


class KillsTest(unittest.TestCase):
    def setUp(self):
        self.drive = DriveRecord(rospy.get_param("~waypoints_path"))

    def check_stop(self, node):
        """Kill a node: the car stops in time, unless the node restarts before, and resumes."""
        self.drive.wait_for_speed(above_mps=6.0)
        since = self.drive.now()
        wait_for_restart(node, kill(node))
        self.drive.wait_for_speed(above_mps=6.0)
        braked, stopped = (
            self.drive.braking_since(since, HARD_BRAKE),
            self.drive.stopped_since(since),
        )
        print(f"{node} killed: brakes after {braked} s, stops after {stopped} s (simulated time)")
        if stopped is not None:
            self.assertLess(stopped, STOPS_WITHIN_S, node)

    def test_drive_completes_after_each_node_of_the_car_was_killed(self):
        # On a straight: without a controller the car brakes with the wheels as they are.
        self.drive.wait_for(lambda x, _y, _yaw, _speed: x > 5.0)
        self.check_stop("/simple_controller")
        since, camera = self.drive.now(), kill("/camera")
        self.drive.wait_for(lambda _x, y, _yaw, _speed: y > 15.0)
        self.drive.wait_for(lambda x, y, _yaw, _speed: 5.0 < x < 20.0 and abs(y) < 2.0)
        self.assertGreater(self.drive.series(since)[:, 1].min(), 3.0, "the car drives on")
        self.check_stop("/local_planner")
        wait_for_restart("/camera", camera)
        self.check_completion()

    def check_completion(self):
        path = rospy.get_param("~report")
        wait_until(lambda: os.path.exists(path), 120.0, f"the report {path}")
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        wait_until(lambda: pid_of("/referee") is None, TIMEOUT_S, "the end of the referee")
        shutil.rmtree(os.path.dirname(path))
        self.assertEqual(report["status"], "completed", report)
        self.assertLess(self.drive.max_error_m(), 0.5)
        self.assertLess(report["time_ratio"], 1.6, "no lap is driven twice")
        print(report, f"maximum error {self.drive.max_error_m():.2f} m")


if __name__ == "__main__":
    rospy.init_node("kills_test")
    rostest.rosrun("sdc_package", "kills_test", KillsTest)
