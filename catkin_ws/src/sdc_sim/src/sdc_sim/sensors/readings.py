"""What the sensors measure in one tick, and where they are on the vehicle."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


class ImuReading(NamedTuple):
    """Specific force and angular velocity in the frame of the vehicle (x forward, y left, z up)."""

    acceleration_mps2: Sequence[float]
    rate_radps: Sequence[float]


class GnssReading(NamedTuple):
    """A position in the map; all numbers are zero without a fix."""

    x_m: float
    y_m: float
    z_m: float
    has_fix: bool


class SensorReadings(NamedTuple):
    """Readings of one tick, None for a sensor that is off or not due.

    Attributes:
        imu: acceleration and rotation
        gnss: position
        speed_mps: speedometer, the speed in the direction of the vehicle
        wheel_speeds_radps: angular velocities in the order of WHEELS
        lidar: points of the lidar with 16 rings (N, 4): x, y, z [m] in its frame, intensity 0..1
        planar_lidar: points of the planar lidar, in the same form
    """

    imu: ImuReading | None = None
    gnss: GnssReading | None = None
    speed_mps: float | None = None
    wheel_speeds_radps: Sequence[float] | None = None
    lidar: np.ndarray | None = None
    planar_lidar: np.ndarray | None = None


IMU_MOUNT_M = (0.0, 0.0, 0.5)
GNSS_MOUNT_M = (0.0, 0.0, 1.5)
LIDAR_MOUNT_M = (0.0, 0.0, 2.4)
PLANAR_LIDAR_MOUNT_M = (2.35, 0.0, 0.6)
