#!/usr/bin/env python3
"""The integration check: a stack drives under this test's own master, and its report is held against the limits."""

import os
import unittest

import rospy
import rostest

from sdc_sim.scenario.checked_drive import CheckedDrive

GIVEN = ("stack", "waypoints_path", "sync", "camera")
PATHS = ("stack", "waypoints_path")
BOUNDS = {
    "max_cross_track_m": ("cross_track_max_m", 0.5),
    "rms_cross_track_m": ("cross_track_rms_m", 0.2),
}


class DriveTest(unittest.TestCase):
    def test_drive(self):
        parameters = rospy.get_param("~")
        # Relative paths count from the folder that rostest was run in, which is not this test's own.
        os.chdir(parameters["folder"])
        scenario = parameters["scenario"]
        given = {
            name: os.path.abspath(os.path.expanduser(parameters[name]))
            if name in PATHS
            else parameters[name]
            for name in GIVEN
            if parameters[name]
        }
        drive = CheckedDrive(
            scenario, os.path.abspath(os.path.expanduser(parameters["report"])), given
        )
        for name, (figure, usual) in BOUNDS.items():
            if parameters[name] or not scenario:
                drive.limits.at_most[figure] = float(parameters[name] or usual)
        fell_short = drive.run(parameters["wall_limit_s"], stopped=rospy.is_shutdown)
        self.assertEqual(
            fell_short,
            [],
            "\n".join([f"the drive fell short, see {drive.report_path}", *fell_short]),
        )


if __name__ == "__main__":
    rospy.init_node("drive_test")
    rostest.rosrun("sdc_sim", "drive_test", DriveTest)
