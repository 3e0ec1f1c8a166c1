"""Speed control: compute the acceleration with which the car keeps the planned speed."""

from __future__ import annotations

from dataclasses import dataclass

from sdc_common.validation import check_positive
from sdc_package.obstacles import FIRM_MPS2, HARD_MPS2
from sdc_package.pid import Pid, PidGains

_STOP_WITHIN_M = 0.12
# A car that is faster at a stop would pass it by more than the gap before a line.
_TOO_FAST_MPS = 1.0
_COASTING_MPS2 = 0.4
# A car that has just stopped stays so long [s].
_STAYS_S = 0.6
# A car that is faster than planned by more than the first, or plans to brake harder than usual, has
# just seen something; one that is faster by the second has seen it late.
_NEW_MPS, _USUAL_MPS2, _LATE_MPS = 1.5, 3.05, 3.3
# For some time after it has accelerated by more than the second, it brakes no harder than by the
# third at first: a comfortable jerk is an average over 1.5 s. One that is faster by the last does.
_EASES_S, _PUSHES_MPS2, _EASED_MPS2, _SOON_LATE_MPS = 0.8, 0.5, 1.8, 2.6


@dataclass(frozen=True)
class SpeedControlLimits:
    """Limits of the speed control, all positive."""

    acceleration_mps2: float  # maximum acceleration [m/s^2]
    braking_mps2: float  # maximum deceleration [m/s^2]
    jerk_mps3: float  # maximum change of the acceleration [m/s^3]
    standstill_mps: float  # below this speed, with a target below it, the brake holds the car [m/s]
    hold_mps2: float  # deceleration that holds the car [m/s^2]
    # Time ahead over which the planned acceleration is averaged, so that the pedals move before a
    # bend and not in it [s]
    preview_s: float
    preview_min_m: float  # minimum length of that preview [m]
    # The same change while the car brakes for what it has just seen [m/s^3]
    emergency_jerk_mps3: float

    def __post_init__(self):
        check_positive(**vars(self))


class SpeedControl:
    """PID on the speed error plus the planned acceleration, limited in acceleration and jerk.

    Attributes:
        acceleration_mps2: the last result [m/s^2]
    """

    def __init__(self, gains: PidGains, limits: SpeedControlLimits):
        self.limits = limits
        self.pid = Pid(gains, -limits.braking_mps2, limits.acceleration_mps2)
        self._stays_s = self._eases_s = 0.0
        self.reset()

    def reset(self) -> None:
        """Return to the initial state."""
        self.pid.reset()
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
        limits, ends = self.limits, target_mps**2 + 2.0 * planned_mps2 * self.preview_m(speed_mps)
        if ends > speed_mps**2 and planned_mps2 < -limits.braking_mps2:
            target_mps, planned_mps2 = ends**0.5, 0.0  # the plan behind the car is an older one
        # A car that stands this close to its stop stays: it would start too hard and pass it.
        is_at_stop = target_mps * target_mps < -2.0 * planned_mps2 * _STOP_WITHIN_M
        stays = target_mps < limits.standstill_mps or (is_at_stop and self.acceleration_mps2 >= 0.0)
        stays |= planned_mps2 < -limits.braking_mps2  # a stop that it would pass
        stands = speed_mps < limits.standstill_mps and stays and planned_mps2 <= 0.0
        if stands and self.acceleration_mps2 < -_COASTING_MPS2:
            self._stays_s = _STAYS_S
        if stands or self._stays_s > 0.0:
            self.reset()
            self._stays_s -= dt_s
            return -limits.hold_mps2
        coasts = self.acceleration_mps2 > -_COASTING_MPS2
        if target_mps == 0.0 and (coasts or speed_mps > _TOO_FAST_MPS):
            # What a slow start has gathered must not push the car past a stop.
            self.pid.integral = min(self.pid.integral, 0.0)
        if target_mps == 0.0 and speed_mps > _TOO_FAST_MPS:  # after a stop, nothing is planned
            planned_mps2 = min(planned_mps2, -FIRM_MPS2)
        change = limits.jerk_mps3 * dt_s
        last_mps2, faster_mps = self.acceleration_mps2, speed_mps - target_mps
        self._eases_s = _EASES_S if last_mps2 > _PUSHES_MPS2 else self._eases_s - dt_s
        is_new = faster_mps > _NEW_MPS or planned_mps2 < -_USUAL_MPS2
        eases = is_new and self._eases_s > 0.0 and faster_mps < _SOON_LATE_MPS
        hardest_mps2 = max(_EASED_MPS2 if eases else HARD_MPS2, -last_mps2)
        hardest_mps2 = limits.braking_mps2 if faster_mps > _LATE_MPS else hardest_mps2
        harder = limits.emergency_jerk_mps3 * dt_s if is_new else change
        lower = max(last_mps2 - harder, -min(hardest_mps2, limits.braking_mps2))
        upper = min(limits.acceleration_mps2, last_mps2 + change)
        self.acceleration_mps2, _ = self.pid.update(
            target_mps, speed_mps, dt_s, planned_mps2, lower, upper
        )
        return self.acceleration_mps2
