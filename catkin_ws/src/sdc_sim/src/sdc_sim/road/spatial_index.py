"""Look-up of many points: square cells of the map, and the segments of a line near points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

# So many points are compared with the segments at once, to bound the memory.
_POINTS_AT_ONCE = 4_000
# Larger than the number of rows of any map, so that no two cells near each other share a key.
COLUMN_STRIDE = 4_000_037


def cell_keys(cells: np.ndarray) -> np.ndarray:
    """Return one integer for each cell.

    Args:
        cells: (..., 2) column and row of the cells
    """
    return cells[..., 0] * COLUMN_STRIDE + cells[..., 1]


def cells_of(points_m: np.ndarray, cell_m: float) -> np.ndarray:
    """Return column and row of the cells in which points lie.

    Args:
        points_m: (N, 2) points [m]
        cell_m: side of a cell [m]

    Returns:
        (N, 2) integers
    """
    return np.floor(np.asarray(points_m) / cell_m).astype(np.int64)


class SegmentIndex:
    """Finds all segments near points, with a KD-tree of the segments' middles.

    `Polyline.nearest` is faster for one point and a few segments.
    """

    def __init__(self, starts_m: np.ndarray, ends_m: np.ndarray, reach_m: float):
        """Build the tree.

        Args:
            starts_m: (N, 2) start points of the segments [m]
            ends_m: (N, 2) end points of the segments [m]
            reach_m: segments farther from a point than this are ignored [m]
        """
        self._starts = starts_m
        self._steps = ends_m - starts_m
        self._middles = cKDTree(starts_m + 0.5 * self._steps)
        longest_m = float(np.linalg.norm(self._steps, axis=1).max())
        self._radius_m = reach_m + 0.5 * longest_m

    def nearest_offsets(self, points_m: np.ndarray) -> np.ndarray:
        """Return the signed distances (N,) of points (N, 2) from the nearest segment [m].

        They are positive to the left of the segment, and infinite where no segment is within reach.
        """
        nearest = np.full(len(points_m), np.inf)
        for rows, offsets in self.offsets(points_m):
            farthest_first = np.argsort(-np.abs(offsets), kind="stable")
            nearest[rows[farthest_first]] = offsets[farthest_first]
        return nearest

    def offsets(self, points_m: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the signed distances of points to every segment within reach.

        Args:
            points_m: (N, 2) points [m]

        Yields:
            (M,) rows of `points_m`, and (M,) distances of these points from one segment each,
            positive to the left of it [m]
        """
        for first in range(0, len(points_m), _POINTS_AT_ONCE):
            part = points_m[first : first + _POINTS_AT_ONCE]
            pairs = cKDTree(part).sparse_distance_matrix(
                self._middles, self._radius_m, output_type="ndarray"
            )
            rows, segments = pairs["i"], pairs["j"]
            step = self._steps[segments]
            offset = part[rows] - self._starts[segments]
            square = np.maximum(np.sum(step * step, axis=1), 1e-12)
            fraction = np.clip(np.sum(offset * step, axis=1) / square, 0.0, 1.0)
            away = offset - fraction[:, None] * step
            side = np.where(step[:, 0] * away[:, 1] - step[:, 1] * away[:, 0] >= 0.0, 1.0, -1.0)
            yield first + rows, np.hypot(away[:, 0], away[:, 1]) * side
