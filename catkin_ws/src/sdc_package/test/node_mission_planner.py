#!/usr/bin/python3
"""The mission planner publishes its route, latched, and refuses a bad file with one line."""

import re
import subprocess
import tempfile
import unittest

import rospy
import rostest
from sdc_package.msg import Path

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_testing import MessageListener


class MissionPlannerTest(unittest.TestCase):
    def test_late_subscriber_receives_the_route(self):
        expected = load_waypoints(rospy.get_param("/mission_planner/waypoints_path"))
        for _ in range(2):
            path = MessageListener("/planner/mission_waypoints", Path).wait_for()
            self.assertEqual(len(path.waypoints), len(expected))
            self.assertAlmostEqual(path.waypoints[50].x, expected[50, 0], places=4)
            self.assertAlmostEqual(path.waypoints[50].y, expected[50, 1], places=4)

    def run_node(self, *arguments):
        return subprocess.run(
            ["rosrun", "sdc_package", "mission_planner.py", "__name:=bad", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
            check=False,
        )

    def test_bad_file_ends_the_node_with_one_line(self):
        """As those of test_waypoint_file.py do."""
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write("0,0\n1,x\n")
            file.flush()
            done = self.run_node("_waypoints_path:=" + file.name)
        self.assertEqual(done.returncode, 1, done.stdout)
        (line,) = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout).strip().splitlines()
        self.assertIn(f"{file.name}, row 2: y is 'x'", line)
        rospy.delete_param("/bad/waypoints_path")

    def test_missing_parameter_ends_the_node_with_its_name(self):
        done = self.run_node()
        self.assertEqual(done.returncode, 1)
        self.assertIn("/bad/waypoints_path is missing", done.stdout)


if __name__ == "__main__":
    rospy.init_node("mission_planner_test")
    rostest.rosrun("sdc_package", "mission_planner", MissionPlannerTest)
