"""Count completed laps from the positions of the car."""

from __future__ import annotations

import math
from typing import Iterable

from world.waypoints import Waypoint


class LapCounter:
    """Counter of laps in which the car touches every waypoint in the order of idx.

    The first waypoint that is touched is the start and the finish.
    """

    def __init__(self, waypoints: Iterable[Waypoint], touch_distance: float):
        """Start to count.

        Args:
            waypoints: points of the route, in any order
            touch_distance: a waypoint at most this far from the car is touched [u]
        """
        self.touch_distance = touch_distance
        self.laps = 0
        self.set_waypoints(waypoints)

    def set_waypoints(self, waypoints: Iterable[Waypoint]) -> None:
        """Replace the route and restart the current lap; completed laps stay counted."""
        self._order = sorted(waypoints)
        self.restart_lap()

    def restart_lap(self) -> None:
        """Discard the current lap, for example after the car was moved by hand."""
        self._next: int | None = None
        self._passed = 0

    def update(self, x: float, y: float) -> bool:
        """Process a position of the car [u] and return True if it completes a lap."""
        if self._next is None:
            touched = [
                index for index, waypoint in enumerate(self._order) if self._touches(waypoint, x, y)
            ]
            if not touched:
                return False
            self._next = (touched[0] + 1) % len(self._order)
        # One position may touch several close points, but completes at most one lap.
        while self._touches(self._order[self._next], x, y):
            self._next = (self._next + 1) % len(self._order)
            self._passed += 1
            if self._passed == len(self._order):
                self._passed = 0
                self.laps += 1
                return True
        return False

    def _touches(self, waypoint: Waypoint, x: float, y: float) -> bool:
        return math.hypot(waypoint.x - x, waypoint.y - y) <= self.touch_distance
