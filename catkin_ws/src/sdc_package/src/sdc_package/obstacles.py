"""Obstacles on the lane: where the car must stop for them, or how slowly it must follow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.validation import check_non_negative

# Instants ahead at which a moving obstacle is looked for: who steps onto the lane is seen before he is there.
_PREDICTED_S = (0.0, 0.5, 1.0, 1.5, 2.0)


@dataclass(frozen=True)
class DetectedObstacle:
    """A box on the ground: centre and heading in the map frame, metres and radians, length along the heading, speed along it in m/s."""

    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    speed_mps: float

    def __post_init__(self):
        if not all(map(math.isfinite, vars(self).values())):
            raise ValueError(f"a number of an obstacle is not finite: {self}")


@dataclass(frozen=True)
class ObstacleMargins:
    """How an obstacle is kept away from, metres: the free strip beside the car, the gap in front of it, and the car's own size."""

    side_m: float
    gap_m: float
    car_front_m: float
    car_width_m: float

    def __post_init__(self):
        check_non_negative(**vars(self))


def speed_caps(
    route: Route,
    s: np.ndarray,
    from_s_m: float,
    obstacles,
    caution: ObstacleMargins,
    braking_mps2: float,
    horizon_m: float,
) -> np.ndarray:
    """The greatest speeds (n,) m/s at the arc lengths `s` (n,) with which the car's centre, now at `from_s_m`, stays `gap_m` behind
    everything on its lane within `horizon_m`.

    Behind what stands the car stops, at the last point of the route before that gap; behind what drives along the route it
    follows at that speed. The cost does not depend on the length of the route.
    """
    square = np.full(len(s), np.inf)
    for obstacle in obstacles:
        for ahead_s in _PREDICTED_S if obstacle.speed_mps else _PREDICTED_S[:1]:
            blocked = _blocked_from(route, from_s_m, obstacle, ahead_s, caution, horizon_m)
            if blocked is None:
                continue
            rear_s, along_mps = blocked
            stop_s = rear_s - along_mps * ahead_s - caution.gap_m - caution.car_front_m
            if along_mps == 0.0:
                stop_s = route.last_point_s(stop_s)
            np.minimum(
                square, along_mps**2 + 2.0 * braking_mps2 * np.maximum(stop_s - s, 0.0), out=square
            )
            if along_mps == 0.0:
                square[s >= stop_s] = 0.0
            break
    return np.sqrt(square)


def _blocked_from(
    route: Route,
    from_s_m: float,
    obstacle: DetectedObstacle,
    ahead_s: float,
    caution: ObstacleMargins,
    horizon_m: float,
):
    """(arc length of the obstacle's near end, its speed along the route) when it will be on the lane then, else None."""
    x = obstacle.x_m + obstacle.speed_mps * ahead_s * math.cos(obstacle.yaw_rad)
    y = obstacle.y_m + obstacle.speed_mps * ahead_s * math.sin(obstacle.yaw_rad)
    place = route.project(x, y, from_s_m, 0.0, horizon_m)
    turned = obstacle.yaw_rad - place.heading_rad
    c, s = abs(math.cos(turned)), abs(math.sin(turned))
    half_along = 0.5 * (obstacle.length_m * c + obstacle.width_m * s)
    half_across = 0.5 * (obstacle.length_m * s + obstacle.width_m * c)
    if (
        place.distance_m > half_across + 0.5 * caution.car_width_m + caution.side_m
        or place.s_m <= from_s_m
    ):
        return None
    along = max(0.0, obstacle.speed_mps * math.cos(turned))
    return place.s_m - half_along, along if along > 0.5 else 0.0
