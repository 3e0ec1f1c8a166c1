"""Which point comes next: what the car knows of the route, and how far it got."""

from __future__ import annotations

import bisect
import math
from typing import NamedTuple


class Point(NamedTuple):
    """A point of the route; sorts by `idx`, so that points of the same idx are visited one after the other."""

    idx: int
    x: float
    y: float


class Route:
    """The points known so far, in order, and the one to drive to: round and round, whatever numbers are missing."""

    def __init__(self):
        self.target = None
        self._known = []
        self._last_reached = None
        self._has_map = False

    def set_map(self, points):
        """Takes the whole route at once; what was known before is forgotten, how far the car got is not."""
        self._has_map = True
        known = sorted(set(points))
        if known != self._known:
            self._known = known
            self._choose()

    def add_sensed(self, points):
        """Remembers points that the sensor reported, unless a map told them all already."""
        new = set(points).difference(self._known)
        if new and not self._has_map:
            self._known = sorted(new.union(self._known))
            self._choose()

    def update(self, x, y, sensed, reach_distance):
        """Moves the target on if the car at x, y has reached it; returns the target, None while nothing is known.

        A remembered point that is not among the `sensed` ones when the car gets there is gone, and forgotten.
        """
        if self.target is None and self._known:
            self.target = min(self._known, key=lambda point: math.hypot(point.x - x, point.y - y))
        for _ in range(len(self._known)):
            if (
                self.target is None
                or math.hypot(self.target.x - x, self.target.y - y) > reach_distance
            ):
                break
            self._last_reached = self.target
            if not self._has_map and self.target not in sensed:
                self._known.remove(self.target)
            self._choose()
        return self.target

    def _choose(self):
        """The first known point behind the one last reached; behind the last one, the first."""
        if self._last_reached is not None and self._known:
            place = bisect.bisect_right(self._known, self._last_reached)
            self.target = self._known[place % len(self._known)]
        elif self.target not in self._known:
            self.target = None
