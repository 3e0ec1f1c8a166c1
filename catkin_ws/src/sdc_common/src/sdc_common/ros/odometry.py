"""Reads the numbers out of a nav_msgs/Odometry."""

from __future__ import annotations

import math


def yaw_from_quaternion(q) -> float:
    """Yaw in radians, counter-clockwise from the x axis, of a unit quaternion with x, y, z, w.

    Source: J. Diebel, Representing Attitude: Euler Angles, Unit Quaternions, and Rotation Vectors, 2006, equation 290.
    """
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def pose_and_speed(odometry):
    """(x_m, y_m, yaw_rad, speed_mps) of an odometry message; the speed is the magnitude of its twist, whichever frame it is in.

    Raises ValueError when a number is not finite, or when the quaternion is not one.
    """
    position = odometry.pose.pose.position
    q = odometry.pose.pose.orientation
    velocity = odometry.twist.twist.linear
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise ValueError("its orientation is not a unit quaternion")
    speed = math.hypot(velocity.x, velocity.y)
    numbers = (position.x, position.y, yaw_from_quaternion(q), speed)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("a number in it is not finite")
    return numbers
