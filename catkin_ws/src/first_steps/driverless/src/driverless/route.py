"""The route as far as it is known, and the next point to drive to."""

from __future__ import annotations

import bisect
import math
from typing import Collection, Iterable

from world.waypoints import Waypoint


class Route:
    """The known points in the order of idx, and the current target.

    The order is cyclic: the first point follows the last one. Numbers may be missing or repeated.
    """

    def __init__(self) -> None:
        self.target: Waypoint | None = None
        self._known: list[Waypoint] = []
        self._last_reached: Waypoint | None = None
        self._has_map = False

    def set_map(self, points: Iterable[Waypoint]) -> None:
        """Replace the known points by the complete route; keep the progress."""
        self._has_map = True
        known = sorted(set(points))
        if known != self._known:
            self._known = known
            self._choose_target()

    def add_sensed(self, points: Iterable[Waypoint]) -> None:
        """Add points that the sensor detected, unless a map is set."""
        new = set(points).difference(self._known)
        if new and not self._has_map:
            self._known = sorted(new.union(self._known))
            self._choose_target()

    def update(
        self, x: float, y: float, sensed: Collection[Waypoint], reach_distance: float
    ) -> Waypoint | None:
        """Advance the target past every point that the car has reached, and return it.

        Without a map, a point that the sensor does not detect when the car reaches it no longer
        exists and is removed.

        Args:
            x: position of the car [u]
            y: position of the car [u]
            sensed: points that the sensor detects now
            reach_distance: a point at most this far away is reached [u]

        Returns:
            The target, or None if no point is known.
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
            self._choose_target()
        return self.target

    def _choose_target(self) -> None:
        if self._last_reached is not None and self._known:
            index = bisect.bisect_right(self._known, self._last_reached)
            self.target = self._known[index % len(self._known)]
        elif self.target not in self._known:
            self.target = None
