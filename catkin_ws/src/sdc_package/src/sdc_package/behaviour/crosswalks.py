"""The crosswalks of a route, and who is about to walk over the lane there."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import cv2
import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.obstacle_prediction import Obstacles

# A pedestrian who is so near to a crosswalk now or after this time, and walks towards the lane,
# will use it [m], [s].
_NEAR_M = 2.0
_SOON_S = 1.0
# One who has left the strip of the car's lane by so much does not come back [m].
_STRIP_M = 2.2


class Crosswalk(NamedTuple):
    """A crosswalk on a route."""

    begin_m: float  # arc lengths along the route at which it begins and ends [m]
    end_m: float
    polygon_m: np.ndarray  # (N, 2) corners, 32-bit floats [m]

    def user(self, route: Route, obstacles: Obstacles) -> DetectedObstacle | None:
        """Return a pedestrian on it, or just before it, who has yet to cross the lane."""
        middle_m, reach_m = 0.5 * (self.begin_m + self.end_m), self.end_m - self.begin_m
        for walker in obstacles:
            if walker.kind != "pedestrian":
                continue
            x, y, yaw = walker.x_m, walker.y_m, walker.yaw_rad
            soon_m = _SOON_S * walker.speed_mps
            places = (x, y), (x + soon_m * math.cos(yaw), y + soon_m * math.sin(yaw))
            inside_m, later_m = (cv2.pointPolygonTest(self.polygon_m, at, True) for at in places)
            lane = route.line.project(x, y, middle_m, reach_m, reach_m)
            left_mps = walker.speed_mps * math.sin(yaw - lane.heading_rad)
            comes = lane.cross_track_m * left_mps < 0.0 and max(inside_m, later_m) > -_NEAR_M
            if comes or (lane.distance_m < _STRIP_M and inside_m > 0.0):
                return walker
        return None


def crosswalks_on(route: Route, polygons_m: Sequence[np.ndarray]) -> list[Crosswalk]:
    """Return the crosswalks that a route leads over, in order."""
    found = []
    for polygon in polygons_m:
        corners = np.asarray(polygon, np.float32)
        away_m = np.hypot(*(route.points - corners.mean(axis=0)).T)
        near = np.flatnonzero(away_m < np.ptp(corners, axis=0).max())
        points = [(n, route.points[n].tolist()) for n in near]
        on = [n for n, point in points if cv2.pointPolygonTest(corners, point, True) >= 0.0]
        # A route may pass it more than once.
        for run in np.split(on, np.flatnonzero(np.diff(on) > 1) + 1) if on else ():
            found.append(Crosswalk(float(route.s[run[0]]), float(route.s[run[-1]]), corners))
    return sorted(found, key=lambda crosswalk: crosswalk.begin_m)
