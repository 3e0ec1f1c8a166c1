"""Pose and speed of a nav_msgs/Odometry message, and the topic of the true ones."""

from __future__ import annotations

import math

import rospy
from geometry_msgs.msg import Quaternion
from nav_msgs.msg import Odometry

# Where a simulator with `truth: false` publishes what it otherwise publishes as odometry.
GROUND_TRUTH = "/sim/ground_truth/odometry"


def yaw_from_quaternion(q: Quaternion) -> float:
    """Return the yaw of a unit quaternion, counter-clockwise from the x axis [rad].

    Reference: J. Diebel, Representing Attitude: Euler Angles, Unit Quaternions, and Rotation
    Vectors, 2006, equation 290.
    """
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def pose_and_speed(odometry: Odometry) -> tuple[float, float, float, float]:
    """Return x [m], y [m], yaw [rad] and speed [m/s] of an odometry message.

    The speed is the magnitude of the twist, which is the same in every frame.

    Raises:
        ValueError: a number is not finite, or the orientation is not a unit quaternion
    """
    position = odometry.pose.pose.position
    q = odometry.pose.pose.orientation
    velocity = odometry.twist.twist.linear
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise ValueError("its orientation is not a unit quaternion")
    speed = math.hypot(velocity.x, velocity.y)
    numbers = (position.x, position.y, yaw_from_quaternion(q), speed)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("one of its numbers is not finite")
    return numbers


def true_odometry_topic(ego: str) -> str:
    """Return the topic with the true odometry of the vehicle.

    Args:
        ego: prefix of the topics of the vehicle, such as /carla/ego_vehicle
    """
    return ego + "/odometry" if rospy.get_param("/sim/truth", True) else GROUND_TRUTH
