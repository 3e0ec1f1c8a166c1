#!/usr/bin/python3
"""The sensors in lockstep without perfect odometry; the test is the stack that answers them."""

import math
import unittest

import numpy as np
import rospy
import rostest
import tf2_ros
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from sensor_msgs.msg import Imu, JointState, LaserScan, NavSatFix, NavSatStatus, PointCloud2
from std_msgs.msg import Float32
from tf2_msgs.msg import TFMessage

from sdc_common.geometry.geodesy import map_from_geodetic
from sdc_common.ros.odometry import GROUND_TRUTH, true_odometry_topic
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000


def ticks(listener):
    return [message.header.stamp.to_nsec() // TICK_NS for message in listener.messages]


def has_hundred_ticks(message):
    return message.header.stamp.to_nsec() >= 100 * TICK_NS


class SensorsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        topic = EGO + "/vehicle_control_cmd"
        cls.command = rospy.Publisher(topic, CarlaVehicleControl, queue_size=100)
        # The simulation waits for a node that estimates the odometry.
        cls.estimate = rospy.Publisher(EGO + "/odometry", Odometry, queue_size=1)
        cls.imu = MessageListener(EGO + "/imu", Imu)
        cls.gnss = MessageListener(EGO + "/gnss/front/gnss", NavSatFix)
        cls.speed = MessageListener(EGO + "/speedometer", Float32)
        topics = {name: f"{EGO}/lidar/{name}/point_cloud" for name in ("front", "planar")}
        cls.scans = {name: MessageListener(one, PointCloud2) for name, one in topics.items()}
        cls.planar = MessageListener(EGO + "/scan", LaserScan)
        cls.truth = MessageListener(GROUND_TRUTH, Odometry)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        cls.transforms = MessageListener("/tf", TFMessage)
        cls.buffer = tf2_ros.Buffer()
        cls.tf = tf2_ros.TransformListener(cls.buffer)
        wait_for_subscriber(cls.command)
        cls.wheels = MessageListener(EGO + "/wheel_speeds", JointState)
        rospy.Subscriber(EGO + "/wheel_speeds", JointState, cls.answer, tcp_nodelay=True)
        cls.wheels.wait_for(has_hundred_ticks, seconds=60.0)

    @classmethod
    def answer(cls, wheels):
        cls.command.publish(CarlaVehicleControl(header=wheels.header, throttle=0.6, steer=0.05))

    def test_command_that_answers_the_wheel_speeds_carries_the_lockstep(self):
        self.assertEqual(sorted(set(ticks(self.wheels)))[:100], list(range(1, 101)))
        self.assertGreater(self.truth.messages[-1].twist.twist.linear.x, 5.0)

    def test_each_sensor_is_published_in_the_ticks_of_its_period(self):
        self.imu.wait_for(has_hundred_ticks)
        self.gnss.wait_for(has_hundred_ticks)
        self.assertEqual(sorted(set(ticks(self.imu)))[:100], list(range(1, 101)))
        self.assertEqual(sorted(set(ticks(self.gnss)))[:25], list(range(4, 101, 4)))

    def test_gnss_measures_the_true_position_and_has_no_fix_in_an_outage(self):
        self.truth.wait_for(has_hundred_ticks)
        places = (one.pose.pose.position for one in self.truth.messages)
        true = dict(zip(ticks(self.truth), places))
        self.gnss.wait_for(has_hundred_ticks)
        for tick, fix in zip(ticks(self.gnss), self.gnss.messages):
            if not 4 <= tick <= 100:
                continue
            self.assertEqual(fix.header.frame_id, "ego_vehicle/gnss/front")
            # The first tick is 1 and at the time 0.
            if 2.0 <= (tick - 1) * 0.05 < 3.0:
                self.assertEqual(fix.status.status, NavSatStatus.STATUS_NO_FIX)
                self.assertTrue(math.isnan(fix.latitude))
                continue
            self.assertEqual(fix.status.status, NavSatStatus.STATUS_FIX)
            self.assertEqual(fix.position_covariance[0], 1.0)
            x_m, y_m = map_from_geodetic(fix.latitude, fix.longitude)
            self.assertLess(math.hypot(x_m - true[tick].x, y_m - true[tick].y), 5.0)

    def test_motion_sensors_have_their_frames_and_values(self):
        truth = {message.header.stamp: message.twist.twist for message in list(self.truth.messages)}
        wheels = next(one for one in reversed(self.wheels.messages) if one.header.stamp in truth)
        twist = truth[wheels.header.stamp]
        names = [f"{axle}_{side}_wheel" for axle in ("front", "rear") for side in ("left", "right")]
        self.assertEqual(wheels.name, names)
        rear_mps = 0.5 * 0.35 * (wheels.velocity[2] + wheels.velocity[3])
        self.assertLess(abs(rear_mps - twist.linear.x), 0.3)
        imu = next(one for one in reversed(self.imu.messages) if one.header.stamp in truth)
        self.assertEqual(imu.header.frame_id, "ego_vehicle/imu")
        self.assertEqual(imu.orientation_covariance[0], -1.0)
        self.assertLess(abs(imu.linear_acceleration.z - 9.81), 0.5)
        self.assertLess(abs(imu.angular_velocity.z - truth[imu.header.stamp].angular.z), 0.03)
        self.assertLess(abs(self.speed.wait_for().data), 40.0)

    def test_lidars_publish_points_of_the_world_in_their_frames(self):
        for name, period in (("front", 2), ("planar", 1)):
            scan = self.scans[name].wait_for(lambda one: one.header.stamp.to_nsec() > TICK_NS)
            self.assertEqual(scan.header.frame_id, f"ego_vehicle/lidar/{name}")
            self.assertEqual(ticks(self.scans[name])[-1] % period, 0)
            fields = [(field.name, field.offset, field.datatype) for field in scan.fields]
            float32 = scan.fields[0].FLOAT32
            expected = [("x", 0), ("y", 4), ("z", 8), ("intensity", 12)]
            self.assertEqual(fields, [(*one, float32) for one in expected])
            points = np.frombuffer(scan.data, np.float32).reshape(-1, 4)
            self.assertEqual((len(points), scan.height), (scan.width, 1))
            self.assertGreater(len(points), 30)
            ranges = np.linalg.norm(points[:, :3], axis=1)
            self.assertTrue(ranges.min() > 0.5 and ranges.max() < 81.0)
        scan = self.planar.wait_for()
        self.assertEqual(scan.header.frame_id, "ego_vehicle/lidar/planar")
        cloud = self.scans["planar"].wait_for(lambda one: one.header.stamp == scan.header.stamp)
        self.assertEqual(np.isfinite(scan.ranges).sum(), cloud.width)
        # The lowest ring meets the ground in front of the car.
        front = np.frombuffer(self.scans["front"].messages[-1].data, np.float32).reshape(-1, 4)
        self.assertLess(abs(front[:, 2].min() + 2.4), 0.2)

    def test_only_the_referee_receives_the_true_odometry(self):
        self.assertEqual(true_odometry_topic(EGO), GROUND_TRUTH)
        first = self.truth.messages[0]
        self.assertEqual((first.header.frame_id, first.child_frame_id), ("map", "ego_vehicle"))
        self.assertEqual(self.odometry.messages, [])
        self.assertEqual(self.transforms.messages, [])

    def test_sensors_have_a_place_on_the_vehicle(self):
        transform = self.buffer.lookup_transform(
            "ego_vehicle", "ego_vehicle/gnss/front", rospy.Time(0), rospy.Duration(0)
        )
        self.assertEqual(transform.transform.translation.z, 1.5)


if __name__ == "__main__":
    rospy.init_node("sensors_test")
    rostest.rosrun("sdc_sim", "sensors_test", SensorsTest)
