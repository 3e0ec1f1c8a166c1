"""Speed limits that obstacles on the lane impose: stop behind standing ones, follow moving ones."""

from __future__ import annotations

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.obstacle_prediction import (
    PREDICTION_TIMES_S,
    ObstacleMargins,
    Obstacles,
    blocked_from,
)

# Time in which a car that is too close to the obstacle that it follows falls back [s].
_FALL_BACK_S = 2.0


def speed_caps(
    route: Route,
    s_m: np.ndarray,
    from_s_m: float,
    obstacles: Obstacles,
    margins: ObstacleMargins,
    braking_mps2: float,
    horizon_m: float,
    time_gap_s: float = 0.0,
) -> np.ndarray:
    """Return (n,) greatest speeds behind all obstacles on the lane, inf where there is none [m/s].

    The car stops behind a standing obstacle, at the last point of the route before the gap. It
    follows an obstacle that moves along the route at that obstacle's speed.

    Args:
        route: the car's route
        s_m: (n,) arc lengths on the route at which to compute the speed [m]
        from_s_m: arc length of the car's centre [m]
        obstacles: the obstacles
        margins: distances to keep
        braking_mps2: deceleration with which the car stops [m/s^2]
        horizon_m: length of the route ahead of the car that is searched [m]
        time_gap_s: additional time to an obstacle that is followed [s]
    """
    caps = np.full(len(s_m), np.inf)
    for obstacle in obstacles:
        stop = _stop_behind(route, from_s_m, obstacle, margins, horizon_m, time_gap_s)
        if stop is not None:
            stop_s_m, along_mps = stop
            room_m = np.maximum(stop_s_m - s_m, 0.0)
            caps = np.minimum(caps, np.sqrt(along_mps**2 + 2.0 * braking_mps2 * room_m))
    return caps


def _stop_behind(
    route: Route,
    from_s_m: float,
    obstacle: DetectedObstacle,
    margins: ObstacleMargins,
    horizon_m: float,
    time_gap_s: float,
) -> tuple[float, float] | None:
    """Return where the car has the speed of an obstacle, and that speed; None: it does not matter.

    Returns:
        arc length of the car's centre [m], and speed [m/s]
    """
    for time_s in PREDICTION_TIMES_S if obstacle.speed_mps else PREDICTION_TIMES_S[:1]:
        blocked = blocked_from(route, from_s_m, obstacle, time_s, margins, horizon_m)
        if blocked is None:
            continue
        predicted_rear_s_m, along_mps = blocked
        rear_s_m = predicted_rear_s_m - along_mps * time_s
        ahead_m = rear_s_m + obstacle.length_m - from_s_m
        if ahead_m < (margins.car_front_m if along_mps else -margins.car_front_m):
            return None  # It follows this car, or has just been passed.
        stop_s_m = rear_s_m - margins.gap_m - margins.car_front_m
        if along_mps == 0.0:
            return route.last_point_s(stop_s_m), 0.0
        if time_gap_s:
            stop_s_m -= along_mps * time_gap_s
            falls_back_mps = along_mps + min(stop_s_m - from_s_m, 0.0) / _FALL_BACK_S
            along_mps = max(falls_back_mps, 0.0)
        return stop_s_m, along_mps
    return None
