"""Turns the numbers of the world into ROS messages."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image

from sdc_sim.vehicle import VehicleState

if TYPE_CHECKING:
    from sdc_sim.camera import CameraModel

MAP_FRAME = "map"
VEHICLE_FRAME = "ego_vehicle"
CAMERA_FRAME = "ego_vehicle/camera/rgb/front"


def quaternion_from_yaw(yaw_rad: float) -> Quaternion:
    """The orientation of a body turned counter-clockwise from the x axis."""
    return Quaternion(0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad))


def odometry_message(state: VehicleState, stamp) -> Odometry:
    """Pose of the car's centre in the map, twist in the body frame."""
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id = MAP_FRAME
    message.child_frame_id = VEHICLE_FRAME
    pose = message.pose.pose
    pose.position.x = state.x_m
    pose.position.y = state.y_m
    pose.orientation = quaternion_from_yaw(state.yaw_rad)
    twist = message.twist.twist
    twist.linear.x = state.speed_mps
    twist.linear.y = state.lateral_speed_mps
    twist.angular.z = state.yaw_rate_radps
    return message


def vehicle_transform(odometry: Odometry) -> TransformStamped:
    """The transform map -> ego_vehicle of an odometry message."""
    transform = TransformStamped()
    transform.header = odometry.header
    transform.child_frame_id = VEHICLE_FRAME
    transform.transform.translation.x = odometry.pose.pose.position.x
    transform.transform.translation.y = odometry.pose.pose.position.y
    transform.transform.rotation = odometry.pose.pose.orientation
    return transform


def camera_transform(camera: CameraModel) -> TransformStamped:
    """The fixed transform ego_vehicle -> camera optical frame (z forward, x right, y down: REP 103)."""
    half = 0.5 * camera.pitch_rad
    transform = TransformStamped()
    transform.header.frame_id = VEHICLE_FRAME
    transform.child_frame_id = CAMERA_FRAME
    transform.transform.translation.x = camera.mount_x_m
    transform.transform.translation.z = camera.mount_z_m
    # The optical frame's quaternion (-0.5, 0.5, -0.5, 0.5), after a turn about the body's y axis by the pitch.
    c, s = 0.5 * math.cos(half), 0.5 * math.sin(half)
    transform.transform.rotation = Quaternion(-c - s, c + s, s - c, c - s)
    return transform


def image_message(picture: np.ndarray, stamp) -> Image:
    """A (H, W, 4) BGRA uint8 picture as an Image."""
    message = Image()
    message.header.stamp = stamp
    message.header.frame_id = CAMERA_FRAME
    message.height, message.width = picture.shape[:2]
    message.encoding = "bgra8"
    message.step = picture.shape[1] * 4
    message.data = picture.tobytes()
    return message


def camera_info_message(camera: CameraModel) -> CameraInfo:
    """The pinhole camera without distortion; the stamp is left to set."""
    k = np.asarray(camera.intrinsic_matrix())
    message = CameraInfo(height=camera.height, width=camera.width, distortion_model="plumb_bob")
    message.header.frame_id = CAMERA_FRAME
    message.D = [0.0] * 5
    message.K = k.ravel().tolist()
    message.R = np.eye(3).ravel().tolist()
    message.P = np.column_stack([k, np.zeros(3)]).ravel().tolist()
    return message
