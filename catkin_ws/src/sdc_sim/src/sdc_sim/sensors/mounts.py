"""Places of the sensors on the vehicle: x forward, y left, z up, from its centre on the ground."""

from __future__ import annotations

IMU_MOUNT_M = (0.0, 0.0, 0.5)
GNSS_MOUNT_M = (0.0, 0.0, 1.5)
LIDAR_MOUNT_M = (0.0, 0.0, 2.4)
PLANAR_LIDAR_MOUNT_M = (2.35, 0.0, 0.6)
