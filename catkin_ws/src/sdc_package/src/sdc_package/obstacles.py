"""Speed limits that obstacles on the lane impose: stop behind standing ones, follow moving ones."""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.route import Route
from sdc_package.obstacle_prediction import (
    PREDICTION_TIMES_S,
    ObstacleMargins,
    Obstacles,
    blocked_from,
)

# Gap that is left where the car stops late [m].
LEAST_GAP_M = 1.0
# Time in which a car that is too close to the obstacle that it follows falls back [s].
FALL_BACK_S = 2.0
# Additional time to an obstacle that is followed [s].
_TIME_GAP_S = 1.0


def speed_caps(
    route: Route,
    s_m: np.ndarray,
    from_s_m: float,
    obstacles: Obstacles,
    margins: ObstacleMargins,
    braking_mps2: float,
    horizon_m: float,
) -> np.ndarray:
    """Return (n,) greatest speeds behind all obstacles on the lane, inf where there is none [m/s].

    The car stops behind a standing obstacle, at the last point of the route before the gap. It
    follows an obstacle that moves along the route at that obstacle's speed.

    Args:
        route: the car's route
        s_m: (n,) arc lengths on the route at which to compute the speed [m]
        from_s_m: arc length of the car's centre [m]
        obstacles: the detected obstacles
        margins: distances to keep
        braking_mps2: deceleration with which the car stops [m/s^2]
        horizon_m: length of the route ahead of the car that is searched for obstacles [m]
    """
    square = np.full(len(s_m), np.inf)
    for obstacle in obstacles:
        for time_s in PREDICTION_TIMES_S if obstacle.speed_mps else PREDICTION_TIMES_S[:1]:
            blocked = blocked_from(route, from_s_m, obstacle, time_s, margins, horizon_m)
            if blocked is None:
                continue
            predicted_rear_s_m, along_mps = blocked
            rear_s_m = predicted_rear_s_m - along_mps * time_s
            ahead_m = rear_s_m + obstacle.length_m - from_s_m
            if ahead_m < (margins.car_front_m if along_mps else -margins.car_front_m):
                break  # It follows this car, or has just been passed.
            stop_s_m = rear_s_m - margins.gap_m - margins.car_front_m
            if along_mps:
                stop_s_m -= along_mps * _TIME_GAP_S
                too_close_m = min(stop_s_m - from_s_m, 0.0)
                along_mps = max(min(along_mps, along_mps + too_close_m / FALL_BACK_S), 0.0)
            else:
                latest_s_m = rear_s_m - LEAST_GAP_M - margins.car_front_m
                stop_s_m = route.last_point_s(max(stop_s_m, min(from_s_m, latest_s_m)))
            room_m = np.maximum(stop_s_m - s_m, 0.0)
            np.minimum(square, along_mps**2 + 2.0 * braking_mps2 * room_m, out=square)
            break
    return np.sqrt(square)
