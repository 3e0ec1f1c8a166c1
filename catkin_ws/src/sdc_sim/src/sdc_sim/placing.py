"""Checks the places that a person points at in RViz."""
from __future__ import annotations

import math

from sdc_package.odometry import yaw_from_quaternion

FARTHEST_M = 1e5


class PlaceError(ValueError):
    """A place where nothing can be put; the message says why."""


def checked_point(frame_id: str, point):
    """(x, y) of a point with x, y in the map. Raises PlaceError for another frame, NaN, infinity, and beyond 100 km."""
    if frame_id.lstrip("/") not in ("map", ""):
        raise PlaceError(f"it is in the frame '{frame_id}'; set RViz's Fixed Frame to map")
    if not (math.isfinite(point.x) and math.isfinite(point.y)):
        raise PlaceError(f"({point.x}, {point.y}) is not finite")
    if max(abs(point.x), abs(point.y)) > FARTHEST_M:
        raise PlaceError(f"({point.x:g}, {point.y:g}) is farther than {FARTHEST_M:g} m from the origin")
    return point.x, point.y


def checked_pose(frame_id: str, pose):
    """(x, y, yaw) of a pose in the map. Raises PlaceError as checked_point does, and for an orientation that is none."""
    x, y = checked_point(frame_id, pose.position)
    q = pose.orientation
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise PlaceError("its orientation is not a unit quaternion")
    return x, y, yaw_from_quaternion(q)
