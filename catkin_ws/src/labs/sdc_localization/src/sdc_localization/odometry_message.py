"""Read the messages of the sensors, and write that of the odometry."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
from geometry_msgs.msg import TransformStamped

from sdc_localization.localizer import Estimate

# The rear wheels of a JointState, which do not steer.
_REAR_WHEELS = ("rear_left_wheel", "rear_right_wheel")
# Indices of x, y and yaw among the six coordinates of a pose in ROS: x, y, z, roll, pitch, yaw.
_POSE_INDICES = (0, 1, 5)


def wheel_speed(names: Sequence[str], speeds_radps: Sequence[float], radius_m: float) -> float:
    """Return the speed of the rear axle [m/s].

    Args:
        names: names of the wheels
        speeds_radps: angular velocity of each wheel
        radius_m: radius of the wheels

    Raises:
        ValueError: a rear wheel is missing, or a number is not finite
    """
    by_name = dict(zip(names, speeds_radps))
    missing = [name for name in _REAR_WHEELS if name not in by_name]
    if missing:
        raise ValueError(f"it has no wheel '{missing[0]}'")
    speed = radius_m * sum(by_name[name] for name in _REAR_WHEELS) / len(_REAR_WHEELS)
    if not math.isfinite(speed):
        raise ValueError("a wheel speed is not finite")
    return speed


def pose_covariance(covariance: np.ndarray) -> list:
    """Return the covariance of a pose as in geometry_msgs/PoseWithCovariance.

    Args:
        covariance: (3, 3) covariance of x, y and yaw

    Returns:
        36 numbers, the rows of a (6, 6) matrix for x, y, z, roll, pitch and yaw
    """
    rows = np.zeros((6, 6))
    # TODO 10: the numbers of x, y and yaw at their places (until then: pass)
    rows[np.ix_(_POSE_INDICES, _POSE_INDICES)] = covariance
    # ----------------------------------------------------------------------------
    return rows.ravel().tolist()


def fill_odometry(message: Any, estimate: Estimate) -> Any:
    """Write an estimate into a nav_msgs/Odometry, with its velocity in the frame of the car."""
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y = estimate.x_m, estimate.y_m
    orientation.z = math.sin(0.5 * estimate.yaw_rad)
    orientation.w = math.cos(0.5 * estimate.yaw_rad)
    message.pose.covariance = pose_covariance(estimate.covariance)
    linear = message.twist.twist.linear
    linear.x, linear.y = estimate.speed_mps, estimate.sideways_mps
    message.twist.twist.angular.z = estimate.yaw_rate_radps
    return message


def transform(odometry: Any) -> TransformStamped:
    """Return the transform from the map to the car of a nav_msgs/Odometry."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position, translation = odometry.pose.pose.position, message.transform.translation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    message.transform.rotation = odometry.pose.pose.orientation
    return message
