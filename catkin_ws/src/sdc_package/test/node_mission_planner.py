#!/usr/bin/python3
"""The mission planner publishes its route, latched, and refuses a bad file with one line."""

import os
import re
import subprocess
import tempfile
import unittest

import rospy
import rostest
from sdc_package.msg import Path

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_testing import MessageListener

# test_waypoint_file.py has more of them.
BAD_FILES = [
    ("missing", None, "No such file"),
    ("word", b"0,0\n1,x\n", "row 2: y is 'x'"),
    ("binary", bytes(range(128, 256)), "is not text"),
]


class MissionPlannerTest(unittest.TestCase):
    def test_late_subscriber_receives_the_route(self):
        expected = load_waypoints(rospy.get_param("/mission_planner/waypoints_path"))
        for _ in range(2):
            path = MessageListener("/planner/mission_waypoints", Path).wait_for()
            self.assertEqual(len(path.waypoints), len(expected))
            self.assertAlmostEqual(path.waypoints[50].x, expected[50, 0], places=4)
            self.assertAlmostEqual(path.waypoints[50].y, expected[50, 1], places=4)

    def test_bad_file_ends_the_node_with_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, content, part in BAD_FILES:
                with self.subTest(name):
                    path = os.path.join(folder, name.replace(" ", "_") + ".csv")
                    if content is not None:
                        with open(path, "wb") as file:
                            file.write(content)
                    done = subprocess.run(
                        [
                            "rosrun",
                            "sdc_package",
                            "mission_planner.py",
                            "__name:=bad",
                            "_waypoints_path:=" + path,
                        ],
                        stdout=subprocess.PIPE,
                        stderr=subprocess.STDOUT,
                        text=True,
                        timeout=60,
                        check=False,
                    )
                    self.assertEqual(done.returncode, 1, done.stdout)
                    lines = [
                        line
                        for line in re.sub(r"\x1b\[[0-9;]*m", "", done.stdout).splitlines()
                        if line.strip()
                    ]
                    self.assertEqual(len(lines), 1, done.stdout)
                    self.assertIn(path, lines[0])
                    self.assertIn(part, lines[0])

    def test_missing_parameter_ends_the_node_with_its_name(self):
        done = subprocess.run(
            ["rosrun", "sdc_package", "mission_planner.py", "__name:=bare"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
            check=False,
        )
        self.assertEqual(done.returncode, 1)
        self.assertIn("/bare/waypoints_path is missing", done.stdout)


if __name__ == "__main__":
    rospy.init_node("mission_planner_test")
    rostest.rosrun("sdc_package", "mission_planner", MissionPlannerTest)
