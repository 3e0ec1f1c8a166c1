"""How close is one road user behind another? Two times that answer it."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class OnLane:
    """A road user on a lane."""

    s_m: float  # place of its centre along the road [m]
    speed_mps: float  # speed [m/s]
    length_m: float = 4.7  # length [m]
    lane: int = 0  # number of its lane, from the right


def time_gap_s(rear: OnLane, front: OnLane) -> float:
    """Return the time in which the rear one is where the front one's rear bumper is now [s].

    Returns:
        the time from bumper to bumper; infinite when the rear one is at rest
    """
    gap_m = front.s_m - rear.s_m
    # TODO 2: from bumper to bumper, and as a time (until then: return gap_m)
    gap_m -= 0.5 * (front.length_m + rear.length_m)
    return gap_m / rear.speed_mps if rear.speed_mps > 0.0 else math.inf
    # ----------------------------------------------------------------------------


def time_to_collision_s(rear: OnLane, front: OnLane) -> float:
    """Return the time until they touch if both keep their speed [s]; infinite if they never do."""
    gap_m = front.s_m - rear.s_m - 0.5 * (front.length_m + rear.length_m)
    # TODO 3: gap_m divided by the speed with which it shrinks (until then: return gap_m)
    closing_mps = rear.speed_mps - front.speed_mps
    return gap_m / closing_mps if closing_mps > 0.0 else math.inf
    # ----------------------------------------------------------------------------
