"""Conversion of the readings of sensors to ROS messages."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Vector3
from sensor_msgs.msg import Imu, JointState, NavSatFix, NavSatStatus, PointCloud2, PointField
from std_msgs.msg import Header

from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_sim.sensors.readings import WHEELS, GnssReading, ImuReading
from sdc_sim.sensors.settings import (
    GnssSettings,
    ImuSettings,
    LidarSettings,
    WheelSpeedSettings,
)

_WHEEL_NAMES = [wheel + "_wheel" for wheel in WHEELS]
_POINT_FIELDS = [
    PointField(name, 4 * number, PointField.FLOAT32, 1)
    for number, name in enumerate(("x", "y", "z", "intensity"))
]


def imu_message(reading: ImuReading, settings: ImuSettings, stamp: rospy.Time, frame: str) -> Imu:
    """Return acceleration and rotation; there is no orientation (REP 145)."""
    return Imu(
        header=Header(stamp=stamp, frame_id=frame),
        orientation_covariance=[-1.0] + [0.0] * 8,
        angular_velocity=Vector3(*reading.rate_radps),
        angular_velocity_covariance=_diagonal(settings.rate_noise_radps),
        linear_acceleration=Vector3(*reading.acceleration_mps2),
        linear_acceleration_covariance=_diagonal(settings.acceleration_noise_mps2),
    )


def gnss_message(
    reading: GnssReading, settings: GnssSettings, stamp: rospy.Time, frame: str
) -> NavSatFix:
    """Return latitude and longitude [deg]; NaN without a fix.

    The covariance is what a receiver knows: it contains no reflections.
    """
    message = NavSatFix(header=Header(stamp=stamp, frame_id=frame))
    message.status.service = NavSatStatus.SERVICE_GPS
    if not reading.has_fix:
        message.status.status = NavSatStatus.STATUS_NO_FIX
        message.latitude = message.longitude = message.altitude = math.nan
        return message
    message.latitude, message.longitude = geodetic_from_map(reading.x_m, reading.y_m)
    message.altitude = reading.z_m
    message.position_covariance = _diagonal(math.hypot(settings.noise_m, settings.bias_m))
    message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
    return message


def wheel_speeds_message(
    reading: Sequence[float], _settings: WheelSpeedSettings, stamp: rospy.Time, frame: str
) -> JointState:
    """Return the angular velocities of the wheels [rad/s]."""
    return JointState(
        header=Header(stamp=stamp, frame_id=frame), name=_WHEEL_NAMES, velocity=reading
    )


def point_cloud_message(
    reading: np.ndarray, _settings: LidarSettings, stamp: rospy.Time, frame: str
) -> PointCloud2:
    """Return the points (N, 4) of a scan: x, y, z [m] and intensity."""
    points = np.ascontiguousarray(reading, np.float32)
    return PointCloud2(
        header=Header(stamp=stamp, frame_id=frame),
        height=1,
        width=len(points),
        fields=_POINT_FIELDS,
        point_step=16,
        row_step=16 * len(points),
        data=points.tobytes(),
        is_dense=True,
    )


def _diagonal(deviation: float) -> list[float]:
    variance = deviation * deviation
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
