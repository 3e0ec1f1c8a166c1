"""The road and the planned speed as shapes and colours, for the map view and RViz."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, MARGIN_M, Road

_EDGE_STEP_M = 1.0
_SURFACE_TOLERANCE_M = 0.02
# Red, green and blue at a stop, at half speed and at full speed.
SPEED_COLOURS = ((0.9, 0.1, 0.1), (1.0, 0.8, 0.1), (0.1, 0.8, 0.2))


@dataclass(frozen=True)
class RoadMarkings:
    """Shapes of a road in the map frame."""

    edges: np.ndarray  # (N, 2, 2) segments of the solid lines [m]
    dashes: np.ndarray  # (N, 2, 2) segments of the dashed line [m]
    surface: np.ndarray  # (N, 4, 2) quadrilaterals of asphalt, corners in order [m]


def road_markings(road: Road) -> RoadMarkings:
    """Return the visible lines and the asphalt of a road, with its ends outside the route."""
    start_m, end_m = float(road.s_m[0]), float(road.s_m[-1])
    s = start_m + _EDGE_STEP_M * np.arange(int((end_m - start_m) / _EDGE_STEP_M + 1e-9) + 1)
    edges = [
        _visible_segments(*lane_points(road, offset_m, s))
        for offset_m in (road.right_edge_m, road.left_edge_m)
    ]

    dash_s = np.arange(start_m, end_m - DASH_LENGTH_M, DASH_PERIOD_M)
    ends = [road.at(s) for s in (dash_s, dash_s + DASH_LENGTH_M)]
    dashes = np.stack([points + road.centre_line_m * left for points, left in ends], axis=1)

    ends = stations(road, _SURFACE_TOLERANCE_M)
    points, left = road.points_m[ends], road.left[ends]
    right_side = points + (road.right_edge_m - MARGIN_M) * left
    left_side = points + (road.left_edge_m + MARGIN_M) * left
    surface = np.stack([right_side[:-1], right_side[1:], left_side[1:], left_side[:-1]], axis=1)
    return RoadMarkings(np.concatenate(edges), dashes, surface)


def stations(road: Road, tolerance_m: float, longest_m: float = 8.0) -> np.ndarray:
    """Return the indices of samples between which the road, edges included, is straight.

    Args:
        road: the road
        tolerance_m: largest distance between the road and a straight piece of it [m]
        longest_m: longest distance between two stations [m]
    """
    reach_m = road.left_edge_m + 1.0
    turns = np.abs(np.diff(np.unwrap(road.heading_rad))).tolist()
    kept = [0]
    length = angle = 0.0
    for i, (step, turn) in enumerate(zip(np.diff(road.s_m).tolist(), turns)):
        bow = (length + step + reach_m * (angle + turn)) * (angle + turn) / 8.0
        if length > 0.0 and (length + step > longest_m or bow > tolerance_m):
            kept.append(i)
            length = angle = 0.0
        length += step
        angle += turn
    kept.append(len(road.s_m) - 1)
    return np.array(kept)


def lane_points(road: Road, offset_m: float, s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points on a line so far to the left of the route, and which of them are visible.

    A point is hidden where the line folds over itself inside a tight turn, or where another
    pass of the road covers it.

    Returns:
        points (N, 2) [m] and the mask (N,) of the visible ones
    """
    points, left = road.at(s_m)
    points = points + offset_m * left
    reach_m = abs(offset_m) - 0.05
    visible = ~road.between(points, -reach_m, reach_m)
    if offset_m <= road.right_edge_m or offset_m >= road.left_edge_m:
        visible &= ~road.between(points, road.right_edge_m + 0.1, road.left_edge_m - 0.1)
    return points, visible


def _visible_segments(points: np.ndarray, visible: np.ndarray) -> np.ndarray:
    segments = np.stack([points[:-1], points[1:]], axis=1)
    return segments[visible[:-1] & visible[1:]]


def speed_colours(speeds_mps: Sequence[float] | np.ndarray, full_speed_mps: float) -> np.ndarray:
    """Return the colours of speeds: red at a stop, yellow at half speed, green at full speed.

    Returns:
        (N, 3) red, green and blue in 0..1
    """
    share = np.asarray(speeds_mps, dtype=float) / full_speed_mps
    return np.stack(
        [np.interp(share, (0.0, 0.5, 1.0), values) for values in zip(*SPEED_COLOURS)], -1
    )
