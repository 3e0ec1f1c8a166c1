"""Finds the waypoint that a car drives to next: the nearest one, or the one after it when that is behind the car."""
from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree


class WaypointSearch:
    """Looks for places among the (N, 2) waypoints of a route, metres, N >= 2. A KD-tree finds the nearest of N points in about log(N)
    steps (J. L. Bentley, Communications of the ACM 18(9), 1975)."""

    def __init__(self, waypoints_m: np.ndarray):
        self.waypoints = waypoints_m
        self.tree = cKDTree(waypoints_m)

    def nearest(self, x_m: float, y_m: float) -> int:
        """Index of the waypoint nearest to a point."""
        # TODO 5: ask the KD-tree; it answers with a distance and an index (until then: return 0)
        return 0
        # ------------------------------------------------------------------------

    def is_behind(self, index: int, x_m: float, y_m: float) -> bool:
        """Whether a car at this point, on its way along the route, has passed waypoint `index`."""
        before, after = max(index - 1, 0), min(index + 1, len(self.waypoints) - 1)
        along_route = self.waypoints[after] - self.waypoints[before]
        # TODO 6: does the way from the car to the waypoint lead against the route? A dot product tells (until then: return False)
        return False
        # ------------------------------------------------------------------------

    def first_ahead(self, x_m: float, y_m: float) -> int:
        """Index of the first waypoint that is not behind the car; of the last one where the route is over."""
        index = self.nearest(x_m, y_m)
        if self.is_behind(index, x_m, y_m):
            index += 1
        return min(index, len(self.waypoints) - 1)
