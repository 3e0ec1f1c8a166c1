"""Whether the car holds up an emergency vehicle."""

from __future__ import annotations

import math
from typing import Any, Iterable

YIELD_EMERGENCY, EMERGENCY_LASTS_S = "yield_emergency_vehicle", 6.0
_KIND = "ambulance"
# It is held up where the car is so near ahead of it, and leaves it no way to pass [m].
_BEHIND_M, _FREE_M = 30.0, 0.3


def holds_up(car: Any, others: Iterable[Any]) -> bool:
    """Return whether the car is on the way of an ambulance close behind; they are RoadUsers."""
    for body in (one.body for one in others if one.kind == _KIND):
        x, y = car.body.x_m - body.x_m, car.body.y_m - body.y_m
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        width_m = 0.5 * (car.body.width_m + body.width_m) + _FREE_M
        if 0.0 < c * x + s * y < _BEHIND_M and abs(c * y - s * x) < width_m:
            return True
    return False
