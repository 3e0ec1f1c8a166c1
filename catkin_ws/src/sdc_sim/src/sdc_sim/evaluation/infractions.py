"""Detection of stop lines that the car crosses while their traffic light is red."""

from __future__ import annotations

import math
from collections import deque
from typing import Iterator

from sdc_common.driving import other_level
from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import RED, StopLine

# Lines this far before and after the part of the route that a tick covers are checked.
_MARGIN_M = 2.0
_MAX_CHANGES = 100
# A car waits for a light that is so near ahead [m].
_QUEUE_M = 100.0


class RedLightDetector:
    """Detector of crossings on red, judged by the light's state at the stamp of the crossing.

    Stamps are integers [ns]. If states carry stamps, a crossing is judged when the states of its
    time are known, whatever the order of arrival; otherwise by the last state received.
    """

    def __init__(self, car_front_m: float):
        self.car_front_m = car_front_m
        self.lines: dict = {}
        self._changes: deque = deque(maxlen=_MAX_CHANGES)
        self._known_until: int | None = None
        self.reset_car()

    def reset_car(self) -> None:
        """Forget the car's position and open crossings, but not the lights."""
        self._front_s: float | None = None
        self._now = 0
        self._crossed: list = []

    def set_lines(self, lines: dict) -> None:
        """Set the stop lines: fields of StopLine by light id."""
        self.lines = {light_id: StopLine(*line) for light_id, line in lines.items()}

    def is_relevant(self, states: dict) -> bool:
        """Return whether these states differ from the last ones, or a crossing needs them."""
        return bool(self._crossed) or not self._changes or self._changes[-1][1] != states

    def update_lights(self, stamp_ns: int, states: dict) -> int:
        """Set the states of all lights by their ids, at a stamp; 0: now.

        Returns:
            number of newly detected crossings on red
        """
        if stamp_ns or self._known_until is None:
            self._known_until = stamp_ns or None
            self._changes.append((stamp_ns or self._now, states))
        return self._count_red()

    def update_car(self, stamp_ns: int, route: Route, s_m: float, z_m: float = math.nan) -> int:
        """Move the car's centre to a place on the route, at the stamp of an odometry.

        Returns:
            number of newly detected crossings on red
        """
        front_s, before_s = s_m + self.car_front_m, self._front_s
        self._now = stamp_ns
        self._front_s = front_s if before_s is None else max(front_s, before_s)
        if before_s is not None and front_s > before_s:
            begin_s, ahead_m = max(0.0, before_s - _MARGIN_M), front_s - before_s + 2.0 * _MARGIN_M
            for light_id, line_s in self._lines_along(route, begin_s, ahead_m, z_m):
                if before_s < line_s <= front_s:
                    self._crossed.append((stamp_ns, light_id))
        return self._count_red()

    def holds(self, route: Route, s_m: float, z_m: float) -> bool:
        """Return whether a car at a place on the route may wait for a red light, in a queue."""
        states = self._changes[-1][1] if self._changes else {}
        return any(states.get(n) == RED for n, _ in self._lines_along(route, s_m, _QUEUE_M, z_m))

    def _lines_along(
        self, route: Route, from_m: float, ahead_m: float, z_m: float
    ) -> Iterator[tuple[int, float]]:
        for light_id, line in self.lines.items():
            line_s = line.along(route, from_m, ahead_m)
            if line_s is not None and not other_level(line.z_m, z_m):
                yield light_id, line_s

    def _count_red(self) -> int:
        until = self._known_until
        known = [crossing for crossing in self._crossed if until is None or until >= crossing[0]]
        self._crossed = [crossing for crossing in self._crossed if crossing not in known]
        return sum(self._state(*crossing) == RED for crossing in known)

    def _state(self, stamp_ns: int, light_id: int) -> int | None:
        for since, states in reversed(self._changes):
            if since <= stamp_ns:
                return states.get(light_id)
        return None
