"""Speed limits that obstacles on the lane impose: stop behind standing ones, follow moving ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_common.validation import check_non_negative

# A car that is late for a stop brakes so hard; the second is still comfortable by nuPlan's limits.
FIRM_MPS2, HARD_MPS2 = 3.0, 3.9
_LEAST_GAP_M = 1.0  # the gap that is left where the car stops late [m]
# Times ahead at which a moving obstacle is predicted, so that the car brakes before a pedestrian
# steps onto the lane [s].
_PREDICTION_TIMES_S, _STEP_S = (0.0, 0.5, 1.0, 1.5, 2.0), 0.5
# An obstacle that moves along the route more slowly than this is treated as standing.
_MIN_FOLLOW_SPEED_MPS = 0.5
# Time in which the car falls back to its time gap where it is closer [s], and how much slower it
# becomes for that at most [m/s].
_FALL_BACK_S, _SLOWER_MPS = 2.0, 2.5

Obstacles = Sequence[DetectedObstacle]


@dataclass(frozen=True)
class ObstacleMargins:
    """Distances that the car keeps from obstacles, and its own size."""

    side_m: float  # free strip next to the car [m]
    gap_m: float  # distance between the car's front and an obstacle at which it stops [m]
    car_front_m: float  # distance from the car's centre to its front [m]
    car_width_m: float  # width of the car [m]

    def __post_init__(self):
        check_non_negative(**vars(self))


def speed_caps(
    route: Route,
    s_m: np.ndarray,
    from_s_m: float,
    obstacles: Obstacles,
    margins: ObstacleMargins,
    braking_mps2: float,
    horizon_m: float,
    offset_at: Callable[[float], float] | None = None,
    time_gap_s: float = 0.0,
    speed_mps: float = 0.0,
    follow_gap_m: float | None = None,
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
        offset_at: how far the way of the car is from the route at an arc length, positive to the
            left; None: it is the route [m]
        time_gap_s: additional time to a car that is followed, in which this one begins to brake [s]
        speed_mps: speed of the car, which rather uses the gap than brakes harder than firmly [m/s]
        follow_gap_m: distance to a car that is followed, None: that to obstacles [m]
    """
    square, given = np.full(len(s_m), np.inf), (margins, horizon_m, offset_at)
    for obstacle in obstacles:
        for time_s in _PREDICTION_TIMES_S if obstacle.speed_mps else _PREDICTION_TIMES_S[:1]:
            blocked = _blocked_from(route, from_s_m, obstacle, time_s, *given)
            if blocked is None:
                continue
            rear_s_m, along_mps = blocked
            passes_m = speed_mps * (time_s - _STEP_S) - margins.car_front_m
            if time_s and along_mps == 0.0 and rear_s_m + obstacle.length_m < from_s_m + passes_m:
                continue  # The car has passed before, even if it came just after the last time.
            rear_s_m -= along_mps * time_s
            ahead_m = rear_s_m + obstacle.length_m - from_s_m
            if ahead_m < (margins.car_front_m if along_mps else -margins.car_front_m):
                break  # It follows this car, or has just been passed.
            stop_s_m = rear_s_m - margins.gap_m - margins.car_front_m
            if along_mps == 0.0:
                latest_s_m = rear_s_m - _LEAST_GAP_M - margins.car_front_m
                firm_s_m = from_s_m + speed_mps**2 / (2.0 * FIRM_MPS2)
                stop_s_m = route.last_point_s(max(stop_s_m, min(firm_s_m, latest_s_m)))
            elif time_gap_s:
                follow_m = margins.gap_m if follow_gap_m is None else follow_gap_m
                stop_s_m += margins.gap_m - follow_m - along_mps * time_gap_s
                falls_back_mps = along_mps + min(stop_s_m - from_s_m, 0.0) / _FALL_BACK_S
                along_mps = min(along_mps, max(falls_back_mps, speed_mps - _SLOWER_MPS, 0.0))
            room_m = np.maximum(stop_s_m - s_m, 0.0)
            np.minimum(square, along_mps**2 + 2.0 * braking_mps2 * room_m, out=square)
            break
    return np.sqrt(square)


def nearby(
    route: Route, from_s_m: float, obstacles: Obstacles, horizon_m: float
) -> list[DetectedObstacle]:
    """Return those that may be so near to a place within two seconds: in traffic, few."""
    at, last_s = route.line.point_at(from_s_m), _PREDICTION_TIMES_S[-1]
    reach = [(one, horizon_m + last_s * one.speed_mps + one.length_m) for one in obstacles]
    return [one for one, far_m in reach if math.dist((one.x_m, one.y_m), at) < far_m]


def _blocked_from(
    route: Route,
    from_s_m: float,
    obstacle: DetectedObstacle,
    time_s: float,
    margins: ObstacleMargins,
    horizon_m: float,
    offset_at: Callable[[float], float] | None,
) -> tuple[float, float] | None:
    """Return (arc length of an obstacle's rear, its speed along the route), None off the lane."""
    travel_m = obstacle.speed_mps * time_s
    x = obstacle.x_m + travel_m * math.cos(obstacle.yaw_rad)
    y = obstacle.y_m + travel_m * math.sin(obstacle.yaw_rad)
    place = route.line.project(x, y, from_s_m, 0.0, horizon_m)
    if place.s_m >= route.length_m:  # it may be on the lane after the end of the route
        (end_x, end_y), yaw = route.line.point_at(place.s_m), place.heading_rad
        left_m = (y - end_y) * math.cos(yaw) - (x - end_x) * math.sin(yaw)
        after_m = (x - end_x) * math.cos(yaw) + (y - end_y) * math.sin(yaw)
        place = place._replace(s_m=place.s_m + after_m, cross_track_m=left_m)
    relative_yaw = obstacle.yaw_rad - place.heading_rad
    cos, sin = abs(math.cos(relative_yaw)), abs(math.sin(relative_yaw))
    half_along = 0.5 * (obstacle.length_m * cos + obstacle.width_m * sin)
    half_across = 0.5 * (obstacle.length_m * sin + obstacle.width_m * cos)
    free_m = half_across + 0.5 * margins.car_width_m + margins.side_m
    offset_m = offset_at(place.s_m) if offset_at else 0.0
    if abs(place.cross_track_m - offset_m) > free_m or place.s_m <= from_s_m:
        return None
    along_mps = obstacle.speed_mps * math.cos(relative_yaw)
    return place.s_m - half_along, along_mps if along_mps > _MIN_FOLLOW_SPEED_MPS else 0.0
