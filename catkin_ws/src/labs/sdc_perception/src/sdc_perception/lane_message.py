"""Read the message of a lane."""

from __future__ import annotations

from typing import Any

import numpy as np

from sdc_perception.lane_tracker import TrackedLane


def tracked_lane(message: Any) -> TrackedLane:
    """Return the lane of a sdc_perception/Lane.

    Raises:
        ValueError: the points are not a lane
    """
    points, curvatures = np.column_stack([message.x_m, message.y_m]), message.curvatures_1pm
    if not (len(points) == len(curvatures) > 1 and np.isfinite(points).all()):
        raise ValueError("the lane has fewer than two points, or one that is not finite")
    return TrackedLane(
        message.offset_m,
        message.heading_error_rad,
        message.curvature_1pm,
        message.confidence,
        message.visible_m,
        message.first_m,
        points,
        np.array(curvatures),
    )
