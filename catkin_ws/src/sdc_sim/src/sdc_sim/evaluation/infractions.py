"""Who crosses a stop line while its light is red."""

from __future__ import annotations

from collections import deque

from sdc_common.geometry.route import Route
from sdc_common.ros.stop_lines import RED, StopLine

# A line is looked for so far around the way of one odometry to the next.
_MARGIN_M = 2.0
_KEPT_CHANGES = 100


class RedLightDetector:
    """Watches the car's front against the stop lines, and judges a crossing by what the light showed at its stamp.

    Stamps are nanoseconds. Where states come with stamps, a crossing is judged as soon as the states of its time are known, in
    whatever order both are heard; else by what was heard last.
    """

    def __init__(self, car_front_m: float):
        self.car_front_m = car_front_m
        self.lines = {}
        self._changes = deque(maxlen=_KEPT_CHANGES)
        self._known_until = None
        self.begin()

    def begin(self) -> None:
        """Forget the car, not the lights."""
        self._front_s = None
        self._now = 0
        self._crossed = []

    def place(self, lines: dict) -> None:
        """Where the stop lines are, StopLines by their lights' numbers."""
        self.lines = {number: StopLine(*line) for number, line in lines.items()}

    def is_news(self, states: dict) -> bool:
        """Whether these states change anything, or settle a crossing."""
        return bool(self._crossed) or not self._changes or self._changes[-1][1] != states

    def show(self, stamp_ns: int, states: dict) -> int:
        """What all lights show since then, by number; a stamp of 0 means: since now. Returns how often a line was crossed on red,
        as far as that was not known before."""
        if stamp_ns or self._known_until is None:
            self._known_until = stamp_ns or None
            self._changes.append((stamp_ns or self._now, states))
        return self._settle()

    def move(self, stamp_ns: int, route: Route, s_m: float) -> int:
        """The car's centre is there along the route; returns as `show` does."""
        front_s, before_s = s_m + self.car_front_m, self._front_s
        self._now = stamp_ns
        self._front_s = front_s if before_s is None else max(front_s, before_s)
        if before_s is not None and front_s > before_s:
            for number, line in self.lines.items():
                line_s = line.along(
                    route, max(0.0, before_s - _MARGIN_M), front_s - before_s + 2.0 * _MARGIN_M
                )
                if line_s is not None and before_s < line_s <= front_s:
                    self._crossed.append((stamp_ns, number))
        return self._settle()

    def _settle(self) -> int:
        known = [
            crossing
            for crossing in self._crossed
            if self._known_until is None or self._known_until >= crossing[0]
        ]
        self._crossed = [crossing for crossing in self._crossed if crossing not in known]
        return sum(self._state(*crossing) == RED for crossing in known)

    def _state(self, stamp_ns: int, number: int):
        return next(
            (states.get(number) for since, states in reversed(self._changes) if since <= stamp_ns),
            None,
        )
