"""Look-up of the segments of a line near many points."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

# So many points are compared with the segments at once, to bound the memory.
_POINTS_AT_ONCE = 4_000


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

    def between(self, points_m: np.ndarray, lower_m: float, upper_m: float) -> np.ndarray:
        """Return which points (N, 2) have a signed distance in this range from any segment (N,).

        Args:
            points_m: (N, 2) points [m]
            lower_m: least distance, positive to the left of the segment, within reach [m]
            upper_m: largest distance [m]
        """
        inside = np.zeros(len(points_m), bool)
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
            offsets = np.hypot(away[:, 0], away[:, 1]) * side
            inside[first + rows[(offsets >= lower_m) & (offsets <= upper_m)]] = True
        return inside
