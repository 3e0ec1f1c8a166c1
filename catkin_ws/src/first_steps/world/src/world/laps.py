"""Counting laps: the referee of the field. It knows nothing of how the car is steered."""

from __future__ import annotations

import math


class LapCounter:
    """Counts rounds in which every waypoint was touched in the order of idx, none left out.

    The first waypoint touched, whichever it is, is the start and the finish. `touch_distance` in field units.
    """

    def __init__(self, waypoints, touch_distance):
        self.touch_distance = touch_distance
        self.laps = 0
        self.set_waypoints(waypoints)

    def set_waypoints(self, waypoints):
        """Takes another route and begins the lap anew; laps that were completed stay counted."""
        self._order = sorted(waypoints)
        self.restart_lap()

    def restart_lap(self):
        """Forgets the lap in progress, as after somebody carried the car elsewhere."""
        self._next = None
        self._passed = 0

    def update(self, x, y):
        """Takes the car's position; returns whether a lap was completed by it."""
        if self._next is None:
            touched = [
                place for place, waypoint in enumerate(self._order) if self._touches(waypoint, x, y)
            ]
            if not touched:
                return False
            self._next = (touched[0] + 1) % len(self._order)
        # Points may stand so close that one position touches several; never more than one lap a position.
        while self._touches(self._order[self._next], x, y):
            self._next = (self._next + 1) % len(self._order)
            self._passed += 1
            if self._passed == len(self._order):
                self._passed = 0
                self.laps += 1
                return True
        return False

    def _touches(self, waypoint, x, y):
        return math.hypot(waypoint.x - x, waypoint.y - y) <= self.touch_distance
