"""How the car brakes: how hard, how suddenly, and how it stays at rest after a stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from sdc_common.validation import check_positive

# Deceleration of a car that is late for a stop [m/s^2].
FIRM_MPS2 = 3.0
# Hardest deceleration that is comfortable by nuPlan's limits [m/s^2].
HARD_MPS2 = 3.9


def braking_for(usual_mps2: float, speed_mps: float, room_m: float, to_mps: float = 0.0) -> float:
    """Return the deceleration of a car that may be late: as hard as needed, up to HARD_MPS2.

    Args:
        usual_mps2: deceleration of a car that is not late [m/s^2]
        speed_mps: speed of the car [m/s]
        room_m: distance to the place at which it has another speed [m]
        to_mps: speed there [m/s]
    """
    needed_mps2 = (speed_mps**2 - to_mps**2) / max(2.0 * room_m, 0.1)
    return max(usual_mps2, min(needed_mps2, HARD_MPS2))


# A car that has accelerated by less than this is coasting [m/s^2].
COASTING_MPS2 = 0.4
# A car that stands closer than this to its stop stays: it would start too hard and pass it [m].
_STOP_WITHIN_M = 0.12
# Time that a car stays at rest after a stop [s].
_STAYS_S = 0.6

# A car that exceeds the planned speed by more than this has just detected something [m/s].
_NEW_MPS = 1.5
# The same for a plan that brakes harder than this [m/s^2].
_USUAL_MPS2 = 3.05
# A car that exceeds the planned speed by more than this brakes as hard as it can [m/s].
_LATE_MPS = 3.3
# Comfortable jerk is an average over 1.5 s: the acceleration falls by at most so much below its
# last peak, which counts less with time [m/s^2, m/s^3].
_FALLS_MPS2 = 3.8
_PEAK_FALLS_MPS3 = 0.5


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
    # The same change while the car brakes for what it has just detected [m/s^3]
    emergency_jerk_mps3: float

    def __post_init__(self):
        check_positive(**vars(self))


class SpeedStep(NamedTuple):
    """What a time step of the speed control starts with."""

    target_mps: float  # planned speed [m/s]
    planned_mps2: float  # planned acceleration [m/s^2]
    speed_mps: float  # measured speed [m/s]
    last_mps2: float  # acceleration of the last time step [m/s^2]
    dt_s: float  # length of the time step [s]


class StandstillHold:
    """Decides when the brake holds the car at rest."""

    def __init__(self, limits: SpeedControlLimits):
        self._limits = limits
        self._remaining_s = 0.0

    def holds(self, step: SpeedStep) -> bool:
        """Return whether the car stays at rest in this time step."""
        limits, (target_mps, planned_mps2, speed_mps, last_mps2, dt_s) = self._limits, step
        is_at_stop = target_mps * target_mps < -2.0 * planned_mps2 * _STOP_WITHIN_M
        would_pass_stop = planned_mps2 < -limits.braking_mps2
        stays = target_mps < limits.standstill_mps or would_pass_stop
        stays |= is_at_stop and last_mps2 >= 0.0
        stands = speed_mps < limits.standstill_mps and stays and planned_mps2 <= 0.0
        if stands and last_mps2 < -COASTING_MPS2:
            self._remaining_s = _STAYS_S
        if not stands and self._remaining_s <= 0.0:
            return False
        self._remaining_s -= dt_s
        return True


class ComfortRange:
    """Limits the next acceleration, so that only what the situation needs is felt."""

    def __init__(self, limits: SpeedControlLimits):
        self._limits = limits
        self._peak_mps2 = 0.0

    def next_range(self, step: SpeedStep) -> tuple[float, float]:
        """Return the lowest and the greatest next acceleration [m/s^2]."""
        limits, (target_mps, planned_mps2, speed_mps, last_mps2, dt_s) = self._limits, step
        faster_mps = speed_mps - target_mps
        self._peak_mps2 = max(last_mps2, self._peak_mps2 - _PEAK_FALLS_MPS3 * dt_s)
        is_new = faster_mps > _NEW_MPS or planned_mps2 < -_USUAL_MPS2
        falls_mps2 = HARD_MPS2 if target_mps == 0.0 else _FALLS_MPS2 - self._peak_mps2
        hardest_mps2 = max(min(HARD_MPS2, falls_mps2), -last_mps2)
        if faster_mps > _LATE_MPS:
            hardest_mps2 = limits.braking_mps2
        jerk_mps3 = limits.emergency_jerk_mps3 if is_new else limits.jerk_mps3
        lowest_mps2 = max(last_mps2 - jerk_mps3 * dt_s, -min(hardest_mps2, limits.braking_mps2))
        greatest_mps2 = min(limits.acceleration_mps2, last_mps2 + limits.jerk_mps3 * dt_s)
        return lowest_mps2, greatest_mps2
