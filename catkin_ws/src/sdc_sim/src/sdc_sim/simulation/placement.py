"""Start pose of the vehicle relative to its route."""

from __future__ import annotations

import math

from sdc_common.geometry.route import Route


def start_pose(
    route: Route, along_m: float, left_m: float, turned_rad: float
) -> tuple[float, float, float]:
    """Return the pose (x [m], y [m], yaw [rad]) at a place relative to the route.

    Args:
        route: the route
        along_m: distance along the route [m]
        left_m: distance to the left of the route [m]
        turned_rad: angle from the direction of the route, positive left [rad]

    Raises:
        ValueError: the place is not on the route, or a value is not finite
    """
    if not 0.0 <= along_m <= route.length_m:
        raise ValueError(
            f"start along_m must be from 0 to the route's {route.length_m:.1f} m, got {along_m}"
        )
    if not (math.isfinite(left_m) and math.isfinite(turned_rad)):
        raise ValueError(
            f"start left_m and turned_rad must be finite, got {left_m} and {turned_rad}"
        )
    x, y = route.line.point_at(along_m)
    direction = route.line.direction_at(along_m)
    return (
        x - left_m * math.sin(direction),
        y + left_m * math.cos(direction),
        direction + turned_rad,
    )
