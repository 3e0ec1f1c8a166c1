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
        """Start to count; a waypoint at most `touch_distance` [u] from the car is touched."""
        self.touch_distance = touch_distance
        self.laps = 0
        self.restart_lap(waypoints)

    def restart_lap(self, waypoints: Iterable[Waypoint]) -> None:
        """Discard the current lap: the car was moved by hand, or the route has new waypoints."""
        self._order = sorted(waypoints)
        self._next: int | None = None
        self._passed = 0

    def update(self, x: float, y: float) -> bool:
        """Process a position of the car [u] and return True if it completes a lap."""
        is_touched = [
            math.hypot(waypoint.x - x, waypoint.y - y) <= self.touch_distance
            for waypoint in self._order
        ]
        if self._next is None and True in is_touched:
            self._next = (is_touched.index(True) + 1) % len(self._order)
        # One position may touch several close points, but completes at most one lap.
        while self._next is not None and is_touched[self._next]:
            self._next = (self._next + 1) % len(self._order)
            self._passed += 1
            if self._passed == len(self._order):
                self._passed = 0
                self.laps += 1
                return True
        return False
