#!/usr/bin/python3
"""Test the world node through its topics; the test of the simulation shows its rules."""

import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from std_msgs.msg import Bool, Empty, UInt32
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from sdc_testing import MessageListener, wait_for_subscriber

LIMIT_SECONDS = 30.0
STEP = 120.0 / 30.0  # u a tick, from speed and rate in config/world.yaml


class Listener(MessageListener):
    """A listener that also waits for new messages."""

    def next(self, condition=lambda _msg: True):
        """Return the next new message that meets the condition."""
        return self.wait_for(condition, LIMIT_SECONDS, after=len(self.messages))


class WorldTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("world_test")
        cls.waypoints = Listener("/world_waypoints", Waypoints)
        cls.car = Listener("/car_position", CarPosition)
        cls.sensed = Listener("/sensed_waypoints", Waypoints)
        cls.laps = Listener("/lap_count", UInt32)
        cls.paused = Listener("/paused", Bool)
        cls.cmd = rospy.Publisher("/cmd", SteeringCommand, queue_size=10)
        cls.place = rospy.Publisher("/world/place_car", CarPosition, queue_size=10)
        cls.add = rospy.Publisher("/world/add_waypoint", Waypoint, queue_size=10)
        cls.pause = rospy.Publisher("/world/pause", Bool, queue_size=10)
        cls.reset = rospy.Publisher("/world/reset", Empty, queue_size=10)
        for publisher in (cls.cmd, cls.place, cls.add, cls.pause, cls.reset):
            wait_for_subscriber(publisher, LIMIT_SECONDS)
        cls.car.wait_for(seconds=LIMIT_SECONDS)

    def setUp(self):
        self.pause.publish(False)
        self.reset.publish()
        self.car.next(lambda msg: msg.y == 0.0 and msg.x < 40.0 and msg.direction == 0.0)
        self.waypoints.wait_for(lambda msg: len(msg.waypoints) == 12)

    def test_waypoints_follow_the_parameters_and_are_latched_and_repeated(self):
        msg = Listener("/world_waypoints", Waypoints).wait_for(seconds=LIMIT_SECONDS)
        self.assertEqual(msg._connection_header["latching"], "1")
        points = msg.waypoints
        self.assertEqual([point.idx for point in points], list(range(12)))
        self.assertEqual((points[0].x, points[0].y), (300.0, 0.0))
        self.assertAlmostEqual(points[3].y, 150.0)
        self.waypoints.next()

    def test_car_moves_by_the_same_step_in_each_tick(self):
        first = len(self.car.messages)
        self.car.wait_for(seconds=LIMIT_SECONDS, after=first + 20)
        positions = self.car.messages[first : first + 20]
        for before, after in zip(positions, positions[1:]):
            self.assertAlmostEqual(after.x - before.x, STEP)
            self.assertEqual((after.y, after.direction), (0.0, 0.0))

    def test_node_refuses_non_finite_messages_and_cmd_turns_the_car(self):
        self.cmd.publish(delta_direction=math.nan)
        self.cmd.publish(delta_direction=math.inf)
        self.place.publish(x=math.nan, y=0.0, direction=0.0)
        self.add.publish(x=0.0, y=math.nan)
        self.cmd.publish(delta_direction=1.0)
        self.car.next(lambda msg: abs(msg.direction - 1.0) < 1e-9)
        self.assertTrue(
            all(math.isfinite(msg.x + msg.y + msg.direction) for msg in self.car.messages)
        )

    def set_paused(self, paused):
        # The node answers a change once: the answer may come before the next line here.
        before = len(self.paused.messages)
        self.pause.publish(paused)
        self.paused.wait_for(lambda msg: msg.data == paused, LIMIT_SECONDS, after=before)

    def test_pause_stops_the_car_and_the_sensor_reports_the_points_in_its_range(self):
        self.set_paused(True)
        self.place.publish(x=200.0, y=0.0, direction=0.0)
        for _ in range(5):
            self.assertEqual(self.car.next(lambda msg: msg.x >= 200.0).x, 200.0)
        self.sensed.next(lambda msg: [p.idx for p in msg.waypoints] == [0, 1, 2, 10, 11])
        self.set_paused(False)
        self.car.next(lambda msg: msg.x > 200.0)

    def test_node_exits_with_one_error_line_for_invalid_parameters_and_files(self):
        path = Path(tempfile.mkdtemp()) / "nan.csv"
        path.write_text("x,y\n1,2\n3,nan\n")
        for argument, words in (
            ("_field_width:=-3.0", "parameter ~field_width is -3.0: give a number above 0"),
            (f"_waypoints_path:={path}", f"{path}: row 3: '3,nan' is not a point; write"),
        ):
            result = subprocess.run(
                ["rosrun", "world", "world_node.py", "__name:=bad_world", argument],
                check=False,
                timeout=60,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            rospy.set_param("/bad_world/field_width", 800.0)
            self.assertEqual(result.returncode, 1, result.stdout)
            (line,) = result.stdout.strip().splitlines()
            self.assertIn("FATAL", line)
            self.assertIn(words, line)


if __name__ == "__main__":
    rostest.rosrun("world", "world_test", WorldTest, sys.argv)
