"""The driver: compute a turn from the car's position and the known points."""

from __future__ import annotations

import math
from typing import Iterable

from driverless.route import Point, Route
from driverless.settings import Settings
from driverless.steering import clamp, heading_error, needs_run_up


class Driver:
    """Driver that follows the points in the order of idx, lap after lap."""

    def __init__(self, settings: Settings):
        self.settings = settings
        self._route = Route()
        self._sensed: set[Point] = set()
        self._position: tuple[float, float] | None = None
        self._is_running_up = False
        self._steps_without_target = 0
        self._search_turn_left = 0.0

    def set_map(self, points: Iterable[tuple[int, float, float]]) -> None:
        """Set all points of the route.

        Args:
            points: (idx, x, y) of each point [u]

        Raises:
            ValueError: a coordinate is not finite
        """
        self._route.set_map(_points(points))

    def set_sensed(self, points: Iterable[tuple[int, float, float]]) -> None:
        """Set the points that the sensor detects now.

        Args:
            points: (idx, x, y) of each point [u]

        Raises:
            ValueError: a coordinate is not finite
        """
        self._sensed = set(_points(points))
        self._route.add_sensed(self._sensed)

    def step(self, x: float, y: float, direction: float) -> tuple[float, Point | None]:
        """Return the turn to command and the target; call it once for each position of the car.

        Args:
            x: position of the car [u]
            y: position of the car [u]
            direction: direction of the car [rad]

        Returns:
            The turn within +-max_turn [rad], and the target or None if no point is known.

        Raises:
            ValueError: a value is not finite
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
        self._steps_without_target, self._search_turn_left = 0, 0.0
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

    def _search(self) -> float:
        """Return the next turn of a search: straight on, with a turn per search_patience steps."""
        self._steps_without_target += 1
        if self._steps_without_target % self.settings.search_patience == 0:
            self._search_turn_left = self.settings.search_turn
        turn = clamp(self._search_turn_left, self.settings.max_turn)
        self._search_turn_left -= turn
        return turn


def _points(points: Iterable[tuple[int, float, float]]) -> list[Point]:
    named = [Point(*point) for point in points]
    for point in named:
        if not (math.isfinite(point.x) and math.isfinite(point.y)):
            raise ValueError(f"waypoint {point.idx} at ({point.x}, {point.y}) is not finite")
    return named
