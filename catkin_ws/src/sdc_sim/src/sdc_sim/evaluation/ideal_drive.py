"""The fastest drive along a route under the local planner's limits."""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, ideal_duration, speed_profile

_MIN_SPEED_MPS = 1e-3


class IdealDrive:
    """The greatest speed (N,) [m/s] at each point of a route, and the time that it takes."""

    def __init__(self, route: Route, limits: SpeedLimits):
        self.speed_mps = speed_profile(route, limits)
        self.duration_s = ideal_duration(route, self.speed_mps)
        mean_mps = 0.5 * (self.speed_mps[:-1] + self.speed_mps[1:])
        steps_s = np.diff(route.s) / np.maximum(mean_mps, _MIN_SPEED_MPS)
        self._s_m = route.s
        self._time_s = np.append(0.0, np.cumsum(steps_s))

    def time_at(self, s_m: float) -> float:
        """Return the time [s] from the start to an arc length [m]."""
        return float(np.interp(s_m, self._s_m, self._time_s))
