"""Lidars of the vehicle."""

from __future__ import annotations

# Positions on the vehicle: x forward, y left, z up, from its centre on the ground.
LIDAR_MOUNT_M = (0.0, 0.0, 2.4)
PLANAR_LIDAR_MOUNT_M = (2.35, 0.0, 0.6)
