"""The road and the planned speed as things to draw: segments, triangles and colours, for the map view and for RViz."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, MARGIN_M, Road

_EDGE_STEP_M = 1.0
# A road is painted piece by piece: the search for what lies on a line takes the square of its length.
_PIECE_M = 200.0
_STOP, _HALF, _FULL = np.array([(0.9, 0.1, 0.1), (1.0, 0.8, 0.1), (0.1, 0.8, 0.2)])


@dataclass(frozen=True)
class RoadMarkings:
    """edges, dashes (N, 2, 2): the segments of the lines; surface (N, 4, 2): quadrilaterals of asphalt, their corners in turn.
    All in metres in the map frame."""

    edges: np.ndarray
    dashes: np.ndarray
    surface: np.ndarray


def road_markings(road: Road) -> RoadMarkings:
    """The lines that can be seen, and the asphalt of every pass. At the ends the road reaches on beyond the route."""
    start_m, end_m = float(road.s_m[0]), float(road.s_m[-1])
    edges = [
        _visible_segments(
            *road.lane_points(offset, piece_m, min(piece_m + _PIECE_M, end_m), _EDGE_STEP_M)
        )
        for piece_m in np.arange(start_m, end_m, _PIECE_M).tolist()
        for offset in (road.right_edge_m, road.left_edge_m)
    ]

    dash_s = np.arange(start_m, end_m - DASH_LENGTH_M, DASH_PERIOD_M)
    ends = [road.at(s) for s in (dash_s, dash_s + DASH_LENGTH_M)]
    dashes = np.stack([points + road.centre_line_m * left for points, left in ends], axis=1)

    stations = road.stations(tolerance_m=0.02)
    points, left = road.points_m[stations], road.left[stations]
    right_side = points + (road.right_edge_m - MARGIN_M) * left
    left_side = points + (road.left_edge_m + MARGIN_M) * left
    surface = np.stack([right_side[:-1], right_side[1:], left_side[1:], left_side[:-1]], axis=1)
    return RoadMarkings(np.concatenate(edges), dashes, surface)


def _visible_segments(points: np.ndarray, seen: np.ndarray) -> np.ndarray:
    segments = np.stack([points[:-1], points[1:]], axis=1)
    return segments[seen[:-1] & seen[1:]]


def speed_colours(speeds_mps, full_speed_mps: float) -> np.ndarray:
    """Colours (N, 3), red, green and blue in 0..1, of (N,) speeds: red at a stop, yellow halfway, green from full_speed_mps on.

    Raises ValueError unless full_speed_mps is positive.
    """
    if not full_speed_mps > 0.0:
        raise ValueError(f"the speed that is shown green must be positive, got {full_speed_mps}")
    share = np.clip(np.asarray(speeds_mps, dtype=float).reshape(-1, 1) / full_speed_mps, 0.0, 1.0)
    return np.where(
        share < 0.5,
        _STOP + 2.0 * share * (_HALF - _STOP),
        _HALF + (2.0 * share - 1.0) * (_FULL - _HALF),
    )
