"""When may I enter the junction? Gap acceptance."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

NEVER = (math.inf, math.inf)


def time_in_space(
    points_m: np.ndarray, times_s: np.ndarray, space_m: np.ndarray, radius_m: float
) -> tuple[float, float]:
    """Return from when until when a road user is in a space that the car needs, too.

    Args:
        points_m: (T, 2) predicted places of its centre [m]
        times_s: (T,) times of these places from now, ascending [s]
        space_m: (2,) centre of the space [m]
        radius_m: it is in the space while its centre is nearer than this [m]

    Returns:
        the first and the last of the times in the space; NEVER if it is not there at any of them
    """
    # TODO 4: the first and the last time in the space (until then: return NEVER)
    inside = np.hypot(*(points_m - space_m).T) < radius_m
    if not inside.any():
        return NEVER
    times = times_s[inside]
    return float(times[0]), float(times[-1])
    # ----------------------------------------------------------------------------


def may_enter(
    own_s: tuple[float, float], others_s: Sequence[tuple[float, float]], margin_s: float
) -> bool:
    """Return whether the car may enter the junction.

    Args:
        own_s: from when until when the car would be in the space [s]
        others_s: the same for each road user with right of way [s]
        margin_s: least time between the car and each of them, before and after it [s]
    """
    # TODO 5: no one with right of way is there in that time (until then: return False)
    enters_s, leaves_s = own_s
    return all(
        leaves_s + margin_s <= first_s or last_s + margin_s <= enters_s
        for first_s, last_s in others_s
    )
    # ----------------------------------------------------------------------------
