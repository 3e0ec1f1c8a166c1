"""Whether the car holds up an emergency vehicle."""

from __future__ import annotations

import math
from typing import Any, Iterable

YIELD_EMERGENCY, EMERGENCY_LASTS_S = "yield_emergency_vehicle", 6.0
_KIND = "ambulance"
# It is held up where the car is so near ahead of it, and leaves it no way to pass [m].
_BEHIND_M, _FREE_M = 30.0, 0.3


def holds_up(car: Any, others: Iterable[Any]) -> bool:
    """Return whether the car is on the way of an emergency vehicle close behind it.

    Args:
        car: the car, a RoadUser
        others: the other road users
    """
    for one in others:
        if one.kind == _KIND:
            body, mine = one.body, car.body
            x, y = mine.x_m - body.x_m, mine.y_m - body.y_m
            c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
            ahead_m, beside_m = c * x + s * y, abs(c * y - s * x)
            width_m = 0.5 * (mine.width_m + body.width_m) + _FREE_M
            if 0.0 < ahead_m < _BEHIND_M and beside_m < width_m:
                return True
    return False
