"""Positions that arrive late: the part of the lab whose filter the student designs."""

from __future__ import annotations

import numpy as np

from sdc_localization.localizer import Localizer, LocalizerSettings

# A position that is older than this is refused.
LONGEST_DELAY_S = 1.0
# Times of the same tick differ by less than this.
_ROUNDING_S = 1e-6


def use_at_once(
    localizer: Localizer, measured_s: float, x_m: float, y_m: float, variance_m2: float
) -> bool:
    """Correct the present state by a position of the past, as if it were measured now."""
    return localizer.add_position(x_m, y_m, variance_m2)


class LateLocalizer(Localizer):
    """A localizer whose positions arrive up to LONGEST_DELAY_S late, in the order of their times.

    It has one more method than Localizer:

    add_late_position(measured_s, x_m, y_m, variance_m2) -> bool
        Correct the state by a position that was measured at the time of an earlier call of `move`,
        or of the last one. Afterwards the state is what it would be had the position been there in
        time. Return whether it was used. An outlier, and what is older than LONGEST_DELAY_S, change
        nothing.
    """

    # TODO 13: add_late_position, and what it needs (until then: add_late_position = use_at_once)
    def __init__(self, settings: LocalizerSettings):
        super().__init__(settings)
        self._past: list = []  # measurements, state and covariance of each step of the last second

    def start(self, x_m: float, y_m: float, variance_m2: float, waypoints_m: np.ndarray) -> None:
        """See Localizer; what was before it is no past of this drive."""
        super().start(x_m, y_m, variance_m2, waypoints_m)
        self._past = [self._now()] if self._motion else []

    def move(self, time_s: float, wheel_mps: float, gyro_radps: float) -> None:
        """See Localizer."""
        super().move(time_s, wheel_mps, gyro_radps)
        self._past.append(self._now())
        while self._past[0][0][0] < self._time_s - LONGEST_DELAY_S - _ROUNDING_S:
            self._past.pop(0)

    def add_late_position(self, measured_s: float, *position: float) -> bool:
        """See the class."""
        present, past = self._now(), [*self._past]
        later: list = []
        while self._past and self._past[-1][0][0] > measured_s + _ROUNDING_S:
            later.insert(0, self._past.pop())
        if self._past:
            self._motion, self.state, self.covariance = self._past.pop()
            if self.add_position(*position):
                self._past.append(self._now())
                for motion, _, _ in later:
                    self.move(*motion)
                return True
        self._past = past
        self._motion, self.state, self.covariance = present
        return False

    def _now(self) -> tuple:
        return self._motion, self.state, self.covariance

    # ----------------------------------------------------------------------------
