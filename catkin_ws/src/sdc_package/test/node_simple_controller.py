#!/usr/bin/python3
"""The controller answers each pair of odometry and path once, and stops when an input times out."""

import contextlib
import math
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_testing import MessageListener, wait_for_subscriber


def straight_path(speed=5.0, start=0.0):
    return LocalPath([Waypoint(start + x, 0.0, speed) for x in range(25)])


class SimpleControllerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.path = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=10)
        cls.odometry = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=10)
        cls.command = MessageListener("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl)
        wait_for_subscriber(cls.odometry)
        wait_for_subscriber(cls.path)
        cls.command.wait_for()  # The stop without odometry shows that commands arrive.

    def drive(self, y=0.0, yaw=0.0, speed=5.0, path=None, body_frame=True):
        """Publish pairs until one is answered; return the command.

        A path that arrives before its odometry may answer the one before; then the first pair waits
        for the second.
        """
        odometry = Odometry()
        odometry.pose.pose.position.x = 2.0
        odometry.pose.pose.position.y = y
        odometry.pose.pose.orientation.z = math.sin(yaw / 2)
        odometry.pose.pose.orientation.w = math.cos(yaw / 2)
        odometry.twist.twist.linear.x = speed if body_frame else 0.0
        odometry.twist.twist.linear.y = 0.0 if body_frame else speed
        stamps = []

        def is_answer(command):
            return command.header.stamp in stamps and not self.stops(command)

        for _ in range(20):
            odometry.header.stamp = rospy.Time.now()
            stamps.append(odometry.header.stamp)
            self.odometry.publish(odometry)
            self.path.publish(path or straight_path())
            with contextlib.suppress(TimeoutError):
                return self.command.wait_for(
                    is_answer, 1.0, after=max(0, len(self.command.messages) - 50)
                )
        raise TimeoutError(f"none of {len(stamps)} pairs was answered")

    def drive_until(self, condition, seconds=15.0, **arguments):
        """Publish pairs until a command meets the condition: the jerk limit slows the pedals."""
        limit = time.monotonic() + seconds
        while True:
            command = self.drive(**arguments)
            if condition(command):
                return command
            self.assertLess(time.monotonic(), limit, f"the last command was\n{command}")

    @staticmethod
    def stops(command):
        """Return whether this is the command of a stop, which may come between two tests."""
        return command.brake == 0.5 and command.header.stamp == rospy.Time(0)

    def test_twist_in_the_map_frame_is_accepted(self):
        """The CARLA bridge 0.9.3 publishes the twist in this frame."""
        self.drive_until(lambda command: command.brake > 0.1, speed=15.0, body_frame=False)

    def test_bad_messages_are_refused_and_the_last_path_is_kept(self):
        self.drive()
        for points in (
            [],
            [Waypoint(0.0, 0.0, 1.0)],
            [Waypoint(math.nan, 0.0, 1.0), Waypoint(1.0, 0.0, 1.0)],
            [Waypoint(0.0, 0.0, 1.0)] * 3,
            [Waypoint(0.0, 0.0, -1.0), Waypoint(1.0, 0.0, -1.0)],
        ):
            self.path.publish(LocalPath(points))
        nan = Odometry()
        nan.header.stamp = rospy.Time.now()
        nan.pose.pose.orientation.w = 1.0
        nan.pose.pose.position.x = math.nan
        self.odometry.publish(nan)
        command = self.drive(y=1.0)
        self.assertTrue(all(map(math.isfinite, (command.throttle, command.steer, command.brake))))
        self.assertGreater(command.steer, 0.05)

    def test_controller_brakes_when_odometry_times_out_and_resumes(self):
        self.drive()
        before = len(self.command.messages)
        self.assertEqual(self.command.wait_for(self.stops, after=before).throttle, 0.0)
        self.drive_until(lambda command: command.throttle > 0.3, speed=0.0)

    def test_late_subscriber_receives_the_last_command(self):
        self.drive()
        late = MessageListener("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl)
        self.assertTrue(late.wait_for() in self.command.messages)


if __name__ == "__main__":
    rospy.init_node("simple_controller_test")
    rostest.rosrun("sdc_package", "simple_controller", SimpleControllerTest)
