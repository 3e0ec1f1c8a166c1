"""A PID controller: no clock, no message."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.validation import check_finite

# Two measurements closer in time than this tell nothing about a rate.
_SHORTEST_STEP_S = 1e-6


@dataclass(frozen=True)
class PidGains:
    """Gains of a PID controller, in units of the output a unit of error (and a second of it, for ki and kd)."""

    kp: float
    ki: float = 0.0
    kd: float = 0.0

    def __post_init__(self):
        check_finite(**vars(self))


class Pid:
    """PID with clamped output; the integral stops growing while the output is saturated (conditional integration).

    The derivative acts on the measurement, so that a jump of the set-point does not kick the output.
    Source: K. J. Astrom and R. M. Murray, Feedback Systems (2nd ed.), chapter 11.4 and 11.5.
    """

    def __init__(self, gains: PidGains, lower: float, upper: float):
        if not lower < upper:
            raise ValueError(f"the lower limit {lower} must lie below the upper limit {upper}")
        self.gains = gains
        self.lower = lower
        self.upper = upper
        self.reset()

    def reset(self) -> None:
        """Forget the past: as new."""
        self.integral = 0.0
        self._last_measurement = None

    def update(
        self,
        setpoint: float,
        measurement: float,
        dt_s: float,
        feed_forward: float = 0.0,
        lower: float = None,
        upper: float = None,
    ):
        """One step of `dt_s` >= 0 seconds; returns (output, saturated).

        `lower` and `upper` replace the limits for this step only. A step of zero seconds neither integrates nor
        differentiates. Raises ValueError for a negative or non-finite time step.
        """
        if not (dt_s >= 0.0 and math.isfinite(dt_s)):
            raise ValueError(f"a time step must be finite and not negative, got {dt_s}")
        lower = self.lower if lower is None else lower
        upper = self.upper if upper is None else upper
        error = setpoint - measurement
        derivative = 0.0
        if dt_s >= _SHORTEST_STEP_S and self._last_measurement is not None:
            derivative = (self._last_measurement - measurement) / dt_s
        self._last_measurement = measurement
        # TODO 2.6: the new integral, and the sum of feed-forward and the three parts (until then: integral = wanted = 0.0)
        integral = self.integral + self.gains.ki * error * dt_s
        wanted = feed_forward + self.gains.kp * error + integral + self.gains.kd * derivative
        # ------------------------------------------------------------------------
        output = min(max(wanted, lower), upper)
        saturated = output != wanted
        if not saturated or (wanted - output) * error < 0.0:
            self.integral = integral
        return output, saturated
