"""The speeds at which the car keeps its distance to road users on its path."""

from __future__ import annotations

import math
from typing import Callable, NamedTuple

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.braking import FIRM_MPS2
from sdc_package.obstacle_prediction import (
    PREDICTION_TIMES_S,
    ObstacleMargins,
    Obstacles,
    blocked_from,
)
from sdc_package.obstacles import FALL_BACK_S, LEAST_GAP_M

# A road user may be on the path up to so much earlier than the time at which it is predicted [s].
_STEP_S = 0.5
# The car becomes slower by at most this to fall back behind the one that it follows [m/s].
_SLOWER_MPS = 2.5


class Distances(NamedTuple):
    """Distances that the car keeps to road users."""

    obstacles: ObstacleMargins  # to those that stand
    time_gap_s: float  # additional time to the one that it follows [s]
    follow_gap_m: float  # distance to it at standstill [m]
    braking_mps2: float  # deceleration with which the car stops [m/s^2]
    horizon_m: float  # length of the route ahead of the car that is searched [m]


def nearby(
    route: Route, from_s_m: float, obstacles: Obstacles, horizon_m: float
) -> list[DetectedObstacle]:
    """Return those that may be so near to a place within two seconds: in traffic, few."""
    place, last_s = route.line.point_at(from_s_m), PREDICTION_TIMES_S[-1]
    return [
        obstacle
        for obstacle in obstacles
        if math.dist((obstacle.x_m, obstacle.y_m), place)
        < horizon_m + last_s * obstacle.speed_mps + obstacle.length_m
    ]


def following_caps(
    route: Route,
    s_m: np.ndarray,
    from_s_m: float,
    speed_mps: float,
    obstacle: DetectedObstacle,
    offset_at: Callable[[float], float],
    distances: Distances,
) -> np.ndarray:
    """Return (n,) greatest speeds behind a road user, inf where it does not matter [m/s].

    Args:
        route: the car's route
        s_m: (n,) arc lengths on the route at which to compute the speed [m]
        from_s_m: arc length of the car's centre [m]
        speed_mps: speed of the car, which uses the gap where it would have to brake harder than
            firmly [m/s]
        obstacle: the road user
        offset_at: returns how far the path of the car is from the route at an arc length, positive
            to the left [m]
        distances: distances to keep
    """
    margins = distances.obstacles
    for time_s in PREDICTION_TIMES_S if obstacle.speed_mps else PREDICTION_TIMES_S[:1]:
        blocked = blocked_from(
            route, from_s_m, obstacle, time_s, margins, distances.horizon_m, offset_at
        )
        if blocked is None:
            continue
        predicted_rear_s_m, along_mps = blocked
        passes_m = speed_mps * (time_s - _STEP_S) - margins.car_front_m
        end_s_m = predicted_rear_s_m + obstacle.length_m
        if time_s and along_mps == 0.0 and end_s_m < from_s_m + passes_m:
            continue  # The car has passed before, even if it came just after the last time.
        rear_s_m = predicted_rear_s_m - along_mps * time_s
        ahead_m = rear_s_m + obstacle.length_m - from_s_m
        if ahead_m < (margins.car_front_m if along_mps else -margins.car_front_m):
            break  # It follows this car, or has just been passed.
        stop_s_m = rear_s_m - margins.gap_m - margins.car_front_m
        if along_mps == 0.0:
            latest_s_m = rear_s_m - LEAST_GAP_M - margins.car_front_m
            firm_s_m = from_s_m + speed_mps**2 / (2.0 * FIRM_MPS2)
            stop_s_m = route.last_point_s(max(stop_s_m, min(firm_s_m, latest_s_m)))
        else:
            stop_s_m += margins.gap_m - distances.follow_gap_m - along_mps * distances.time_gap_s
            falls_back_mps = along_mps + min(stop_s_m - from_s_m, 0.0) / FALL_BACK_S
            along_mps = min(along_mps, max(falls_back_mps, speed_mps - _SLOWER_MPS, 0.0))
        room_m = np.maximum(stop_s_m - s_m, 0.0)
        return np.sqrt(along_mps**2 + 2.0 * distances.braking_mps2 * room_m)
    return np.full(len(s_m), np.inf)
