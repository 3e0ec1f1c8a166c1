"""Stop and follow on the lane: obstacles and traffic lights limit the speeds of its path."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import StopLine
from sdc_common.validation import check_finite, check_non_negative, check_positive
from sdc_package.obstacles import ObstacleMargins, speed_caps
from sdc_package.traffic_lights import TrafficLightMargins, TrafficLightMonitor
from sdc_perception.ground_tracks import Pose
from sdc_perception.light_tracker import TrackedLight

# The lane continues straight where it is not seen.
_BEYOND_M = 50.0


@dataclass(frozen=True)
class PolePlace:
    """Where the pole of a traffic light is."""

    beyond_line_m: float  # distance beyond the stop line [m]
    right_m: float  # distance to the right of the lane's centre [m]
    tolerance_m: float  # greatest deviation from it of a light for this lane [m]
    half_width_m: float  # half of the width of the stop line [m]

    def __post_init__(self):
        check_finite(beyond_line_m=self.beyond_line_m, right_m=self.right_m)
        check_positive(tolerance_m=self.tolerance_m, half_width_m=self.half_width_m)


@dataclass(frozen=True)
class TrafficSettings:
    """Parameters of stopping and following."""

    braking_mps2: float  # maximum deceleration [m/s^2]
    horizon_m: float  # length of the lane ahead that is searched [m]
    spare_m: float  # distance by which the car stops earlier, because distances have an error [m]
    obstacles: ObstacleMargins  # margins to obstacles, with the spare distance
    lights: TrafficLightMargins  # margins at traffic lights
    pole: PolePlace  # where the pole of a traffic light is

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> TrafficSettings:
        """Return the settings of the node, see DetectorSettings.read."""
        horizon_m, spare_m = parameter("horizon_m"), parameter("spare_m")
        check_positive(horizon_m=horizon_m)
        check_non_negative(spare_m=spare_m)
        margins = ObstacleMargins(**parameter("caution"))
        return cls(
            parameter("braking_mps2"),
            horizon_m,
            spare_m,
            replace(margins, gap_m=margins.gap_m + spare_m),
            TrafficLightMargins(**parameter("traffic_lights")),
            PolePlace(**parameter("pole")),
        )


class TrafficFollower:
    """Reduces the speeds of a path to what obstacles and traffic lights allow."""

    def __init__(self, settings: TrafficSettings):
        self._settings = settings
        self._monitor = TrafficLightMonitor(settings.lights)

    def limited(
        self,
        rows: np.ndarray,
        pose: Pose,
        speed_mps: float,
        bodies: Sequence[DetectedObstacle],
        lights: Sequence[TrackedLight],
    ) -> np.ndarray:
        """Return the path with the speeds that traffic allows.

        Its rows (N, 3) are x [m], y [m] and speed [m/s], from behind the car.
        """
        if len(rows) < 2 or not (bodies or lights):
            return rows
        settings = self._settings
        end, before = rows[-1, :2], rows[-2, :2]
        ahead = end + _BEYOND_M * (end - before) / math.dist(end, before)
        route = Route(np.vstack([rows[:, :2], ahead]))
        s_m = route.s[:-1]
        from_s_m = route.line.project(pose[0], pose[1], 0.0, 0.0, float(s_m[-1])).s_m
        caps = speed_caps(
            route,
            s_m,
            from_s_m,
            bodies,
            settings.obstacles,
            settings.braking_mps2,
            settings.horizon_m,
        )
        self._set_lights(route, from_s_m, lights)
        stop_s = self._monitor.stop_s(
            route, from_s_m, speed_mps, settings.braking_mps2, settings.horizon_m
        )
        if stop_s is not None:
            room_m = np.maximum(route.last_point_s(stop_s) - s_m, 0.0)
            caps = np.minimum(caps, np.sqrt(2.0 * settings.braking_mps2 * room_m))
        return np.column_stack([rows[:, :2], np.minimum(rows[:, 2], caps)])

    def _set_lights(self, route: Route, from_s_m: float, lights: Sequence[TrackedLight]) -> None:
        """Give the monitor the stop lines of the lights that are next to the lane."""
        pole, monitor = self._settings.pole, self._monitor
        monitor.lines, monitor.states = {}, {}
        for light in lights:
            place = route.line.project(light.x_m, light.y_m, 0.0, 0.0, route.length_m)
            line_s_m = place.s_m - pole.beyond_line_m - self._settings.spare_m
            if abs(place.cross_track_m + pole.right_m) > pole.tolerance_m or line_s_m < from_s_m:
                continue
            x, y = route.line.point_at(line_s_m)
            monitor.lines[light.id] = StopLine(x, y, pole.half_width_m)
            monitor.states[light.id] = light.state
