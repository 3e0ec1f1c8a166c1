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
    CarlaControl,
    CarlaEgoVehicleControl,
    CarlaEgoVehicleInfo,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaRoute,
    CarlaStatus,
    CarlaWalkerControl,
)
from carla_msgs.srv import DestroyObject, GetBlueprints, SpawnObject
from derived_object_msgs.msg import ObjectArray
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
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
        topic = EGO + "/vehicle_control_cmd"
        cls.control = rospy.Publisher(topic, CarlaEgoVehicleControl, queue_size=10)
        wait_for_subscriber(cls.control)
        cls.spawn = rospy.ServiceProxy("/carla/spawn_object", SpawnObject)
        cls.destroy = rospy.ServiceProxy("/carla/destroy_object", DestroyObject)
        cls.spawn.wait_for_service(20.0)
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
        topics = EGO + "/vehicle_control_manual_override", EGO + "/vehicle_control_cmd_manual"
        override = rospy.Publisher(topics[0], Bool, queue_size=10, latch=True)
        autopilot = rospy.Publisher(EGO + "/enable_autopilot", Bool, queue_size=10)
        manual = rospy.Publisher(topics[1], CarlaEgoVehicleControl, queue_size=10)
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
        frames = "map", "ego_vehicle"
        wait_until(lambda: transforms.can_transform(*frames, rospy.Time()), what="the pose")

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

    def test_ackermann_targets_are_left_to_the_node_that_converts_them(self):
        log = MessageListener("/rosout", Log, lambda one: one.name == "/sim")
        targets = rospy.Publisher(EGO + "/ackermann_cmd", AckermannDrive, queue_size=1)
        wait_for_subscriber(targets)
        self.timer(0.05, lambda: targets.publish(AckermannDrive(speed=4.0)))
        self.wait_for_speed(lambda speed: abs(speed - 4.0) < 0.3)
        self.assertNotEqual(self.status.messages[-1].control.throttle, 0.625)

        converting = threading.Event()
        convert_one = lambda _target: converting.set()  # noqa: E731
        subscriber = rospy.Subscriber(EGO + "/ackermann_cmd", AckermannDrive, convert_one)

        def convert():
            if converting.is_set():
                self.control.publish(CarlaEgoVehicleControl(throttle=0.625, steer=-0.125))

        self.timer(0.1, convert)
        line = log.wait_for(lambda one: f"ignored targets on {EGO}/ackermann_cmd" in one.msg)
        self.assertIn("/bridge_clients_test", line.msg)
        seen = len(self.status.messages) + 5
        wait_until(lambda: len(self.status.messages) > seen + 40, what="40 ticks")
        controls = (one.control for one in self.status.messages[seen : seen + 40])
        executed = {(one.throttle, one.steer, one.brake) for one in controls}
        self.assertEqual(executed, {(0.625, -0.125, 0.0)})

        subscriber.unregister()
        converting.clear()
        self.wait_for_speed(lambda speed: abs(speed - 4.0) < 0.3)

    def test_panel_pauses_steps_and_plays(self):
        control = rospy.Publisher("/carla/control", CarlaControl, queue_size=10)
        wait_for_subscriber(control)
        status = MessageListener("/carla/status", CarlaStatus)
        status.wait_for()
        control.publish(CarlaControl.PAUSE)
        paused = status.wait_for(lambda one: not one.synchronous_mode_running).frame
        for step in (1, 2):
            control.publish(CarlaControl.STEP_ONCE)
            status.wait_for(lambda one, frame=paused + step: one.frame == frame)
        control.publish(9)
        control.publish(CarlaControl.PLAY)
        status.wait_for(lambda one: one.synchronous_mode_running and one.frame > paused + 10)

    def spawned(self, kind, name, x, y=0.0, carrier=0):
        pose = Pose(Point(x, y, 0.0), Quaternion(w=1.0))
        return self.spawn(kind, name, [], pose, carrier, False)

    def test_spawned_car_is_hit_and_destroyed(self):
        objects = MessageListener("/carla/objects", ObjectArray)
        collision = MessageListener(EGO + "/collision", CarlaCollisionEvent)
        collision.wait_for_publisher()
        car = self.spawned("vehicle.tesla.model3", "leader", 12.0).id
        for kind, name, x, error in (
            ("vehicle.tesla.model3", "leader", 40.0, "'leader' is in use"),
            ("vehicle.tesla.model3", "other", 14.0, f"the car {car} is there"),
            ("static.prop.box01", "box", 1.0, "the ego vehicle is at"),
            ("static.prop.box01", "box", float("nan"), "not finite"),
            ("plane.jumbo", "jumbo", 40.0, "unknown type"),
            ("sensor.other.imu", "imu", 0.0, "none on /carla/imu"),
        ):
            answer = self.spawned(kind, name, x)
            self.assertEqual(answer.id, -1)
            self.assertIn(error, answer.error_string)
        self.timer(0.05, lambda: self.control.publish(CarlaEgoVehicleControl(throttle=0.5)))
        self.assertEqual(collision.wait_for(seconds=30.0).other_actor_id, car)
        self.assertTrue(self.destroy(car).success)
        objects.wait_for(lambda one: len(one.objects) == 1, after=len(objects.messages))
        self.assertFalse(self.destroy(car).success)
        # A reset removes what was spawned; its name is free then.
        self.assertGreater(self.spawned("static.prop.box01", "leader", 60.0).id, car)
        objects.wait_for(lambda one: len(one.objects) == 2, after=len(objects.messages))
        rospy.ServiceProxy("/sim/reset", Trigger)()
        wait_until(lambda: self.spawned("walker.*", "leader", 60.0).id > car, what="a free name")

    def test_pedestrian_walks_where_its_client_wants(self):
        walker = self.spawned("walker.pedestrian.0001", "alice", 30.0, 8.0).id
        self.assertGreater(self.spawned("sensor.pseudo.odom", "odometry", 0.0, 0.0, walker).id, 0)
        seen = MessageListener("/carla/alice/odometry", Odometry)
        topic = "/carla/alice/walker_control_cmd"
        control = rospy.Publisher(topic, CarlaWalkerControl, queue_size=1)
        wait_for_subscriber(control)
        control.publish(CarlaWalkerControl(Vector3(0.0, -2.0, 0.0), 1.5, False))
        seen.wait_for(lambda one: one.pose.pose.position.y < 6.0)
        control.publish(CarlaWalkerControl())
        halted = seen.wait_for(lambda one: not one.twist.twist.linear.x, after=len(seen.messages))
        x, _, yaw, _ = pose_and_speed(halted)
        np.testing.assert_allclose((x, yaw), (30.0, -np.pi / 2), atol=1e-6)
        self.assertTrue(self.destroy(walker).success)

    def test_blueprints_and_route_are_there(self):
        blueprints = rospy.ServiceProxy("/carla/get_blueprints", GetBlueprints)
        names = blueprints("vehicle.*").blueprints
        own = [name for name in names if ".pseudo." not in name]
        self.assertEqual((len(own), names), (5, sorted(names)))
        self.assertIn("vehicle.audi.a2", own)
        self.assertIn("sensor.other.gnss", blueprints("").blueprints)
        route = MessageListener(EGO + "/global_plan", CarlaRoute).wait_for()
        self.assertEqual(set(route.road_options), {CarlaRoute.LANEFOLLOW})
        # It begins where the car starts.
        self.odometry.wait_for(lambda one: one.pose.pose == route.poses[0])


if __name__ == "__main__":
    rospy.init_node("bridge_clients_test")
    rostest.rosrun("sdc_sim", "bridge_clients_test", BridgeClientsTest)
