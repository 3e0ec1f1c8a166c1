#!/usr/bin/env python3
"""Test the world node through its topics."""

import math
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rospy
import rostest
from std_msgs.msg import Bool, Empty, UInt32
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

LIMIT_SECONDS = 30.0
STEP = 120.0 / 30.0  # u a tick, from speed and rate in config/world.yaml


class Listener:
    """A subscriber that stores all messages and waits for one that meets a condition."""

    def __init__(self, topic, message_type):
        self.topic = topic
        self.messages = []
        self.changed = threading.Condition()
        rospy.Subscriber(topic, message_type, self.on_message, queue_size=1000, tcp_nodelay=True)

    def on_message(self, msg):
        with self.changed:
            self.messages.append(msg)
            self.changed.notify_all()

    def wait_for(self, condition, since=0):
        """Return the first message from index `since` on that meets the condition."""
        return self._wait(lambda: [msg for msg in self.messages[since:] if condition(msg)][:1])

    def wait_for_last(self, condition):
        """Wait until the last message meets the condition, for topics that publish a state once."""
        return self._wait(lambda: [msg for msg in self.messages[-1:] if condition(msg)])

    def _wait(self, find):
        end = time.monotonic() + LIMIT_SECONDS
        with self.changed:
            while True:
                found = find()
                if found:
                    return found[0]
                if not self.changed.wait(max(end - time.monotonic(), 0.0)):
                    raise AssertionError(
                        f"{self.topic}: timeout; last of {len(self.messages)} messages: "
                        f"{self.messages[-1:]}"
                    )

    def next(self, condition=lambda _msg: True):
        """Return the next new message that meets the condition."""
        return self.wait_for(condition, len(self.messages))


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
        end = time.monotonic() + LIMIT_SECONDS
        for publisher in (cls.cmd, cls.place, cls.add, cls.pause, cls.reset):
            while not publisher.get_num_connections():
                assert time.monotonic() < end, f"no subscriber of {publisher.name}"
                time.sleep(0.01)
        cls.car.wait_for(lambda _msg: True)

    def setUp(self):
        self.pause.publish(False)
        self.reset.publish()
        self.car.next(lambda msg: msg.y == 0.0 and msg.x < 40.0 and msg.direction == 0.0)
        self.waypoints.wait_for(lambda msg: len(msg.waypoints) == 12)

    def test_waypoints_follow_the_parameters_and_are_latched(self):
        late = Listener("/world_waypoints", Waypoints)
        msg = late.wait_for(lambda _msg: True)
        self.assertEqual(msg._connection_header["latching"], "1")
        points = msg.waypoints
        self.assertEqual([point.idx for point in points], list(range(12)))
        self.assertEqual((points[0].x, points[0].y), (300.0, 0.0))
        self.assertAlmostEqual(points[3].y, 150.0)

    def test_waypoints_are_published_at_least_every_three_seconds(self):
        times = []
        for _ in range(3):
            self.waypoints.next()
            times.append(time.monotonic())
        self.assertLess(times[2] - times[0], 2 * 3.0)

    def test_car_moves_by_the_same_step_thirty_times_a_second(self):
        begin, first = time.monotonic(), len(self.car.messages)
        self.car.wait_for(lambda _msg: len(self.car.messages) > first + 60)
        self.assertGreater(time.monotonic() - begin, 60 / 30.0 * 0.8)
        self.assertLess(time.monotonic() - begin, 60 / 30.0 * 3.0)
        positions = self.car.messages[first : first + 60]
        for before, after in zip(positions, positions[1:]):
            self.assertAlmostEqual(after.x - before.x, STEP)
            self.assertEqual((after.y, after.direction), (0.0, 0.0))

    def test_car_bounces_off_the_wall(self):
        self.place.publish(x=380.0, y=10.0, direction=0.0)
        back = self.car.next(lambda msg: msg.x > 350.0 and abs(msg.direction) > 3.0)
        self.assertAlmostEqual(back.direction, math.pi)
        self.assertLessEqual(max(msg.x for msg in self.car.messages), 390.0)

    def test_cmd_adds_to_the_direction_and_wraps(self):
        self.cmd.publish(delta_direction=2.0)
        self.car.next(lambda msg: abs(msg.direction - 2.0) < 1e-9)
        self.cmd.publish(delta_direction=2.0)
        self.car.next(lambda msg: abs(msg.direction - (4.0 - 2.0 * math.pi)) < 1e-9)

    def test_node_refuses_non_finite_messages_and_the_car_drives_on(self):
        self.cmd.publish(delta_direction=math.nan)
        self.cmd.publish(delta_direction=math.inf)
        self.place.publish(x=math.nan, y=0.0, direction=0.0)
        self.add.publish(x=0.0, y=math.nan)
        self.cmd.publish(delta_direction=1.0)
        self.car.next(lambda msg: abs(msg.direction - 1.0) < 1e-9)
        self.assertTrue(
            all(math.isfinite(msg.x + msg.y + msg.direction) for msg in self.car.messages)
        )

    def test_sensor_reports_the_points_in_range_of_each_position(self):
        self.pause.publish(True)
        self.paused.wait_for_last(lambda msg: msg.data)
        self.place.publish(x=200.0, y=0.0, direction=0.0)
        self.car.next(lambda msg: msg.x == 200.0)
        near = [
            p.idx
            for p in self.waypoints.messages[-1].waypoints
            if math.hypot(p.x - 200.0, p.y) <= 150.0
        ]
        self.assertEqual(near, [0, 1, 2, 10, 11])
        self.sensed.next(lambda msg: sorted(p.idx for p in msg.waypoints) == near)
        self.place.publish(x=0.0, y=0.0, direction=0.0)
        self.sensed.next(lambda msg: sorted(p.idx for p in msg.waypoints) == [3, 9])

    def test_pause_stops_the_car_and_is_published(self):
        self.pause.publish(True)
        self.paused.wait_for_last(lambda msg: msg.data)
        # An older position may arrive after the pause message: they use two connections.
        still = self.car.next(lambda msg: msg == self.car.messages[-2])
        for _ in range(5):
            self.assertEqual(self.car.next(), still)
        self.pause.publish(False)
        self.paused.wait_for_last(lambda msg: not msg.data)
        self.car.next(lambda msg: msg != still)

    def test_car_placed_outside_moves_to_the_nearest_position_inside(self):
        self.pause.publish(True)
        self.paused.wait_for_last(lambda msg: msg.data)
        self.place.publish(x=5000.0, y=-5000.0, direction=7.0)
        msg = self.car.next(lambda msg: msg.x == 390.0)
        self.assertEqual(msg.y, -215.0)
        self.assertAlmostEqual(msg.direction, 7.0 - 2.0 * math.pi)

    def test_added_waypoint_is_published_and_one_outside_is_refused(self):
        self.add.publish(x=900.0, y=0.0)
        self.add.publish(x=10.0, y=20.0)
        points = self.waypoints.next(lambda msg: len(msg.waypoints) > 12).waypoints
        self.assertEqual([(p.idx, p.x, p.y) for p in points[12:]], [(12, 10.0, 20.0)])
        self.reset.publish()
        self.waypoints.next(lambda msg: len(msg.waypoints) == 12)

    def run_bad(self, *arguments):
        return subprocess.run(
            ["rosrun", "world", "world_node.py", "__name:=bad_world", *arguments],
            check=False,
            timeout=60,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def test_node_exits_with_one_error_line_for_invalid_parameters_and_files(self):
        folder = tempfile.mkdtemp()
        files = {"nan.csv": "x,y\n1,2\n3,nan\n", "one.csv": "1,2\n", "outside.csv": "0,0\n900,0\n"}
        for name, text in files.items():
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        good = {"_field_width": "800.0", "_waypoint_count": "30", "_waypoints_path": "''"}
        for argument, value, words in (
            ("_field_width", "-3.0", "parameter ~field_width is -3.0: give a number above 0"),
            (
                "_waypoint_count",
                "1",
                "parameter ~waypoint_count is 1: give a whole number within 2..65536",
            ),
            (
                "_waypoints_path",
                f"{folder}/nan.csv",
                f"{folder}/nan.csv: row 3: '3,nan' is not a point; write",
            ),
            (
                "_waypoints_path",
                f"{folder}/one.csv",
                f"{folder}/one.csv: 1 waypoint(s); a lap needs at least 2",
            ),
            (
                "_waypoints_path",
                f"{folder}/outside.csv",
                "waypoint 1 at (900, 0) is outside the walls",
            ),
        ):
            result = self.run_bad(
                *(f"{name}:={setting}" for name, setting in {**good, argument: value}.items())
            )
            lines = [line for line in result.stdout.splitlines() if line.strip()]
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertEqual(len(lines), 1, result.stdout)
            self.assertIn("FATAL", lines[0])
            self.assertIn(words, lines[0])


if __name__ == "__main__":
    rostest.rosrun("world", "world_test", WorldTest, sys.argv)
