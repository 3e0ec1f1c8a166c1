"""Speed control: how hard to accelerate or brake so that the car keeps the planned speed."""

from __future__ import annotations

from dataclasses import dataclass

from sdc_common.validation import check_positive
from sdc_package.pid import Pid, PidGains


@dataclass(frozen=True)
class SpeedControlLimits:
    """m/s^2, m/s^3 and m/s; below `standstill_mps` with a target of zero the car is held by the brake. `preview_s` and `preview_min_m`
    are how far ahead the planned acceleration is averaged, so that pedals move before a bend and not in it."""

    acceleration_mps2: float
    braking_mps2: float
    jerk_mps3: float
    standstill_mps: float
    hold_mps2: float
    preview_s: float
    preview_min_m: float

    def __post_init__(self):
        check_positive(**vars(self))


class SpeedControl:
    """PID on the speed error, with the planned acceleration as feed-forward, limited in acceleration and jerk."""

    def __init__(self, gains: PidGains, limits: SpeedControlLimits):
        self.limits = limits
        self.pid = Pid(gains, -limits.braking_mps2, limits.acceleration_mps2)
        self.reset()

    def reset(self) -> None:
        """Forget the past: as new."""
        self.pid.reset()
        self.acceleration_mps2 = 0.0

    def preview_m(self, speed_mps: float) -> float:
        """Length of the road ahead over which the planned acceleration counts at this speed."""
        return max(self.limits.preview_min_m, self.limits.preview_s * speed_mps)

    def acceleration(
        self, target_mps: float, planned_mps2: float, speed_mps: float, dt_s: float
    ) -> float:
        """The acceleration in m/s^2 to ask of the car for this step of `dt_s` seconds."""
        limits = self.limits
        if (
            target_mps < limits.standstill_mps
            and speed_mps < limits.standstill_mps
            and planned_mps2 <= 0.0
        ):
            self.reset()
            return -limits.hold_mps2
        change = limits.jerk_mps3 * dt_s
        lower = max(-limits.braking_mps2, self.acceleration_mps2 - change)
        upper = min(limits.acceleration_mps2, self.acceleration_mps2 + change)
        self.acceleration_mps2, _ = self.pid.update(
            target_mps, speed_mps, dt_s, planned_mps2, lower, upper
        )
        return self.acceleration_mps2
