#!/usr/bin/env python3
"""Localizer: estimate the pose of the car from its sensors, and publish it as odometry."""

import math
from functools import partial

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import Path
from sensor_msgs.msg import Imu, JointState, NavSatFix, PointCloud2
from tf2_msgs.msg import TFMessage

from sdc_common.geometry.geodesy import map_from_geodetic
from sdc_common.ros.conversion import rear_axle_speed
from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import odometry_message, vehicle_transform
from sdc_common.ros.refusal import refusing
from sdc_common.routes.waypoint_file import WaypointError
from sdc_common.validation import check_non_negative, check_positive
from sdc_localization.landmark_map import load_landmarks
from sdc_localization.landmarks import LandmarkMap
from sdc_localization.localizer import Localizer, LocalizerSettings
from sdc_localization.odometry_message import pose_covariance
from sdc_localization.scan_features import find_features, scan_points
from sdc_localization.sensor_pairing import SensorPairing

EGO = "/carla/ego_vehicle"


class LocalizerNode:
    def __init__(self):
        rospy.init_node("localizer")
        self.radius_m = parameter("wheel_radius_m")
        self.pole_radius_m = parameter("pole_radius_m")
        self.lidar_ahead_m = parameter("lidar_ahead_m")
        gnss_period_s = parameter("gnss_period_s")
        try:
            check_positive(wheel_radius_m=self.radius_m)
            check_non_negative(gnss_period_s=gnss_period_s)
            self.localizer = Localizer(LocalizerSettings.read(parameter))
        except (TypeError, ValueError) as error:
            refuse(f"config/localizer.yaml: {error}")
        self.waypoints = None
        self.landmarks = self.read_map() if parameter("landmarks") else None
        lidar_period_s = parameter("lidar_period_s") if self.landmarks else 0.0
        self.inputs = SensorPairing(self.answer, [gnss_period_s, lidar_period_s])

        for number, (topic, message_class) in enumerate(
            (
                (f"{EGO}/wheel_speeds", JointState),
                (f"{EGO}/imu", Imu),
                (parameter("gnss_topic"), NavSatFix),
                (parameter("lidar_topic"), PointCloud2),
            )[: 4 if self.landmarks else 3]
        ):
            add = partial(self.inputs.add, number)
            rospy.Subscriber(topic, message_class, add, queue_size=10, tcp_nodelay=True)
        # The simulator starts when the odometry has a publisher and its subscribers are connected.
        self.tf_publisher = rospy.Publisher("/tf", TFMessage, queue_size=1)
        self.publisher = LoopPublisher(f"{EGO}/odometry", Odometry, latch=True)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)

    def read_map(self):
        try:
            deviations = parameter("landmark_range_m"), parameter("landmark_bearing_rad")
            check_positive(landmark_range_m=deviations[0], landmark_bearing_rad=deviations[1])
            positions = load_landmarks(parameter("waypoints_path"))
            return LandmarkMap(positions, *deviations, self.localizer.settings.gate_2)
        except (WaypointError, ValueError) as error:
            refuse(error)

    def on_mission(self, path):
        points = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
        if len(points) > 1 and np.isfinite(points).all():
            self.waypoints = points
            self.inputs.start()

    def answer(self, wheels, imu, fix, scan):
        """Estimate the pose at the time of these messages, and publish it."""
        with refusing("the topics of the sensors"):
            speed = rear_axle_speed(wheels.name, wheels.velocity, self.radius_m)
            self.localizer.move(wheels.header.stamp.to_sec(), speed, imu.angular_velocity.z)
            if fix is not None and fix.status.status >= fix.status.STATUS_FIX:
                self.add_position(fix)
            if self.localizer.started:
                if scan is not None:
                    self.add_scan(scan)
                self.publish(wheels.header.stamp)

    def add_position(self, fix):
        x, y = map_from_geodetic(fix.latitude, fix.longitude)
        variance = fix.position_covariance[0]
        if not (math.isfinite(x + y + variance) and variance > 0.0):
            raise ValueError("a GNSS position has a number that is not finite, or no covariance")
        if self.localizer.lost:
            rospy.logwarn("localizer: GNSS contradicts the estimate; starts again")
        if self.localizer.lost or not self.localizer.started:
            self.localizer.start(x, y, variance, self.waypoints)
        else:
            self.localizer.add_position(x, y, variance)

    def add_scan(self, scan):
        features = find_features(scan_points(scan), self.pole_radius_m)
        self.landmarks.correct(self.localizer, features + (self.lidar_ahead_m, 0.0))

    def publish(self, stamp):
        estimate = self.localizer.estimate
        pose = (estimate.x_m, estimate.y_m, estimate.yaw_rad)
        twist = (estimate.speed_mps, estimate.sideways_mps, estimate.yaw_rate_radps)
        message = odometry_message(stamp, pose, twist)
        message.pose.covariance = pose_covariance(estimate.covariance)
        self.publisher.publish(message)
        self.tf_publisher.publish(TFMessage([vehicle_transform(message)]))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    LocalizerNode().run()
