"""The driver: compute a turn from the car's position and the known points."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Iterable

from driverless.route import Route
from world.waypoints import Waypoint


def heading_error(x: float, y: float, direction: float, target: Waypoint) -> float:
    """Return the angle from the direction of a car at (x, y) [u] to the direction of the target.

    Returns:
        Angle within -pi..pi, positive to the left [rad]
    """
    return math.remainder(math.atan2(target.y - y, target.x - x) - direction, math.tau)


class Driver:
    """Driver that follows points of finite numbers in the order of idx, lap after lap."""

    def __init__(self, settings: SimpleNamespace):
        """Create a driver; `settings` are the parameters of config/driverless.yaml."""
        self.settings = settings
        self._route = Route()
        self._sensed: set[Waypoint] = set()
        self._position: tuple[float, float] | None = None
        self._is_running_up = False
        self._steps_without_target = 0
        self._search_turn_left = 0.0

    def set_map(self, points: Iterable[Waypoint]) -> None:
        """Set all points of the route."""
        self._route.set_map(points)

    def set_sensed(self, points: Iterable[Waypoint]) -> None:
        """Set the points that the sensor detects now."""
        self._sensed = set(points)
        self._route.add_sensed(self._sensed)

    def step(self, x: float, y: float, direction: float) -> tuple[float, Waypoint | None]:
        """Return the turn to command and the target; call it once for each position of the car.

        Args:
            x: position of the car [u]
            y: position of the car [u]
            direction: direction of the car [rad]

        Returns:
            The turn within +-max_turn [rad], and the target or None if no point is known.
        """
        last_x, last_y = self._position or (x, y)
        self._position = (x, y)
        target = self._route.update(x, y, self._sensed, self.settings.reach_distance)
        if target is None:
            return self._search(), None
        self._steps_without_target, self._search_turn_left = 0, 0.0
        error = heading_error(x, y, direction, target)
        turning_radius = math.hypot(x - last_x, y - last_y) / self.settings.max_turn
        if self._needs_run_up(x, y, direction, target, turning_radius):
            return 0.0, target
        return self._limited(self.settings.turn_gain * error), target

    def _needs_run_up(
        self, x: float, y: float, direction: float, target: Waypoint, turning_radius: float
    ) -> bool:
        """Return True if the car must drive straight on before it can turn to the target.

        A car that turns as sharply as it can drives on a circle next to it, and never reaches a
        target well inside that circle. A run-up begins when the target is inside by more than 0.8
        of `reach_distance` (not all of it, because the car is observed only at its steps). It ends
        when the target is outside. The two limits differ so that the car does not switch at every
        step.
        """
        side = math.copysign(turning_radius, heading_error(x, y, direction, target))
        centre_x, centre_y = x - side * math.sin(direction), y + side * math.cos(direction)
        distance = math.hypot(target.x - centre_x, target.y - centre_y)
        margin = 0.0 if self._is_running_up else 0.8 * self.settings.reach_distance
        self._is_running_up = distance < turning_radius - margin
        return self._is_running_up

    def _search(self) -> float:
        """Return the next turn of a search: straight on, with a turn per search_patience steps."""
        self._steps_without_target += 1
        if self._steps_without_target % self.settings.search_patience == 0:
            self._search_turn_left = self.settings.search_turn
        turn = self._limited(self._search_turn_left)
        self._search_turn_left -= turn
        return turn

    def _limited(self, turn: float) -> float:
        return min(max(turn, -self.settings.max_turn), self.settings.max_turn)
