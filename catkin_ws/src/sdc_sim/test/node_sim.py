#!/usr/bin/python3
"""The simulator keeps its contract in real time: topics, frames, stamps, commands."""

import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl

from sdc_common.processes import wait_until
from sdc_common.ros.conversion import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"


class SimTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=10
        )
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        wait_for_subscriber(cls.command)
        cls.odometry.wait_for()

    def drive_until(self, condition, seconds=20.0, **command):
        """Send a command at each odometry until an odometry fulfils the condition."""

        def accepts(odometry):
            self.command.publish(CarlaVehicleControl(**command))
            return condition(odometry)

        return self.odometry.wait_for(accepts, seconds, after=len(self.odometry.messages))

    def speed(self, odometry):
        return pose_and_speed(odometry)[3]

    def test_clock_and_odometry_advance_by_ticks(self):
        clock = MessageListener("/clock", Clock)
        wait_until(lambda: len(clock.messages) > 5, what="five ticks of /clock")
        steps = np.diff([message.clock.to_nsec() for message in clock.messages[:6]])
        self.assertEqual(set(steps), {50_000_000})
        odometry = self.odometry.messages[-1]
        self.assertEqual(
            (odometry.header.frame_id, odometry.child_frame_id), ("map", "ego_vehicle")
        )

    def test_transforms_from_map_to_camera(self):
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        frame = "ego_vehicle/camera/rgb/front"
        wait_until(
            lambda: buffer.can_transform("map", frame, rospy.Time(0)),
            what="a transform from map to camera",
        )
        fixed = buffer.lookup_transform("ego_vehicle", frame, rospy.Time(0)).transform
        self.assertAlmostEqual(fixed.translation.x, 0.7)
        self.assertAlmostEqual(fixed.translation.z, 1.7)
        listener.unregister()

    def test_command_moves_the_car_and_positive_steer_turns_right(self):
        start = self.drive_until(
            lambda odometry: self.speed(odometry) > 3.0, throttle=0.7, steer=0.5
        )
        turned = self.drive_until(
            lambda odometry: pose_and_speed(odometry)[2] < -0.3, throttle=0.4, steer=0.5
        )
        self.assertLess(turned.twist.twist.angular.z, 0.0)
        self.assertGreater(turned.header.stamp, start.header.stamp)
        self.drive_until(lambda odometry: self.speed(odometry) == 0.0, brake=1.0)

    def test_car_brakes_when_commands_time_out(self):
        moving = self.drive_until(lambda odometry: self.speed(odometry) > 4.0, throttle=0.8)
        stopped = self.odometry.wait_for(
            lambda odometry: self.speed(odometry) == 0.0, after=len(self.odometry.messages)
        )
        self.assertLess((stopped.header.stamp - moving.header.stamp).to_sec(), 3.0)


if __name__ == "__main__":
    # Of two waiting ticks, a node with simulated time receives only the last.
    rospy.init_node("sim_test", disable_rostime=True)
    rostest.rosrun("sdc_sim", "sim_test", SimTest)
