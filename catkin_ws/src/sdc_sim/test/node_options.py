#!/usr/bin/python3
"""The options of config/sim.yaml take effect: noise, latencies, friction, wind, role name."""

import unittest

import numpy as np
import rospy
import rostest
from carla_msgs.msg import CarlaEgoVehicleStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from std_srvs.srv import Trigger

from sdc_common.ros.odometry import pose_and_speed, yaw_from_quaternion
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.errors import OdometryNoise
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/hero"
TICK_NS = 50_000_000


class OptionsTest(unittest.TestCase):
    def test_each_option_of_the_launch_file_takes_effect(self):
        command = rospy.Publisher(EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=10)
        pose = rospy.Publisher("/initialpose", PoseWithCovarianceStamped, queue_size=1)
        odometry = MessageListener(EGO + "/odometry", Odometry)
        status = MessageListener(EGO + "/vehicle_status", CarlaEgoVehicleStatus)
        wait_for_subscriber(command)
        wait_for_subscriber(pose)

        # Noise: one draw a tick from the first on, with this seed and size. No node drives yet.
        last = odometry.wait_for(lambda message: message.header.stamp.to_nsec() > 60 * TICK_NS)
        noise = OdometryNoise(5, 0.4)
        for _ in range(last.header.stamp.to_nsec() // TICK_NS):
            drawn = noise.apply(VehicleState())
        np.testing.assert_allclose(pose_and_speed(last)[:2], (drawn.x_m, drawn.y_m), atol=1e-9)

        # Commands are 5 ticks late, the status 4: full throttle, then full brake.
        def drive(condition, **pedals):
            def accepts(message):
                command.publish(CarlaVehicleControl(**pedals))
                return condition(message)

            return status.wait_for(accepts, after=len(status.messages))

        moving = drive(lambda message: message.velocity > 8.0, throttle=0.8)
        before = len(status.messages)
        drive(lambda message: message.velocity < 1.0, brake=1.0)
        brakes = [message.control.brake for message in status.messages[before:]]
        self.assertGreaterEqual(brakes.index(1.0), 3)

        # With a third of the grip the car brakes with at most a third; only the wind turns it.
        braked = (one for one in status.messages[before:] if one.control.brake == 1.0)
        braking = [one for one in braked if 2.0 < one.velocity < 7.0]
        seconds = (braking[-1].header.stamp - braking[0].header.stamp).to_sec()
        deceleration = (braking[0].velocity - braking[-1].velocity) / seconds
        self.assertLess(deceleration, 0.3 * 1.05 * 9.81 * 1.1)
        self.assertGreater(deceleration, 1.0)
        self.assertGreater(abs(yaw_from_quaternion(moving.orientation)), 1e-3)

        # Sensors are 4 ticks late: paused, the car is shown at its new place with that stamp.
        paused_at = int(rospy.ServiceProxy("/sim/pause", Trigger)().message.rsplit(" ", 1)[1])
        there = PoseWithCovarianceStamped()
        there.header.frame_id = "map"
        there.pose.pose.position.x, there.pose.pose.orientation.w = 77.0, 1.0
        pose.publish(there)
        shown = odometry.wait_for(lambda message: message.pose.pose.position.x == 77.0)
        self.assertEqual(shown.header.stamp.to_nsec() // TICK_NS, paused_at - 4)


if __name__ == "__main__":
    rospy.init_node("options_test")
    rostest.rosrun("sdc_sim", "options_test", OptionsTest)
