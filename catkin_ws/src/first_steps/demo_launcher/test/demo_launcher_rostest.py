#!/usr/bin/python3
"""Test the nodes of the demo together, by their topics, and by mouse and keys in the window."""

import contextlib
import math
import os
import statistics
import subprocess
import sys
import unittest
from pathlib import Path

import rospy
import rostest
from std_msgs.msg import Bool, UInt32
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from sdc_common.processes import wait_until
from sdc_testing import MessageListener

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "qt_interface" / "test"))
from window_control import find_window, qt_display

LIMIT_SECONDS = 60.0
POINTS = 10
STEP = 300.0 / 30.0  # u a tick, from the speed below and the rate in config/world.yaml
PARAMETERS = "{ellipse_width: 240.0, ellipse_height: 160.0, waypoint_count: 10, speed: 300.0}"
# Without the legend (240 pixels on the right) and the status bar (about 26 pixels)
MIDDLE = (1120 - 240) // 2, (680 - 26) // 2


def start(*command, environment=None):
    pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen(command, env=environment or os.environ, **pipe)


class DemoTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("demo_test")
        cls.closing = contextlib.ExitStack()
        # The display has the size of the window, so the window fills it.
        cls.display = cls.closing.enter_context(qt_display(1120, 680))
        command = "roslaunch", "demo_launcher", "demo.launch", f"world_parameters:={PARAMETERS}"
        cls.demo = start(*command, environment=cls.display.environment)
        cls.waypoints = MessageListener("/world_waypoints", Waypoints)
        cls.car = MessageListener("/car_position", CarPosition, lambda msg: math.isfinite(msg.x))
        cls.targets = MessageListener("/target_waypoint", Waypoint)
        cls.sensed = MessageListener("/sensed_waypoints", Waypoints)
        cls.laps = MessageListener("/lap_count", UInt32)
        cls.paused = MessageListener("/paused", Bool)
        cls.targets.wait_for(seconds=LIMIT_SECONDS)

    @classmethod
    def tearDownClass(cls):
        if cls.demo.poll() is None:
            cls.demo.terminate()
            cls.demo.communicate(timeout=LIMIT_SECONDS)
        cls.closing.close()

    def position(self):
        return self.car.messages[-1]

    def is_at_start(self):
        return self.position().x == self.position().y == 0.0

    def count(self):
        return len(self.waypoints.messages[-1].waypoints)

    def is_paused(self):
        return self.paused.messages[-1].data

    def do_until(self, condition, action, what):
        """Repeat the action: the window may be visible before its connections exist."""
        for _ in range(3):
            action()
            with contextlib.suppress(TimeoutError):
                return wait_until(condition, LIMIT_SECONDS / 6, what)
        return self.fail(f"timeout while waiting for {what}")

    def press_until(self, condition, key, what):
        self.do_until(condition, lambda: self.display.xdotool("key", key), what)

    def carry(self, from_x, from_y, to_x, to_y):
        # An earlier attempt may have panned the view: show the whole field again.
        self.display.xdotool("key", "f")
        self.display.xdotool("mousemove", from_x, from_y, "mousedown", 1)
        self.display.xdotool("mousemove", to_x, to_y, "mouseup", 1)

    def test_car_drives_laps_and_nodes_refuse_messages_that_are_not_finite(self):
        msg = self.waypoints.wait_for(seconds=LIMIT_SECONDS)
        self.assertEqual(msg._connection_header["latching"], "1")
        self.assertEqual([point.idx for point in msg.waypoints], list(range(POINTS)))
        for topic, message in (
            ("/cmd", SteeringCommand(math.nan)),
            ("/world/place_car", CarPosition(x=math.nan)),
            ("/world/add_waypoint", Waypoint(y=math.nan)),
            ("/car_position", CarPosition(x=math.inf)),
        ):
            # Latched: the nodes may connect later than the listeners of this test.
            rospy.Publisher(topic, type(message), latch=True, queue_size=10).publish(message)
        before, repeated = self.laps.messages[-1].data, len(self.waypoints.messages)
        self.laps.wait_for(lambda msg: msg.data >= before + 2, LIMIT_SECONDS)
        self.waypoints.wait_for(seconds=LIMIT_SECONDS, after=repeated)
        targets = [msg.idx for msg in self.targets.messages]
        steps = {(after - before) % POINTS for before, after in zip(targets, targets[1:])}
        self.assertEqual(steps, {1})
        places = [(msg.x, msg.y) for msg in self.car.messages]
        # On a busy machine, a message may be lost between two steps.
        self.assertAlmostEqual(statistics.median(map(math.dist, places, places[1:])), STEP)

    def test_headless_demo_has_no_window(self):
        nodes = start("roslaunch", "--nodes", "demo_launcher", "demo.launch", "headless:=true")
        self.assertEqual(nodes.communicate()[0].split(), ["/world", "/driverless"])

    def test_mouse_and_keys_reach_the_world(self):
        find_window(self.display, "First steps")
        MessageListener("/world/pause", Bool).wait_for_publisher(LIMIT_SECONDS)
        self.press_until(self.is_paused, "space", "the pause")
        self.press_until(self.is_at_start, "r", "the car at its start")
        x, y = MIDDLE
        self.do_until(
            lambda: self.count() > POINTS,
            lambda: self.display.click(x, y + 100),
            "a waypoint where the mouse clicked",
        )
        added = self.waypoints.messages[-1].waypoints[POINTS]
        self.assertEqual(added.idx, POINTS)
        self.assertLess(abs(added.x), 15.0)
        self.assertTrue(-120.0 < added.y < -70.0, added)
        self.press_until(lambda: self.count() == POINTS, "r", "the reset")
        self.assertTrue(self.is_paused(), "the reset does not end the pause")

        place = rospy.Publisher("/world/place_car", CarPosition, latch=True, queue_size=10)
        near, seen, cars = [0, 1, POINTS - 1], len(self.sensed.messages), len(self.car.messages)
        place.publish(x=120.0, y=0.0, direction=0.0)
        self.sensed.wait_for(lambda msg: [p.idx for p in msg.waypoints] == near, after=seen)
        self.car.wait_for(lambda msg: msg.x == 120.0, after=cars)
        self.press_until(self.is_at_start, "r", "the car at its start")
        direction = self.position().direction
        self.do_until(
            lambda: self.position().x > 150.0,
            lambda: self.carry(x, y, x + 200, y - 50),
            "the car where the mouse released it",
        )
        self.assertTrue(30.0 < self.position().y < 70.0, self.position())
        self.assertAlmostEqual(self.position().direction, direction)
        self.assertEqual(self.count(), POINTS, "carrying adds no waypoint")
        self.press_until(lambda: not self.is_paused(), "space", "the end of the pause")

    def test_node_that_cannot_start_ends_with_one_line(self):
        no_screen = {
            name: text
            for name, text in os.environ.items()
            if name not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
        }
        for package, argument, words in (
            ("world", "_field_width:=-3.0", "parameter ~field_width is -3.0: give a number above"),
            (
                "qt_interface",
                "_frame_rate:=60.0",
                "there is no screen: set DISPLAY, or launch with",
            ),
        ):
            node = f"{package}_node.py"
            command = "rosrun", package, node, f"__name:=bad_{package}", argument
            ended = start(*command, environment=no_screen)
            output, _ = ended.communicate(timeout=LIMIT_SECONDS)
            self.assertEqual(ended.returncode, 1, output)
            (line,) = output.strip().splitlines()
            self.assertIn("FATAL", line)
            self.assertIn(words, line)

    def test_window_that_is_closed_ends_the_launch(self):
        find_window(self.display, "First steps")
        self.display.xdotool("key", "q")
        output, _ = self.demo.communicate(timeout=LIMIT_SECONDS)
        self.assertNotIn("Traceback", output)
        # The world names the first of the topics: it says this once a second at most.
        for words in ("lap 1 completed", "not finite; send numbers", "a message on /car_position"):
            self.assertIn(words, output)


if __name__ == "__main__":
    rostest.rosrun("demo_launcher", "demo_launcher_test", DemoTest, sys.argv)
