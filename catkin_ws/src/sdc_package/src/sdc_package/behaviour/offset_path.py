"""The way of the car beside its route."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import maximum_filter1d

from sdc_common.geometry.route import Route, smooth_step
from sdc_package.street_settings import StreetSettings

# Distances from the route that differ by less are the same [m].
SAME_M = 0.15
# A line so near to the route is back on it [m].
_ON_ROUTE_M = 0.01
# Peak of the second derivative of the smooth step.
_PEAK = 5.7735
# A line that bends less is straight [1/m].
_STRAIGHT = 1e-3


class OffsetPath:
    """A line beside a route.

    Args:
        route: the route
        top_mps: greatest speed on it [m/s]
        settings: how the car shifts

    Attributes:
        offset_m: (N,) distance from the route at its points, positive to the left [m]
        until_m: arc length at which it is back on the route, 0 if it is the route [m]
    """

    def __init__(self, route: Route, top_mps: float, settings: StreetSettings):
        self._route, self._top_mps, self._shifts = route, top_mps, settings.proposals
        self.offset_m, self.until_m = np.zeros(len(route.s)), 0.0

    def offset_at(self, s_m: float) -> float:
        """Return the distance from the route at an arc length, positive to the left [m]."""
        return float(np.interp(s_m, self._route.s, self.offset_m)) if self.until_m else 0.0

    def follow(self, offset_m: np.ndarray, s_m: float) -> None:
        """Take another line from an arc length on."""
        self.offset_m = offset_m
        beside = np.flatnonzero((np.abs(offset_m) > _ON_ROUTE_M) & (self._route.s > s_m))
        self.until_m = float(self._route.s[beside[-1]]) + 1.0 if len(beside) else 0.0

    def pass_by(self, s_m: float) -> None:
        """Forget what is behind an arc length."""
        if self.until_m and s_m > self.until_m:
            self.offset_m, self.until_m = np.zeros_like(self.offset_m), 0.0

    def moved(self, rows: np.ndarray, ahead: slice) -> np.ndarray:
        """Return the rows x, y, v of the route at these points, moved to this line."""
        offset, heading = self.offset_m[ahead], self._route.heading[ahead]
        if not (self.until_m and offset.any()):
            return rows
        x, y = rows[:, 0] - offset * np.sin(heading), rows[:, 1] + offset * np.cos(heading)
        most = self.bend_mps(offset, self._route.s[ahead])
        return np.column_stack([x, y, np.minimum(rows[:, 2], most)])

    def shifted(self, to_m: float, begin_m: float, speed_mps: float, room_m: float) -> np.ndarray:
        """Return the line that goes over to a distance from the route.

        Args:
            to_m: the distance, positive to the left [m]
            begin_m: arc length at which it begins [m]
            speed_mps: speed of the car [m/s]
            room_m: distance within which it would be over, if the speed allows [m]
        """
        s, now_m = self._route.s, self.offset_at(begin_m)
        least_m, most_m = (self.shift_length_m(to_m - now_m, v) for v in (speed_mps, self._top_mps))
        step = smooth_step(s, begin_m, max(least_m, min(room_m, most_m)))
        before = np.where(s < begin_m, self.offset_m, now_m)
        return before * (1.0 - step) + to_m * step

    def out_to(
        self, to_m: float, s_m: float, begin_m: float, speed_mps: float, room_m: float
    ) -> np.ndarray:
        """Return the line that stays at a distance; one that goes there already is not changed."""
        s = self._route.s
        ahead = s > s_m
        if self.until_m and to_m and ahead.any():
            towards_m = self.offset_m * math.copysign(1.0, to_m)
            peak = int(np.argmax(np.where(ahead, towards_m, -math.inf)))
            peak_m = float(self.offset_m[peak])
            if abs(to_m - peak_m) < SAME_M or abs(peak_m) > abs(to_m):
                return np.where(s < s[peak], self.offset_m, peak_m)
        return self.shifted(to_m, begin_m, speed_mps, room_m)

    def shift_length_m(self, shift_m: float, speed_mps: float) -> float:
        """Return the distance over which the car shifts across the road [m]."""
        least_m, most_mps2 = self._shifts.shift_m, self._shifts.shift_mps2
        return max(least_m, speed_mps * math.sqrt(_PEAK * abs(shift_m) / most_mps2))

    def bend_mps(self, offset_m: np.ndarray, s_m: np.ndarray) -> np.ndarray:
        """Return the speeds (N,) with which the car follows the bends of a line beside the route.

        Args:
            offset_m: (N,) distance of the line from the route [m]
            s_m: (N,) arc lengths, 1 m apart [m]
        """
        bend = np.abs(np.gradient(np.gradient(offset_m, s_m), s_m))
        bend = maximum_filter1d(bend, int(self._shifts.shift_m))
        square = 2.0 * self._shifts.shift_mps2 / np.maximum(bend, _STRAIGHT)
        # It brakes in time.
        before = 2.0 * self._shifts.shift_mps2 * s_m
        return np.sqrt(np.minimum.accumulate((square + before)[::-1])[::-1] - before)
