#!/usr/bin/python3
"""The topics that the nodes of CARLA's bridge use, in the way in which those nodes use them."""

import threading
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleControl,
    CarlaEgoVehicleInfo,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaStatus,
)
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from sdc_common.processes import wait_until
from sdc_common.ros.odometry import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"


class BridgeClientsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        cls.status = MessageListener(EGO + "/vehicle_status", CarlaEgoVehicleStatus)
        cls.control = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaEgoVehicleControl, queue_size=10
        )
        wait_for_subscriber(cls.control)
        cls.odometry.wait_for()
        cls.status.wait_for()

    def setUp(self):
        rospy.ServiceProxy("/sim/reset", Trigger)()
        self.wait_for_speed(lambda speed: speed == 0.0)

    def wait_for_speed(self, accepts, seconds=20.0):
        after = len(self.odometry.messages)
        self.odometry.wait_for(lambda one: accepts(pose_and_speed(one)[3]), seconds, after)

    def subscribe(self, topic, message_class, callback):
        subscriber = rospy.Subscriber(topic, message_class, callback)
        self.addCleanup(subscriber.unregister)

    def timer(self, period_s, function):
        timer = rospy.Timer(rospy.Duration(period_s), lambda _event: function())
        self.addCleanup(timer.join)
        self.addCleanup(timer.shutdown)

    def test_manual_control_drives_while_its_override_is_set(self):
        """One command for each CarlaStatus; picture, status, info, events and tf for its window."""
        override = rospy.Publisher(
            EGO + "/vehicle_control_manual_override", Bool, queue_size=10, latch=True
        )
        autopilot = rospy.Publisher(EGO + "/enable_autopilot", Bool, queue_size=10)
        manual = rospy.Publisher(
            EGO + "/vehicle_control_cmd_manual", CarlaEgoVehicleControl, queue_size=10
        )
        self.addCleanup(manual.unregister)
        self.addCleanup(override.publish, False)
        pressed = CarlaEgoVehicleControl()
        self.subscribe("/carla/status", CarlaStatus, lambda _status: manual.publish(pressed))
        autopilot.publish(False)
        override.publish(False)
        collision = MessageListener(EGO + "/collision", CarlaCollisionEvent)
        lane_invasion = MessageListener(EGO + "/lane_invasion", CarlaLaneInvasionEvent)
        for listener in (collision, lane_invasion):
            listener.wait_for_publisher()
        picture = MessageListener(EGO + "/rgb_view/image", Image).wait_for(seconds=60.0)
        self.assertEqual(len(picture.data), 4 * picture.width * picture.height)
        info = MessageListener(EGO + "/vehicle_info", CarlaEgoVehicleInfo).wait_for()
        self.assertEqual((info.type, info.rolename), ("vehicle.tesla.model3", "ego_vehicle"))
        transforms = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(transforms)
        self.addCleanup(listener.unregister)
        wait_until(
            lambda: transforms.can_transform("map", "ego_vehicle", rospy.Time()), what="the pose"
        )

        pressed.throttle = 1.0
        override.publish(True)
        self.wait_for_speed(lambda speed: speed > 3.0)
        seen = len(self.status.messages)
        self.wait_for_speed(lambda speed: speed > 5.0)
        driven = self.status.messages[seen:]
        self.assertEqual({one.control.throttle for one in driven}, {1.0}, "no gap between commands")
        pressed.throttle, pressed.steer = 0.5, 0.4
        crossed = lane_invasion.wait_for().crossed_lane_markings
        self.assertEqual(list(crossed), [CarlaLaneInvasionEvent.LANE_MARKING_SOLID])
        pressed.throttle, pressed.brake = 0.0, 1.0
        self.wait_for_speed(lambda speed: speed == 0.0)
        override.publish(False)

    def test_status_comes_once_a_tick(self):
        status = MessageListener("/carla/status", CarlaStatus)
        status.wait_for(lambda one: one.frame > status.messages[0].frame + 20)
        frames = [one.frame for one in status.messages]
        self.assertLessEqual(set(np.diff(frames[1:])), {1})
        self.assertFalse(status.messages[-1].synchronous_mode)
        self.assertTrue(status.messages[-1].synchronous_mode_running)
        self.assertAlmostEqual(status.messages[-1].fixed_delta_seconds, 0.05, places=6)

    def test_ackermann_targets_are_left_to_the_node_that_converts_them(self):
        log = MessageListener("/rosout", Log, lambda one: one.name == "/sim")
        targets = rospy.Publisher(EGO + "/ackermann_cmd", AckermannDrive, queue_size=1)
        wait_for_subscriber(targets)
        self.timer(0.05, lambda: targets.publish(AckermannDrive(speed=4.0)))
        self.wait_for_speed(lambda speed: abs(speed - 4.0) < 0.3)
        self.assertNotEqual(self.status.messages[-1].control.throttle, 0.625)

        converting = threading.Event()
        subscriber = rospy.Subscriber(
            EGO + "/ackermann_cmd", AckermannDrive, lambda _target: converting.set()
        )

        def convert():
            if converting.is_set():
                self.control.publish(CarlaEgoVehicleControl(throttle=0.625, steer=-0.125))

        self.timer(0.1, convert)
        line = log.wait_for(lambda one: f"ignored targets on {EGO}/ackermann_cmd" in one.msg)
        self.assertIn("/bridge_clients_test", line.msg)
        seen = len(self.status.messages) + 5
        wait_until(lambda: len(self.status.messages) > seen + 40, what="40 ticks")
        executed = {
            (one.control.throttle, one.control.steer, one.control.brake)
            for one in self.status.messages[seen : seen + 40]
        }
        self.assertEqual(executed, {(0.625, -0.125, 0.0)})

        subscriber.unregister()
        converting.clear()
        self.wait_for_speed(lambda speed: abs(speed - 4.0) < 0.3)


if __name__ == "__main__":
    rospy.init_node("bridge_clients_test")
    rostest.rosrun("sdc_sim", "bridge_clients_test", BridgeClientsTest)
