#!/usr/bin/python3
"""Test the window node together with the world node, by mouse and keys on a virtual display."""

import contextlib
import os
import subprocess
import sys
import unittest
from pathlib import Path

import rospy
import rostest
from std_msgs.msg import Bool
from um_msgs.msg import CarPosition, Waypoints

from sdc_common.processes import wait_until

sys.path.insert(0, str(Path(__file__).resolve().parent))
from window_control import find_window, qt_display

LIMIT_SECONDS = 30.0
NAME = "First steps"


def run_window(environment, *arguments):
    return subprocess.Popen(
        ["rosrun", "qt_interface", "qt_interface_node.py", *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


class QtInterfaceTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("qt_interface_test")
        cls.latest = {}
        for topic, message_type in (
            ("/world_waypoints", Waypoints),
            ("/car_position", CarPosition),
            ("/paused", Bool),
        ):
            rospy.Subscriber(
                topic, message_type, lambda msg, topic=topic: cls.latest.__setitem__(topic, msg)
            )
        cls.pause_echo = rospy.Subscriber("/world/pause", Bool)
        wait_until(lambda: len(cls.latest) == 3, LIMIT_SECONDS, "the world")
        # The display has the size of the window, so the window fills it.
        cls.closing = contextlib.ExitStack()
        cls.display = cls.closing.enter_context(qt_display(1120, 680))

    @classmethod
    def tearDownClass(cls):
        cls.closing.close()

    def open_window(self):
        self.node = run_window(self.display.environment, "__name:=qt_interface")
        self.addCleanup(self.end_node)
        self.window = find_window(self.display, NAME)

    def end_node(self):
        if self.node.poll() is None:
            self.node.terminate()
        self.node.communicate(timeout=LIMIT_SECONDS)

    def count(self):
        return len(self.latest["/world_waypoints"].waypoints)

    def car_is_at_start(self):
        car = self.latest["/car_position"]
        return car.x == car.y == 0.0

    def middle_of_the_field(self):
        # Without the legend (240 pixels on the right) and the status bar (about 26 pixels)
        return (1120 - 240) // 2, (680 - 26) // 2

    def do_until(self, condition, action, what):
        """Repeat the action until the condition holds.

        The window may be visible before its connections exist, so the first action may be lost.
        """
        for _ in range(3):
            action()
            with contextlib.suppress(TimeoutError):
                return wait_until(condition, LIMIT_SECONDS / 3, what)
        return self.fail(f"timeout while waiting for {what}")

    def click_until(self, condition, x, y, what):
        self.do_until(condition, lambda: self.display.click(x, y), what)

    def press_until(self, condition, key, what):
        self.do_until(condition, lambda: self.display.xdotool("key", key), what)

    def carry(self, from_x, from_y, to_x, to_y):
        # An earlier attempt may have panned the view: show the whole field again.
        self.display.xdotool("key", "f")
        self.display.xdotool("mousemove", from_x, from_y, "mousedown", 1)
        self.display.xdotool("mousemove", to_x, to_y, "mouseup", 1)

    def test_mouse_and_keys_reach_the_world(self):
        self.open_window()
        wait_until(self.pause_echo.get_num_connections, LIMIT_SECONDS, "the connections")
        self.press_until(lambda: self.latest["/paused"].data, "space", "the pause")
        # Eight seconds after its start the car would be where the mouse clicks.
        self.press_until(self.car_is_at_start, "r", "the car at its start")
        x, y = self.middle_of_the_field()
        self.click_until(
            lambda: self.count() > 30, x, y + 100, "a waypoint where the mouse clicked"
        )
        added = self.latest["/world_waypoints"].waypoints[30]
        self.assertEqual(added.idx, 30)
        self.assertLess(abs(added.x), 15.0)
        self.assertTrue(-120.0 < added.y < -70.0, added)
        self.press_until(lambda: self.count() == 30, "r", "the reset")
        self.assertTrue(self.latest["/paused"].data, "the reset does not end the pause")
        start = self.latest["/car_position"]
        self.do_until(
            lambda: self.latest["/car_position"].x > 150.0,
            lambda: self.carry(x, y, x + 200, y - 50),
            "the car where the mouse released it",
        )
        carried = self.latest["/car_position"]
        self.assertTrue(30.0 < carried.y < 70.0, carried)
        self.assertAlmostEqual(carried.direction, start.direction)
        self.assertEqual(self.count(), 30, "carrying adds no waypoint")
        self.press_until(lambda: not self.latest["/paused"].data, "space", "the end of the pause")

    def test_node_exits_with_one_error_line_without_a_screen(self):
        screens = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
        environment = {name: text for name, text in os.environ.items() if name not in screens}
        node = run_window(environment, "__name:=bad_window")
        output, _ = node.communicate(timeout=LIMIT_SECONDS)
        self.assertEqual(node.returncode, 1, output)
        (line,) = output.strip().splitlines()
        self.assertIn("there is no screen: set DISPLAY, or launch with headless:=true", line)


if __name__ == "__main__":
    rostest.rosrun("qt_interface", "qt_interface_test", QtInterfaceTest, sys.argv)
