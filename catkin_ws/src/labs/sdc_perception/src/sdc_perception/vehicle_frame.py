"""From the frame of the odometry, in which the lane stays, to the frame of the moving car."""

from __future__ import annotations

import math

import numpy as np


def in_vehicle_frame(points_m: np.ndarray, pose: tuple[float, float, float]) -> np.ndarray:
    """Return points (..., 2) as the car sees them: x forward, y to the left of it [m].

    Points and pose are those in the frame of the odometry.
    """
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    # TODO 7: the way from the car to the points, turned by -yaw (until then: return points_m)
    return (points_m - (x, y)) @ np.array([[c, -s], [s, c]])
    # ----------------------------------------------------------------------------
