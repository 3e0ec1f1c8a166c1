"""Find the lane in a single picture, without knowledge from pictures before."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sdc_perception.ground_plane import GroundPlane
from sdc_perception.lane_model import are_inliers, best_lane
from sdc_perception.marking_filter import are_markings

_FARTHEST_M = 18.0
_WIDEST_M = 9.0
_ROW_STEP = 3
_TRIALS = 8000
_SCORED = 200
_FEWEST_INLIERS = 25
_MAX_OFFSET_M = 1.5
_MAX_HEADING_RAD = 0.4
_MAX_CURVATURE_1PM = 0.12


class LaneGuess(NamedTuple):
    """A lane next to the car: its centre is at y = -offset + heading x + curvature x^2 / 2."""

    offset_m: float  # distance of the car to the left of the lane's centre [m]
    heading_error_rad: float  # direction of the lane minus heading of the car [rad]
    curvature_1pm: float  # curvature of the lane [1/m]
    inliers: int  # number of points on its lines


def marking_points(
    mask: np.ndarray, gray: np.ndarray, ground: GroundPlane, row_step: int = _ROW_STEP
) -> np.ndarray:
    """Return ground points (N, 2) in the middle of the markings of a lane mask [m].

    A marking has two edges in each row, which are as far apart as it is wide, and it is brighter
    than what is next to it.

    Args:
        mask: (H, W) uint8, the result of LaneFilter
        gray: brightness (H, W) uint8
        ground: projection of the camera
        row_step: rows from one that is searched to the next
    """
    found = []
    for row in range(mask.shape[0] - 1, 0, -row_step):
        ends = np.diff(np.concatenate([[0], (mask[row] > 0).view(np.int8), [0]]))
        starts, stops = np.flatnonzero(ends > 0), np.flatnonzero(ends < 0)
        if len(starts) < 2:
            continue
        middles = 0.5 * (starts + stops - 1)
        edges = ground.points(np.column_stack([middles, np.full(len(middles), float(row))]))
        if not np.isfinite(edges).all() or edges[0, 0] > _FARTHEST_M:
            break
        width = np.hypot(*np.diff(edges, axis=0).T)
        inside = _at(gray[row], 0.5 * (middles[:-1] + middles[1:]))
        wide = np.diff(middles)
        beside = _at(gray[row], middles[:-1] - wide), _at(gray[row], middles[1:] + wide)
        marking = are_markings(width, inside, *beside)
        found.append(0.5 * (edges[:-1] + edges[1:])[marking])
    points = np.concatenate(found) if found else np.zeros((0, 2))
    return points[np.abs(points[:, 1]) < _WIDEST_M]


def _at(row: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the brightness of a row of a picture at columns, or at its ends."""
    return row[np.clip(np.round(columns), 0, len(row) - 1).astype(int)].astype(float)


def acquire_lane(points_m: np.ndarray, lines_m: np.ndarray) -> LaneGuess | None:
    """Return the lane whose lines pass through most of the points, or None.

    Reference: M. A. Fischler and R. C. Bolles, Random Sample Consensus, Communications of the ACM
    24(6), 1981. The random numbers have a fixed seed, so that the result is repeatable.

    Args:
        points_m: points (N, 2) on markings in the vehicle frame [m]
        lines_m: offsets (3,) of the lines from the lane's centre [m]
    """
    if len(points_m) < _FEWEST_INLIERS:
        return None
    random = np.random.RandomState(0)
    sample = points_m[random.randint(len(points_m), size=(_TRIALS, 3))]
    line = lines_m[random.randint(3, size=(_TRIALS, 3))]
    x = sample[..., 0]
    design = np.stack([-np.ones_like(x), x, 0.5 * x * x], axis=2)
    solvable = np.abs(np.linalg.det(design)) > 1.0
    lanes = np.linalg.solve(design[solvable], (sample[..., 1] - line)[solvable][..., None])[..., 0]
    limits = (_MAX_OFFSET_M, _MAX_HEADING_RAD, _MAX_CURVATURE_1PM)
    lanes = lanes[np.all(np.abs(lanes) < limits, axis=1)]
    if len(lanes) == 0:
        return None
    every = points_m[:: -(-len(points_m) // _SCORED)]
    lane = best_lane(lanes, every, lines_m)
    for _ in range(3):
        near = are_inliers(lane[None], points_m, lines_m)[0]
        rows, number = np.nonzero(near)
        if len(rows) < _FEWEST_INLIERS:
            return None
        x = points_m[rows, 0]
        design = np.column_stack([-np.ones_like(x), x, 0.5 * x * x])
        lane = np.linalg.lstsq(design, points_m[rows, 1] - lines_m[number], rcond=None)[0]
    return LaneGuess(float(lane[0]), float(lane[1]), float(lane[2]), len(rows))
