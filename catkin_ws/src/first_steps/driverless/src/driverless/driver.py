"""The driver: from what the car knows and where it is to how far it turns."""

from __future__ import annotations

import math

from driverless.route import Point, Route
from driverless.steering import clamp, heading_error, needs_run_up


class Driver:
    """Follows the points in the order of idx, lap after lap; `settings` are those of driverless.settings."""

    def __init__(self, settings):
        self.settings = settings
        self._route = Route()
        self._sensed = set()
        self._position = None
        self._is_running_up = False
        self._steps_in_vain = 0
        self._search_turn_left = 0.0

    def set_map(self, points):
        """Takes all points of the route, (idx, x, y) each. Raises ValueError for a point that is none."""
        self._route.set_map(_points(points))

    def set_sensed(self, points):
        """Takes the points that the sensor reports now, as set_map takes them all."""
        self._sensed = set(_points(points))
        self._route.add_sensed(self._sensed)

    def step(self, x, y, direction):
        """The turn to command from this position, radians, within +-max_turn, and the target or None.

        Call it once for each position of the car. Raises ValueError for a position that is none.
        """
        if not all(math.isfinite(value) for value in (x, y, direction)):
            raise ValueError(f"position ({x}, {y}, {direction}) is not finite")
        step_length = (
            math.hypot(x - self._position[0], y - self._position[1]) if self._position else 0.0
        )
        self._position = (x, y)
        target = self._route.update(x, y, self._sensed, self.settings.reach_distance)
        if target is None:
            return self._search(), None
        self._steps_in_vain, self._search_turn_left = 0, 0.0
        turning_radius = step_length / self.settings.max_turn
        self._is_running_up = needs_run_up(
            self._is_running_up,
            x,
            y,
            direction,
            target.x,
            target.y,
            turning_radius,
            self.settings.reach_distance,
        )
        if self._is_running_up:
            return 0.0, target
        error = heading_error(x, y, direction, target.x, target.y)
        return clamp(self.settings.turn_gain * error, self.settings.max_turn), target

    def _search(self):
        """While nothing is known: straight on, and now and then a turn that never leads back to an old line."""
        self._steps_in_vain += 1
        if self._steps_in_vain % self.settings.search_patience == 0:
            self._search_turn_left = self.settings.search_turn
        turn = clamp(self._search_turn_left, self.settings.max_turn)
        self._search_turn_left -= turn
        return turn


def _points(points):
    points = [Point(*point) for point in points]
    for point in points:
        if not (math.isfinite(point.x) and math.isfinite(point.y)):
            raise ValueError(f"waypoint {point.idx} at ({point.x}, {point.y}) is not finite")
    return points
