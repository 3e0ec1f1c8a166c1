"""Finds the waypoint that a car drives to next: the nearest one, or the one after it when that is behind the car."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

# A car that drives on is near the waypoint of its last look: the tree is asked only where none of so many waypoints is so near, and
# every so many looks.
_LOOKED_AT = 5
_NEAR_M = 2.0
_ASK_EVERY = 20


class WaypointSearch:
    """Looks for places among the (N, 2) waypoints of a route, metres, N >= 2. A KD-tree finds the nearest of N points in about log(N)
    steps (J. L. Bentley, Communications of the ACM 18(9), 1975)."""

    def __init__(self, waypoints_m: np.ndarray):
        self.waypoints = waypoints_m
        self.tree = cKDTree(waypoints_m)
        self._last = None
        self._walked = 0

    def nearest(self, x_m: float, y_m: float) -> int:
        """Index of the waypoint nearest to a point."""
        # TODO 5: ask the KD-tree; it answers with a distance and an index (until then: return 0)
        _, index = self.tree.query((x_m, y_m))
        return int(index)
        # ------------------------------------------------------------------------

    def is_behind(self, index: int, x_m: float, y_m: float) -> bool:
        """Whether a car at this point, on its way along the route, has passed waypoint `index`."""
        before, after = max(index - 1, 0), min(index + 1, len(self.waypoints) - 1)
        along_route = self.waypoints[after] - self.waypoints[before]
        # TODO 6: does the way from the car to the waypoint lead against the route? A dot product tells (until then: return False)
        to_waypoint = self.waypoints[index] - (x_m, y_m)
        return bool(np.dot(to_waypoint, along_route) < 0.0)
        # ------------------------------------------------------------------------

    def first_ahead(self, x_m: float, y_m: float) -> int:
        """Index of the first waypoint that is not behind the car; of the last one where the route is over."""
        index = self._near_the_last(x_m, y_m)
        if index is None:
            index, self._walked = self.nearest(x_m, y_m), 0
        behind = self.is_behind(index, x_m, y_m)
        self._last = index
        return min(index + behind, len(self.waypoints) - 1)

    def _near_the_last(self, x_m: float, y_m: float):
        """Index of the nearest waypoint where it lies close to the last answer, as for a car that drives on; else None."""
        if self._last is None or self._walked >= _ASK_EVERY:
            return None
        self._walked += 1
        first = max(self._last - 1, 0)
        rows = self.waypoints[first : first + _LOOKED_AT].tolist()
        squares = [(x - x_m) ** 2 + (y - y_m) ** 2 for x, y in rows]
        best = squares.index(min(squares))
        # Far away, or on the edge of what was looked at, another one may be nearer.
        if squares[best] > _NEAR_M**2 or best == len(rows) - 1 or (best == 0 and first > 0):
            return None
        return first + best
