"""A PID controller with limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.validation import check_finite

# Over a shorter time step the derivative is mostly noise.
_MIN_STEP_S = 1e-6


@dataclass(frozen=True)
class PidGains:
    """Gains of a PID controller."""

    kp: float  # output per unit of error
    ki: float = 0.0  # output per unit of error and second [1/s]
    kd: float = 0.0  # output per unit of error and 1/second [s]

    def __post_init__(self):
        check_finite(**vars(self))


class Pid:
    """PID with limited output; the integral stops growing while the output is limited.

    The derivative acts on the measurement, so that a step of the set-point does not kick the
    output.

    Attributes:
        integral: the integral part of the output

    Reference: K. J. Astrom and R. M. Murray, Feedback Systems, 2nd ed., sections 11.4 and 11.5.
    """

    def __init__(self, gains: PidGains, lower: float, upper: float):
        """Set gains and limits; raises ValueError if `lower` is not below `upper`."""
        if not lower < upper:
            raise ValueError(f"the lower limit must be below the upper limit, got {lower}, {upper}")
        self.gains, self.lower, self.upper = gains, lower, upper
        self.reset()

    def reset(self) -> None:
        """Return to the initial state."""
        self.integral = 0.0
        self._last_measurement: float | None = None

    def update(
        self,
        setpoint: float,
        measurement: float,
        dt_s: float,
        feed_forward: float = 0.0,
        lower: float | None = None,
        upper: float | None = None,
    ) -> tuple[float, bool]:
        """Return the output of one time step, and whether it is limited.

        Args:
            setpoint: wanted value
            measurement: measured value
            dt_s: time since the last step; a step of 0 s neither integrates nor differentiates [s]
            feed_forward: known part of the output
            lower: lower limit of this step, None for that of the controller
            upper: upper limit of this step, None for that of the controller

        Raises:
            ValueError: the time step is negative or not finite
        """
        if not (dt_s >= 0.0 and math.isfinite(dt_s)):
            raise ValueError(f"a time step must be finite and not negative, got {dt_s}")
        lower = self.lower if lower is None else lower
        upper = self.upper if upper is None else upper
        error = setpoint - measurement
        derivative = 0.0
        if dt_s >= _MIN_STEP_S and self._last_measurement is not None:
            derivative = (self._last_measurement - measurement) / dt_s
        self._last_measurement = measurement
        # TODO 2.6: the integral, and the sum of all parts (until then: integral = wanted = 0.0)
        integral = self.integral + self.gains.ki * error * dt_s
        wanted = feed_forward + self.gains.kp * error + integral + self.gains.kd * derivative
        # ------------------------------------------------------------------------
        output = min(max(wanted, lower), upper)
        saturated = output != wanted
        if not saturated or (wanted - output) * error < 0.0:
            self.integral = integral
        return output, saturated
