"""Read pose and speed from a nav_msgs/Odometry."""

from __future__ import annotations

import math
from typing import Any


def yaw_from_quaternion(q: Any) -> float:
    """Return the yaw of a unit quaternion, counter-clockwise from the x axis [rad].

    Args:
        q: quaternion with the attributes x, y, z, w

    Reference: J. Diebel, Representing Attitude: Euler Angles, Unit Quaternions, and Rotation
    Vectors, 2006, equation 290.
    """
    # TODO 2.4: yaw, the rotation about the vertical axis (until then: return 0.0)
    return 0.0
    # ----------------------------------------------------------------------------


def pose_and_speed(odometry: Any) -> tuple[float, float, float, float]:
    """Return (x, y, yaw, speed) of an odometry message [m, m, rad, m/s].

    The speed is the magnitude of the twist, so that the frame of the twist does not matter.

    Args:
        odometry: a nav_msgs/Odometry

    Raises:
        ValueError: a number is not finite, or the orientation is not a unit quaternion
    """
    position = odometry.pose.pose.position
    q = odometry.pose.pose.orientation
    velocity = odometry.twist.twist.linear
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise ValueError("its orientation is not a unit quaternion")
    # TODO 2.5: the speed over the ground, from the velocity's components (until then: speed = 0.0)
    speed = 0.0
    # ----------------------------------------------------------------------------
    numbers = (position.x, position.y, yaw_from_quaternion(q), speed)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("one of its numbers is not finite")
    return numbers
