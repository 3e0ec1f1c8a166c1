"""The fastest drive along a route under the limits of the local planner and of the roads."""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, limited_speeds

_MIN_SPEED_MPS = 1e-3
_MAX_SHORTCUT = 0.9


class IdealDrive:
    """The greatest speed (N,) [m/s] at each point of a route, and the time that it takes."""

    def __init__(self, route: Route, limits: SpeedLimits, road_mps: np.ndarray | float = np.inf):
        self.speed_mps, _ = limited_speeds(route.s, route.curvature, limits, road_mps)
        mean_mps = 0.5 * (self.speed_mps[:-1] + self.speed_mps[1:])
        steps_s = np.diff(route.s) / np.maximum(mean_mps, _MIN_SPEED_MPS)
        self.duration_s = float(np.sum(steps_s))
        self._route = route
        self._time_s = np.append(0.0, np.cumsum(steps_s))

    def time_at(self, s_m: float) -> float:
        """Return the time [s] from the start to an arc length [m]."""
        return float(np.interp(s_m, self._route.s, self._time_s))

    def least_time_s(self, s_m: np.ndarray, cross_track_m: np.ndarray) -> float:
        """Return the least time of a drive that starts and ends, and cuts bends, as this one does.

        The way through a bend is shorter on its inside. A drive may also end before the last point.

        Args:
            s_m: (n,) arc length of each sample [m]
            cross_track_m: (n,) offset, positive left of the route [m]
        """
        if not len(s_m):
            return self.duration_s
        route = self._route
        reached_m = np.maximum.accumulate(s_m)
        time_s = np.interp(reached_m, route.s, self._time_s)
        shortcut = np.interp(reached_m, route.s, route.curvature) * cross_track_m
        saved_s = float(np.sum(np.diff(time_s) * np.clip(shortcut[1:], 0.0, _MAX_SHORTCUT)))
        rest_s = max(0.0, route.length_m - reached_m[-1]) / float(self.speed_mps.max())
        return max(self.duration_s - float(time_s[0]) - saved_s - rest_s, _MIN_SPEED_MPS)
