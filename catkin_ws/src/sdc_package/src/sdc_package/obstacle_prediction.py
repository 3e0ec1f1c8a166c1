"""Where obstacles are on the path of the car, now and in the next two seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_common.validation import check_non_negative

# Times ahead at which a moving obstacle is predicted, so that the car brakes before a pedestrian
# steps onto the lane [s].
PREDICTION_TIMES_S = (0.0, 0.5, 1.0, 1.5, 2.0)
# An obstacle that moves along the route more slowly than this is treated as standing [m/s].
_MIN_FOLLOW_SPEED_MPS = 0.5

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


def blocked_from(
    route: Route,
    from_s_m: float,
    obstacle: DetectedObstacle,
    time_s: float,
    margins: ObstacleMargins,
    horizon_m: float,
) -> tuple[float, float] | None:
    """Return the stretch of the route that an obstacle blocks, None if it is beside the path.

    Args:
        route: the car's route
        from_s_m: arc length of the car's centre [m]
        obstacle: the obstacle, which goes on with its speed and heading
        time_s: time ahead [s]
        margins: distances to keep
        horizon_m: length of the route ahead of the car that is searched [m]

    Returns:
        arc length of the obstacle's rear [m], and its speed along the route, 0 if it stands or
        comes towards the car [m/s]
    """
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
    half_along_m = 0.5 * (obstacle.length_m * cos + obstacle.width_m * sin)
    half_across_m = 0.5 * (obstacle.length_m * sin + obstacle.width_m * cos)
    free_m = half_across_m + 0.5 * margins.car_width_m + margins.side_m
    if abs(place.cross_track_m) > free_m or place.s_m <= from_s_m:
        return None
    along_mps = obstacle.speed_mps * math.cos(relative_yaw)
    return place.s_m - half_along_m, along_mps if along_mps > _MIN_FOLLOW_SPEED_MPS else 0.0
