"""Messages of the pose and speed of the vehicle."""

from __future__ import annotations

import math
from typing import Any

import rospy
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry

from sdc_common.driving import quaternion

# Where a simulator with `truth: false` publishes what it otherwise publishes as odometry.
GROUND_TRUTH = "/sim/ground_truth/odometry"


def yaw_from_quaternion(q: Quaternion) -> float:
    """Return the yaw of a unit quaternion, counter-clockwise from the x axis [rad].

    Reference: J. Diebel, Representing Attitude: Euler Angles, Unit Quaternions, and Rotation
    Vectors, 2006, equation 290.
    """
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def unit(q: Quaternion) -> Quaternion:
    """Return a quaternion if it is a unit quaternion, else raise ValueError."""
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise ValueError("its orientation is not a unit quaternion")
    return q


def pose_and_speed(odometry: Odometry) -> tuple[float, float, float, float]:
    """Return x [m], y [m], yaw [rad] and speed [m/s] of an odometry message.

    The speed is the magnitude of the twist, which is the same in every frame.

    Raises:
        ValueError: a number is not finite, or the orientation is not a unit quaternion
    """
    position, velocity = odometry.pose.pose.position, odometry.twist.twist.linear
    yaw = yaw_from_quaternion(unit(odometry.pose.pose.orientation))
    numbers = (position.x, position.y, yaw, math.hypot(velocity.x, velocity.y))
    if not all(map(math.isfinite, numbers)):
        raise ValueError("one of its numbers is not finite")
    return numbers


def true_odometry_topic(ego: str) -> str:
    """Return the topic with the true odometry of a vehicle, such as /carla/ego_vehicle."""
    return ego + "/odometry" if rospy.get_param("/sim/truth", True) else GROUND_TRUTH


def odometry_message(
    stamp: Any,
    pose: tuple[float, ...],
    twist: tuple[float, float, float],
    vehicle_frame: str = "ego_vehicle",
) -> Odometry:
    """Return the odometry of a vehicle in the map.

    Args:
        stamp: stamp of the message (rospy.Time)
        pose: x [m], y [m], yaw [rad], and, unless they are 0, height [m] and pitch [rad]
        twist: speed forward and to the left [m/s], yaw rate [rad/s]
        vehicle_frame: frame of the vehicle
    """
    message = Odometry(child_frame_id=vehicle_frame)
    message.header.stamp, message.header.frame_id = stamp, "map"
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, yaw, position.z, pitch = (*pose, 0.0, 0.0)[:5]
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(yaw, pitch)
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, angular.z = twist
    return message


def vehicle_transform(odometry: Odometry) -> TransformStamped:
    """Return the transform from the map to the vehicle of an odometry message."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position, translation = odometry.pose.pose.position, message.transform.translation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    message.transform.rotation = odometry.pose.pose.orientation
    return message
