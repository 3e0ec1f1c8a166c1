"""What a car measures of itself: odometry with seeded noise, and lines that delay measurements and commands."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np

from sdc_common.validation import check_non_negative, check_positive


class OdometryNoise:
    """Adds independent Gaussian noise to each odometry: standard deviations of position (each axis), heading and speed.

    The same seed gives the same noise on every machine (NumPy's RandomState keeps its streams between versions). All
    four draws are made each time, so that switching one kind of noise off leaves the other kinds as they were; with
    every sigma zero the input comes back untouched. Raises ValueError for a sigma that is negative or no number.
    """

    def __init__(
        self, seed: int, position_m: float = 0.0, heading_rad: float = 0.0, speed_mps: float = 0.0
    ):
        for name, sigma in (
            ("position_m", position_m),
            ("heading_rad", heading_rad),
            ("speed_mps", speed_mps),
        ):
            check_non_negative(**{f"odometry_noise.{name}": sigma})
        self._sigmas = (position_m, position_m, heading_rad, speed_mps)
        self._random = np.random.RandomState(seed)
        self.draws = 0

    def apply(
        self, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> tuple[float, float, float, float]:
        """The (x, y, yaw, speed) that is measured where the true ones are these."""
        true = (x_m, y_m, yaw_rad, speed_mps)
        if not any(self._sigmas):
            return true
        draws = self._random.standard_normal(4).tolist()
        self.draws += 1
        return tuple(
            value + sigma * draw if sigma else value
            for value, sigma, draw in zip(true, self._sigmas, draws)
        )

    def skip(self, draws: int) -> None:
        """Go on as after that many calls of `apply` that drew: the noise of a drive that is taken up again."""
        self.draws += draws
        while draws > 0:
            self._random.standard_normal(4 * min(draws, 100_000))
            draws -= 100_000


class DelayLine:
    """A line that gives back each tick what was put into it delay_s before.

    The delay is rounded to whole ticks (`ticks`; halves upwards): with a tick of 0.05 s, 0.12 s become 2 ticks and
    0.02 s none. Raises ValueError for a delay that is negative or no number, and for a tick that is not positive.
    """

    def __init__(self, delay_s: float, tick_s: float):
        check_non_negative(delay_s=delay_s)
        check_positive(tick_s=tick_s)
        # A delay of 1.5 ticks must not fall to 1 because 0.15 / 0.1 is 1.4999...
        self.ticks = int(math.floor(delay_s / tick_s + 0.5 + 1e-9))
        self._line = deque()

    def put(self, item: Any) -> Any | None:
        """Put this tick's item in; returns the item of `ticks` ticks ago, None while the line fills."""
        self._line.append(item)
        return self._line.popleft() if len(self._line) > self.ticks else None

    def clear(self) -> None:
        """Empty the line, as after a reset of the car."""
        self._line.clear()

    @property
    def items(self) -> list:
        """What is in the line, the oldest first."""
        return list(self._line)

    def fill(self, items) -> None:
        """Put these into the line, the oldest first, in place of what is in it."""
        self._line = deque(items)
