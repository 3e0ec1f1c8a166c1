"""Speed control: compute the acceleration with which the car keeps the planned speed."""

from __future__ import annotations

from sdc_package.braking import (
    COASTING_MPS2,
    HARD_MPS2,
    ComfortRange,
    SpeedControlLimits,
    SpeedStep,
    StandstillHold,
)
from sdc_package.pid import Pid, PidGains

# A car that is faster at a stop would pass it by more than the gap before a line [m/s].
_TOO_FAST_MPS = 1.0


class SpeedControl:
    """PID on the speed error plus the planned acceleration, limited in acceleration and jerk.

    Attributes:
        acceleration_mps2: the last result [m/s^2]
    """

    def __init__(self, gains: PidGains, limits: SpeedControlLimits):
        self.limits = limits
        self.pid = Pid(gains, -limits.braking_mps2, limits.acceleration_mps2)
        self._standstill = StandstillHold(limits)
        self.reset()

    def reset(self) -> None:
        """Return to the initial state."""
        self.pid.reset()
        self._comfort = ComfortRange(self.limits)
        self.acceleration_mps2 = 0.0

    def preview_m(self, speed_mps: float) -> float:
        """Return the length over which to average the planned acceleration at this speed [m]."""
        return max(self.limits.preview_min_m, self.limits.preview_s * speed_mps)

    def acceleration(
        self, target_mps: float, planned_mps2: float, speed_mps: float, dt_s: float
    ) -> float:
        """Return the acceleration for the next time step [m/s^2].

        Args:
            target_mps: planned speed [m/s]
            planned_mps2: planned acceleration [m/s^2]
            speed_mps: measured speed [m/s]
            dt_s: time since the last call [s]
        """
        limits, last_mps2 = self.limits, self.acceleration_mps2
        ends = target_mps**2 + 2.0 * planned_mps2 * self.preview_m(speed_mps)
        if ends > speed_mps**2 and planned_mps2 < -limits.braking_mps2:
            # The point behind the car is of an older plan.
            target_mps, planned_mps2 = ends**0.5, 0.0
        step = SpeedStep(target_mps, planned_mps2, speed_mps, last_mps2, dt_s)
        if self._standstill.holds(step):
            self.reset()
            return -limits.hold_mps2
        if target_mps == 0.0 and (last_mps2 > -COASTING_MPS2 or speed_mps > _TOO_FAST_MPS):
            # What a slow start has gathered must not push the car past a stop.
            self.pid.integral = min(self.pid.integral, 0.0)
        if target_mps == 0.0 and speed_mps > _TOO_FAST_MPS:  # after a stop, nothing is planned
            planned_mps2 = min(planned_mps2, -HARD_MPS2)
        lowest_mps2, greatest_mps2 = self._comfort.next_range(
            step._replace(planned_mps2=planned_mps2)
        )
        self.acceleration_mps2, _ = self.pid.update(
            target_mps, speed_mps, dt_s, planned_mps2, lowest_mps2, greatest_mps2
        )
        return self.acceleration_mps2
