"""The covariance of the odometry that the localizer publishes."""

from __future__ import annotations

import numpy as np

# Indices of x, y and yaw among the six coordinates of a pose in ROS: x, y, z, roll, pitch, yaw.
_POSE_INDICES = (0, 1, 5)


def pose_covariance(covariance: np.ndarray) -> list:
    """Return the covariance of x, y and yaw as in geometry_msgs/PoseWithCovariance.

    Returns:
        36 numbers, the rows of a (6, 6) matrix for x, y, z, roll, pitch and yaw
    """
    rows = np.zeros((6, 6))
    # TODO 10: the numbers of x, y and yaw at their places (until then: pass)
    rows[np.ix_(_POSE_INDICES, _POSE_INDICES)] = covariance
    # ----------------------------------------------------------------------------
    return rows.ravel().tolist()
