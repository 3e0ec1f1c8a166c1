"""Places for the car: where it starts, and where a person points at in RViz."""

from __future__ import annotations

import math

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.ros.odometry import yaw_from_quaternion

FARTHEST_M = 1e5


class PlaceError(ValueError):
    """A place where nothing can be put; the message says why."""


def start_pose(route: Route, along_m: float, left_m: float, turned_rad: float):
    """(x, y, yaw) of a car that stands so far along the route and to its left, turned away from it to the left.

    Raises ValueError for a place that is not on the route, and for numbers that are not finite.
    """
    if not 0.0 <= along_m <= route.length_m:
        raise ValueError(
            f"start along_m must be from 0 to the route's {route.length_m:.1f} m, got {along_m}"
        )
    if not (math.isfinite(left_m) and math.isfinite(turned_rad)):
        raise ValueError(
            f"start left_m and turned_rad must be finite, got {left_m} and {turned_rad}"
        )
    piece = min(int(np.searchsorted(route.s, along_m, side="right")) - 1, len(route.s) - 2)
    (x, y), heading = (
        route.points[piece].tolist(),
        float(Route(route.points[piece : piece + 2]).heading[0]),
    )
    ahead_m = along_m - float(route.s[piece])
    c, s = math.cos(heading), math.sin(heading)
    return x + ahead_m * c - left_m * s, y + ahead_m * s + left_m * c, heading + turned_rad


def checked_point(frame_id: str, point):
    """(x, y) of a point with x, y in the map. Raises PlaceError for another frame, NaN, infinity, and beyond 100 km."""
    if frame_id.lstrip("/") not in ("map", ""):
        raise PlaceError(f"it is in the frame '{frame_id}'; set RViz's Fixed Frame to map")
    if not (math.isfinite(point.x) and math.isfinite(point.y)):
        raise PlaceError(f"({point.x}, {point.y}) is not finite")
    if max(abs(point.x), abs(point.y)) > FARTHEST_M:
        raise PlaceError(
            f"({point.x:g}, {point.y:g}) is farther than {FARTHEST_M:g} m from the origin"
        )
    return point.x, point.y


def checked_pose(frame_id: str, pose):
    """(x, y, yaw) of a pose in the map. Raises PlaceError as checked_point does, and for an orientation that is none."""
    x, y = checked_point(frame_id, pose.position)
    q = pose.orientation
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise PlaceError("its orientation is not a unit quaternion")
    return x, y, yaw_from_quaternion(q)
