#!/usr/bin/python3
"""Invalid messages on the topics of a running drive have no effect on the ride."""

import copy
import math
import time
import unittest

import numpy as np
import rospy
import rostest
from faults import EGO, DriveRecord, pid_of
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_common.processes import wait_until
from sdc_package.odometry import pose_and_speed
from sdc_testing import wait_for_subscriber

NODES = ("/mission_planner", "/local_planner", "/simple_controller", "/sim")
INJECTED = "injected"
# A little more than the maximum of an undisturbed drive.
MAX_ERROR_M = 0.3
MAX_BRAKING_MPS2 = 3.5
MAX_TURNING_MPS2 = 4.0


class TopicsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.odometry = rospy.Publisher(EGO + "/odometry", Odometry, queue_size=10)
        cls.path = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=10)
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=10
        )
        cls.drive = DriveRecord(rospy.get_param("~waypoints_path"), ignored_frame=INJECTED)
        for publisher in (cls.odometry, cls.path, cls.command):
            wait_for_subscriber(publisher, 60.0)
        cls.pids = {node: wait_until(lambda node=node: pid_of(node), 60.0, node) for node in NODES}

    def test_invalid_messages_have_no_effect_on_the_ride(self):
        for name, inject in (
            ("odometry that jumps", self.jumps),
            ("a path behind the car", self.path_behind),
            ("paths at 1 kHz", self.thousand_paths),
            ("a second controller", self.second_controller),
        ):
            with self.subTest(name):
                self.drive.wait_for_speed(above_mps=6.0)
                since = self.drive.now()
                inject()
                until = self.drive.now() + 0.5
                self.drive.odometry.wait_for(
                    lambda odometry, until=until: odometry.header.stamp.to_sec() > until
                )
                self.check_ride(since)
        self.assertLess(self.drive.max_error_m(), MAX_ERROR_M)
        self.assertEqual({node: pid_of(node) for node in NODES}, self.pids, "no node was restarted")

    def check_ride(self, since):
        """Check that the car has stayed on its route and has driven gently since a time."""
        time_s, speed = self.drive.series(since).T
        turning = self.drive.turning(since)
        braking = (np.diff(speed) / np.diff(time_s)).min()
        print(
            f"    maximum error {self.drive.max_error_m(since):.3f} m, braking {braking:.1f}, "
            f"turning {np.abs(turning).max():.1f} m/s^2"
        )
        self.assertLess(self.drive.max_error_m(since), MAX_ERROR_M)
        self.assertGreater((np.diff(speed) / np.diff(time_s)).min(), -MAX_BRAKING_MPS2)
        self.assertLess(np.abs(turning).max(), MAX_TURNING_MPS2)
        for command in self.drive.commands.messages:
            if command.header.frame_id != INJECTED:
                self.assertTrue(
                    all(map(math.isfinite, (command.throttle, command.brake, command.steer)))
                )

    def copy_of_the_last(self):
        """Return an odometry like the last one, with a new stamp."""
        odometry = copy.deepcopy(self.drive.odometry.messages[-1])
        odometry.header.stamp += rospy.Duration(0.001)
        odometry.child_frame_id = INJECTED
        return odometry

    def jumps(self):
        for forward_m, left_m in (
            (50.0, 0.0),
            (-50.0, 0.0),
            (0.0, 50.0),
            (30.0, 40.0),
            (0.0, 3.0),
            (0.0, -15.0),
        ):
            odometry = self.copy_of_the_last()
            _, _, yaw, _ = pose_and_speed(odometry)
            odometry.pose.pose.position.x += forward_m * math.cos(yaw) - left_m * math.sin(yaw)
            odometry.pose.pose.position.y += forward_m * math.sin(yaw) + left_m * math.cos(yaw)
            self.odometry.publish(odometry)
            time.sleep(0.12)

    def path_behind(self):
        for _ in range(5):
            x, y, yaw, speed = pose_and_speed(self.drive.odometry.messages[-1])
            self.path.publish(
                LocalPath(
                    [
                        Waypoint(x - d * math.cos(yaw), y - d * math.sin(yaw), speed)
                        for d in range(30, 9, -1)
                    ]
                )
            )
            time.sleep(0.06)

    def thousand_paths(self):
        due = time.monotonic()
        for _ in range(500):
            self.path.publish(self.drive.paths.messages[-1])
            due += 0.001
            time.sleep(max(0.0, due - time.monotonic()))

    def second_controller(self):
        for n in range(40):
            command = CarlaVehicleControl(
                throttle=1.0 if n % 2 else 0.0, brake=0.0 if n % 2 else 1.0, steer=1.0
            )
            command.header.frame_id = INJECTED
            command.header.stamp = rospy.Time.now() + rospy.Duration(1.0)
            self.command.publish(command)
            time.sleep(0.03)


if __name__ == "__main__":
    rospy.init_node("topics_test")
    rostest.rosrun("sdc_package", "topics_test", TopicsTest)
