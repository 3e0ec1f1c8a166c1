"""Convert the route, the road, the planned path and the car to messages for RViz."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from geometry_msgs.msg import Point, PoseStamped, Vector3
from nav_msgs.msg import Path
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from sdc_sim.road.road_markings import RoadMarkings, speed_colours
from sdc_sim.ros.message_conversion import MAP_FRAME, VEHICLE_FRAME
from sdc_sim.yaml_document import packaged_config

# Heights above the ground [m]: one layer must not hide another.
_GRASS_M, _ASPHALT_M, _LINES_M, _ROUTE_M, _PATH_M = -0.12, -0.04, -0.02, 0.02, 0.1
_ASPHALT_COLOUR = (0.29, 0.30, 0.32)
_GRASS_COLOUR = (0.45, 0.56, 0.40)
_LINE_COLOUR = (0.92, 0.92, 0.90)
_LINE_WIDTH_M = 0.15
_PATH_WIDTH_M = 0.6
_GRASS_MARGIN_M = 150.0
_FIX_COLOUR = (1.0, 0.25, 0.85)
_FIX_SIZE_M = 0.35

_QUARTER_TURN = 0.5**0.5


def route_path(points_m: np.ndarray) -> Path:
    """Return an (N, 2) route in the map frame [m] as a nav_msgs/Path."""
    path = Path()
    path.header.frame_id = MAP_FRAME
    for x, y in np.asarray(points_m, dtype=float).tolist():
        pose = PoseStamped()
        pose.header.frame_id = MAP_FRAME
        pose.pose.position = Point(x, y, _ROUTE_M)
        pose.pose.orientation.w = 1.0
        path.poses.append(pose)
    return path


def road_markers(markings: RoadMarkings) -> MarkerArray:
    """Return the grass around a road, its asphalt and its lines. Clicks in RViz need surfaces."""
    x0, y0 = markings.surface.min(axis=(0, 1)) - _GRASS_MARGIN_M
    x1, y1 = markings.surface.max(axis=(0, 1)) + _GRASS_MARGIN_M
    corners = np.array([[(x0, y0), (x1, y0), (x1, y1), (x0, y1)]])
    grass = _surface("grass", corners, _GRASS_M, _GRASS_COLOUR)
    asphalt = _surface("asphalt", markings.surface, _ASPHALT_M, _ASPHALT_COLOUR)
    lines = _marker(Marker.LINE_LIST, MAP_FRAME, "lines", 0, _LINE_COLOUR)
    lines.scale.x = _LINE_WIDTH_M
    lines.points = _points(np.concatenate([markings.edges, markings.dashes]), _LINES_M)
    return MarkerArray([grass, asphalt, lines])


def path_marker(path: Sequence, full_speed_mps: float) -> Marker:
    """Return the local path as a line that is coloured by speed.

    Args:
        path: rows of x, y [m], target speed [m/s]; less than two rows delete the marker
        full_speed_mps: target speed that is shown green [m/s]

    Raises:
        ValueError: a value is not finite.
    """
    rows = np.asarray(path, dtype=float).reshape(-1, 3)
    if not np.isfinite(rows).all():
        raise ValueError("the path has a value that is not finite")
    marker = _marker(Marker.LINE_STRIP, MAP_FRAME, "local_path", 0, (1.0, 1.0, 1.0))
    marker.scale.x = _PATH_WIDTH_M
    if len(rows) < 2:
        marker.action = Marker.DELETE
        return marker
    marker.points = _points(rows[:, :2], _PATH_M)
    marker.colors = [
        ColorRGBA(r, g, b, 1.0) for r, g, b in speed_colours(rows[:, 2], full_speed_mps).tolist()
    ]
    return marker


def fixes_marker(points_m: Sequence[tuple[float, float]]) -> Marker:
    """Return positions of satellite navigation (x, y) in the map as dots."""
    marker = _marker(Marker.SPHERE_LIST, MAP_FRAME, "gnss", 0, _FIX_COLOUR)
    marker.scale.x = marker.scale.y = marker.scale.z = _FIX_SIZE_M
    marker.points = [Point(x, y, _FIX_SIZE_M) for x, y in points_m]
    return marker


def car_markers() -> MarkerArray:
    """Return the car in its own frame. RViz moves it with the transform of the frame."""
    markers = []
    for number, part in enumerate(packaged_config("rviz_car")):
        shape = getattr(Marker, part["shape"])
        marker = _marker(shape, VEHICLE_FRAME, "car", number, part["colour"])
        marker.frame_locked = True
        marker.pose.position, marker.scale = Point(*part["at"]), Vector3(*part["size"])
        if shape == Marker.CYLINDER:  # its axis is z by default
            marker.pose.orientation.x = marker.pose.orientation.w = _QUARTER_TURN
        markers.append(marker)
    return MarkerArray(markers)


def _marker(shape: int, frame: str, namespace: str, number: int, colour: tuple) -> Marker:
    marker = Marker(
        type=shape, action=Marker.ADD, ns=namespace, id=number, color=ColorRGBA(*colour, 1.0)
    )
    marker.header.frame_id = frame
    marker.pose.orientation.w = 1.0
    return marker


def _surface(namespace: str, quadrilaterals: np.ndarray, z_m: float, colour: tuple) -> Marker:
    marker = _marker(Marker.TRIANGLE_LIST, MAP_FRAME, namespace, 0, colour)
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    marker.points = _points(quadrilaterals[:, (0, 1, 2, 0, 2, 3)], z_m)
    # With one colour per triangle RViz switches its light off, which would darken the ground.
    marker.colors = [marker.color] * (2 * len(quadrilaterals))
    return marker


def _points(points_m: np.ndarray, z_m: float) -> list:
    return [Point(x, y, z_m) for x, y in points_m.reshape(-1, 2).tolist()]
