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
        middle_m = 0.5 * (self.begin_m + self.end_m)
        x, y = route.line.point_at(middle_m)
        heading = route.line.heading_at(middle_m)
        for walker in obstacles:
            if walker.kind != "pedestrian":
                continue
            c, s = math.cos(walker.yaw_rad), math.sin(walker.yaw_rad)
            walks_m = (0.0, _SOON_S * walker.speed_mps)
            places = [(walker.x_m + c * m, walker.y_m + s * m) for m in walks_m]
            inside_m, soon_m = (cv2.pointPolygonTest(self.polygon_m, at, True) for at in places)
            left_m = (walker.y_m - y) * math.cos(heading) - (walker.x_m - x) * math.sin(heading)
            left_mps = walker.speed_mps * math.sin(walker.yaw_rad - heading)
            is_in_strip = abs(left_m) < _STRIP_M
            comes = left_m * left_mps < 0.0 and max(inside_m, soon_m) > -_NEAR_M
            if comes or (is_in_strip and inside_m > 0.0):
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
