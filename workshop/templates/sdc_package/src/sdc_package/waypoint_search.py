"""Find the waypoint that the car drives to next."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

# Consecutive waypoints around the last result that are compared without the KD-tree.
_WINDOW = 5
# The nearest of them must be so near to be accepted.
_NEAR_M = 2.0
# Every so many calls, the KD-tree is queried all the same.
_QUERY_EVERY = 20


class WaypointSearch:
    """A search for the next waypoint of a route.

    A KD-tree finds the nearest of N points in about log(N) steps (J. L. Bentley, Communications of
    the ACM 18(9), 1975). For a car that drives on, the search compares a few waypoints around its
    last result first, which is faster.

    Attributes:
        waypoints: (N, 2) points [m]
        tree: KD-tree of these points
    """

    def __init__(self, waypoints_m: np.ndarray):
        """Build the tree of (N, 2) waypoints, N >= 2 [m]."""
        self.waypoints = waypoints_m
        self.tree = cKDTree(waypoints_m)
        self._points: list[list[float]] = waypoints_m.tolist()
        # From the waypoint before each one to the one after it.
        padded = np.pad(waypoints_m, ((1, 1), (0, 0)), "edge")
        self._along_route = padded[2:] - padded[:-2]
        self._last: int | None = None
        self._calls_without_tree = 0

    def nearest(self, x_m: float, y_m: float) -> int:
        """Return the index of the waypoint nearest to a point."""
        # TODO 5: query the KD-tree, which returns a distance and an index (until then: return 0)
        return 0
        # ------------------------------------------------------------------------

    def is_behind(self, index: int, x_m: float, y_m: float) -> bool:
        """Return whether a car at this point, on its way along the route, has passed a waypoint."""
        along_route = self._along_route[index]
        # TODO 6: does to_waypoint point against the route? (until then: return False)
        return False
        # ------------------------------------------------------------------------

    def first_ahead(self, x_m: float, y_m: float) -> int:
        """Return the index of the first waypoint ahead of the car, at most the last one."""
        index = self._nearest_in_window(x_m, y_m)
        if index is None:
            index, self._calls_without_tree = self.nearest(x_m, y_m), 0
        behind = self.is_behind(index, x_m, y_m)
        self._last = index
        return min(index + behind, len(self.waypoints) - 1)

    def _nearest_in_window(self, x_m: float, y_m: float) -> int | None:
        """Return the index of the nearest waypoint if it is close to the last result, else None."""
        if self._last is None or self._calls_without_tree >= _QUERY_EVERY:
            return None
        self._calls_without_tree += 1
        first = max(self._last - 1, 0)
        rows = self._points[first : first + _WINDOW]
        squares = [(x - x_m) ** 2 + (y - y_m) ** 2 for x, y in rows]
        best = squares.index(min(squares))
        # Far away, or at the edge of the window, a waypoint outside the window may be nearer.
        if squares[best] > _NEAR_M**2 or best == len(rows) - 1 or (best == 0 and first > 0):
            return None
        return first + best
