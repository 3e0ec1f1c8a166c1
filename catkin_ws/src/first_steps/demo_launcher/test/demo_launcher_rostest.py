#!/usr/bin/python3
"""Test the complete demo, started with roslaunch."""

import os
import signal
import subprocess
import sys
import unittest
from pathlib import Path

import rosgraph
import rospy
import rostest
from std_msgs.msg import UInt32
from um_msgs.msg import Waypoint

from sdc_testing import MessageListener

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "qt_interface" / "test"))
from window_control import find_window, qt_display

LIMIT_SECONDS = 60.0
SMALL = (
    "world_parameters:="
    "{ellipse_width: 240.0, ellipse_height: 160.0, waypoint_count: 10, speed: 300.0}"
)


def launch(*arguments, environment=None):
    return subprocess.Popen(
        ["roslaunch", "demo_launcher", "demo.launch", *arguments],
        env=environment or os.environ,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


class DemoTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("demo_test")
        cls.master = rosgraph.Master("/demo_test")

    def nodes(self):
        """Return the names of all nodes that publish or subscribe."""
        return {
            node for topics in self.master.getSystemState() for _, nodes in topics for node in nodes
        }

    def await_start(self):
        """Wait until the world and the driver run.

        A node that is still starting prints a traceback on Ctrl-C.
        """
        MessageListener("/target_waypoint", Waypoint).wait_for(seconds=LIMIT_SECONDS)

    def stop(self, demo):
        demo.send_signal(signal.SIGINT)
        output, _ = demo.communicate(timeout=LIMIT_SECONDS)
        self.assertNotIn("Traceback", output)
        return output

    def test_headless_demo_drives_laps_without_a_window(self):
        demo = launch("headless:=true", SMALL)
        try:
            laps = MessageListener("/lap_count", UInt32)
            laps.wait_for(lambda msg: msg.data >= 2, LIMIT_SECONDS)
            self.assertTrue({"/world", "/driverless"} <= self.nodes())
            self.assertNotIn("/qt_interface", self.nodes())
        finally:
            output = self.stop(demo)
        self.assertIn("lap 1 completed", output)

    def test_closing_the_window_ends_the_launch(self):
        with qt_display() as display:
            demo = launch(environment=display.environment)
            try:
                find_window(display, "First steps")
                self.await_start()
                display.xdotool("key", "q")
                output, _ = demo.communicate(timeout=LIMIT_SECONDS)
            finally:
                if demo.poll() is None:
                    self.stop(demo)
            self.assertNotIn("Traceback", output)
            self.assertIn("qt_interface", output)


if __name__ == "__main__":
    rostest.rosrun("demo_launcher", "demo_launcher_test", DemoTest, sys.argv)
