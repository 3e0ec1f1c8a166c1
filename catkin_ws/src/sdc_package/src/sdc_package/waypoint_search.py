"""Find the waypoint that the car drives to next."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree


class WaypointSearch:
    """A search for the next waypoint of a route.

    A KD-tree finds the nearest of N points in about log(N) steps (J. L. Bentley, Communications of
    the ACM 18(9), 1975).

    Attributes:
        waypoints: (N, 2) points [m]
        tree: KD-tree of these points
    """

    def __init__(self, waypoints_m: np.ndarray):
        """Build the tree of (N, 2) waypoints, N >= 2 [m]."""
        self.waypoints = waypoints_m
        self.tree = cKDTree(waypoints_m)
        # From the waypoint before each one to the one after it.
        padded = np.pad(waypoints_m, ((1, 1), (0, 0)), "edge")
        self._along_route = padded[2:] - padded[:-2]

    def nearest(self, x_m: float, y_m: float) -> int:
        """Return the index of the waypoint nearest to a point."""
        # TODO 5: query the KD-tree, which returns a distance and an index (until then: return 0)
        _, index = self.tree.query((x_m, y_m))
        return int(index)
        # ------------------------------------------------------------------------

    def is_behind(self, index: int, x_m: float, y_m: float) -> bool:
        """Return whether a car at this point, on its way along the route, has passed a waypoint."""
        along_route = self._along_route[index]
        # TODO 6: does to_waypoint point against the route? (until then: return False)
        to_waypoint = self.waypoints[index] - (x_m, y_m)
        return bool(np.dot(to_waypoint, along_route) < 0.0)
        # ------------------------------------------------------------------------

    def first_ahead(self, x_m: float, y_m: float) -> int:
        """Return the index of the first waypoint ahead of the car, at most the last one."""
        index = self.nearest(x_m, y_m)
        return min(index + self.is_behind(index, x_m, y_m), len(self.waypoints) - 1)
