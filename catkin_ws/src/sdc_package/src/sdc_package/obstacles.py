"""Speed limits that obstacles on the lane impose: stop behind standing ones, follow moving ones."""

from __future__ import annotations

from typing import Callable

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.braking import FIRM_MPS2, braking_for
from sdc_package.obstacle_prediction import (
    PREDICTION_TIMES_S,
    STEP_S,
    Distances,
    ObstacleMargins,
    Obstacles,
    blocked_from,
)

# Gap that is left where the car stops late [m].
_LEAST_GAP_M = 1.0
# Time in which a car that is too close to the obstacle that it follows falls back [s].
_FALL_BACK_S = 2.0
# The car becomes slower by at most this to fall back [m/s].
_SLOWER_MPS = 2.5


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

    Args: see `caps_behind`, and `Distances`
    """
    distances = Distances(margins, time_gap_s, margins.gap_m, braking_mps2, horizon_m)
    caps = [caps_behind(route, s_m, from_s_m, obstacle, distances) for obstacle in obstacles]
    return np.min([np.full(len(s_m), np.inf), *caps], axis=0)


def caps_behind(
    route: Route,
    s_m: np.ndarray,
    from_s_m: float,
    obstacle: DetectedObstacle,
    distances: Distances,
    speed_mps: float = 0.0,
    offset_at: Callable[[float], float] | None = None,
) -> np.ndarray:
    """Return (n,) greatest speeds behind an obstacle, inf where it does not matter [m/s].

    The car stops behind a standing obstacle, at the last point of the route before the gap. It
    follows an obstacle that moves along the route at that obstacle's speed.

    Args:
        route: the car's route
        s_m: (n,) arc lengths on the route at which to compute the speed [m]
        from_s_m: arc length of the car's centre [m]
        obstacle: the obstacle
        distances: distances to keep
        speed_mps: speed of the car, which uses the gap where it would have to brake harder than
            firmly; 0: it keeps the gap [m/s]
        offset_at: see `blocked_from`
    """
    margins = distances.margins
    for time_s in PREDICTION_TIMES_S if obstacle.speed_mps else PREDICTION_TIMES_S[:1]:
        blocked = blocked_from(
            route, from_s_m, obstacle, time_s, margins, distances.horizon_m, offset_at
        )
        if blocked is None:
            continue
        predicted_rear_s_m, along_mps = blocked
        passes_m = speed_mps * (time_s - STEP_S) - margins.car_front_m
        end_s_m = predicted_rear_s_m + obstacle.length_m
        if time_s and along_mps == 0.0 and end_s_m < from_s_m + passes_m:
            continue  # The car has passed before, even if it came just after the last time.
        rear_s_m = predicted_rear_s_m - along_mps * time_s
        ahead_m = rear_s_m + obstacle.length_m - from_s_m
        if ahead_m < (margins.car_front_m if along_mps else -margins.car_front_m):
            break  # It follows this car, or has just been passed.
        stop_s_m = rear_s_m - margins.gap_m - margins.car_front_m
        if along_mps == 0.0:
            latest_s_m = rear_s_m - _LEAST_GAP_M - margins.car_front_m
            firm_s_m = from_s_m + speed_mps**2 / (2.0 * FIRM_MPS2)
            stop_s_m = route.last_point_s(max(stop_s_m, min(firm_s_m, latest_s_m)))
        elif distances.time_gap_s:
            stop_s_m += margins.gap_m - distances.follow_gap_m - along_mps * distances.time_gap_s
            falls_back_mps = along_mps + min(stop_s_m - from_s_m, 0.0) / _FALL_BACK_S
            along_mps = min(along_mps, max(falls_back_mps, speed_mps - _SLOWER_MPS, 0.0))
        room_m = np.maximum(stop_s_m - s_m, 0.0)
        braking = distances.braking_mps2, speed_mps, stop_s_m - from_s_m, along_mps
        return np.sqrt(along_mps**2 + 2.0 * braking_for(*braking) * room_m)
    return np.full(len(s_m), np.inf)
