#!/usr/bin/python3
"""Integration check: a stack drives under the master of this test; its report is checked."""

import os
import unittest

import rospy
import rostest

from sdc_sim.catkin_workspace import WorkspaceError
from sdc_sim.runner import CheckedDrive

GIVEN = ("stack", "workspace", "waypoints_path", "sync", "camera", "referee_options")
PATHS = ("workspace", "waypoints_path")
BOUNDS = {
    "max_cross_track_m": ("cross_track_max_m", 0.5),
    "rms_cross_track_m": ("cross_track_rms_m", 0.2),
}


class DriveTest(unittest.TestCase):
    def test_drive_meets_its_limits(self):
        parameters = rospy.get_param("~")
        # rostest changes the working directory; relative paths start where it was called.
        os.chdir(parameters["folder"])
        scenario = parameters["scenario"]
        given = {name: parameters[name] for name in GIVEN if parameters[name]}
        # With a workspace, the stack may also be a list of PACKAGE/NODE.
        paths = PATHS if "workspace" in given else (*PATHS, "stack")
        for name in given.keys() & set(paths):
            given[name] = os.path.abspath(os.path.expanduser(given[name]))
        report_path = os.path.abspath(os.path.expanduser(parameters["report"]))
        try:
            drive = CheckedDrive(scenario, report_path, given)
        except WorkspaceError as error:
            self.fail(str(error))
        for name, (metric, default) in BOUNDS.items():
            if parameters[name] or not scenario:
                bounds = drive.limits.setdefault("at_most", {})
                bounds[metric] = float(parameters[name] or default)
        lines = drive.run(parameters["wall_limit_s"])
        self.assertEqual(
            lines, [], "\n".join([f"limits violated, see {drive.report_path}", *lines])
        )


if __name__ == "__main__":
    rospy.init_node("drive_test")
    rostest.rosrun("sdc_sim", "drive_test", DriveTest)
