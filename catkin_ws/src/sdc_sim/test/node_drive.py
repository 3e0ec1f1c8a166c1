#!/usr/bin/env python3
"""Waits for the report of the drive that is under way and holds it against its limits."""
import json
import os
import unittest

import rospy
import rostest

from sdc_package.listening import wait_until


class DriveTest(unittest.TestCase):
    def test_drive(self):
        path = rospy.get_param("~report")
        wait_until(lambda: os.path.exists(path), rospy.get_param("~wall_limit_s"), f"the report {path}")
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        self.assertEqual(report["status"], "completed", report)
        self.assertLess(report["cross_track_max_m"], rospy.get_param("~max_cross_track_m"), report)
        self.assertLess(report["cross_track_rms_m"], rospy.get_param("~rms_cross_track_m"), report)


if __name__ == "__main__":
    rospy.init_node("drive_test")
    rostest.rosrun("sdc_sim", "drive_test", DriveTest)
