"""The map of the landmarks: trunks of trees and corners of buildings."""

from __future__ import annotations

import numpy as np

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import TREE, Scenery


def load_landmarks(waypoints_path: str) -> np.ndarray:
    """Return the landmarks (N, 2) of the world that a waypoint file describes.

    Raises:
        WaypointError: the file is bad
    """
    return landmarks(Road(load_waypoints(waypoints_path)).scenery())


def landmarks(scenery: Scenery) -> np.ndarray:
    """Return the positions (N, 2) of the trunks and of the corners of the buildings."""
    is_tree = scenery.kind == TREE
    built = np.flatnonzero(~is_tree)
    length, width = 0.5 * scenery.size_m[built, 0], 0.5 * scenery.size_m[built, 1]
    c, s = np.cos(scenery.yaw_rad[built]), np.sin(scenery.yaw_rad[built])
    corners = [
        scenery.position_m[built]
        + np.column_stack([u * c * length - v * s * width, u * s * length + v * c * width])
        for u in (-1.0, 1.0)
        for v in (-1.0, 1.0)
    ]
    return np.concatenate([scenery.position_m[is_tree], *corners])
