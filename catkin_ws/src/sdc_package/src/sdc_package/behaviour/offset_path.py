"""The way of the car beside its route."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import BPoly
from scipy.ndimage import maximum_filter1d

from sdc_common.geometry.route import Route
from sdc_package.street_settings import StreetSettings

# Distances from the route that differ by less are the same [m].
SAME_M = 0.15
# A line so near to the route is back on it [m].
_ON_ROUTE_M = 0.01
# Peak of the second derivative of a shift by 1 over a length of 1.
_PEAK = 5.7735
# A line that bends less is straight [1/m].
_STRAIGHT = 1e-3
# Place, slope and bend of a line are read so far before and after a place [m].
_STEP_M = 2.0


def state_at(s_m: np.ndarray, line_m: np.ndarray, at_m: float) -> tuple[float, float, float]:
    """Return place [m], slope and second derivative [1/m] of a line (N,) at an arc length."""
    before_m, now_m, after_m = np.interp([at_m - _STEP_M, at_m, at_m + _STEP_M], s_m, line_m)
    slope = (after_m - before_m) / (2.0 * _STEP_M)
    return now_m, slope, (after_m - 2.0 * now_m + before_m) / _STEP_M**2


class OffsetPath:
    """A line beside a route, on which the greatest speed is `top_mps`.

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
        """Take a line from an arc length on; one that is on the route from there is the route."""
        beside = np.flatnonzero((np.abs(offset_m) > _ON_ROUTE_M) & (self._route.s > s_m))
        self.until_m = float(self._route.s[beside[-1]]) + 1.0 if len(beside) else 0.0
        self.offset_m = offset_m if len(beside) else np.zeros_like(offset_m)

    def moved(self, rows: np.ndarray, ahead: slice) -> np.ndarray:
        """Return the rows x, y, v of the route at these points, moved to this line."""
        offset, heading = self.offset_m[ahead], self._route.heading[ahead]
        left = np.column_stack([-np.sin(heading), np.cos(heading), np.zeros_like(heading)])
        return rows + offset[:, None] * left if offset.any() else rows

    def shifted(
        self, line_m: np.ndarray, to_m: float, begin_m: float, speed_mps: float, room_m: float = 0.0
    ) -> np.ndarray:
        """Return a line (N,) that leaves another one (N,) without a kink, and goes to a distance.

        It is the quintic polynomial of M. Werling et al. (Optimal Trajectory Generation for Dynamic
        Street Scenarios in a Frenet Frame, ICRA 2010).

        It begins at an arc length [m], and is over within `room_m` if the speed of the car allows.
        """
        s = self._route.s
        now_m, slope, bend = state_at(s, line_m, begin_m)
        least_m, most_m = (
            self.shift_length_m(to_m - now_m, v, slope) for v in (speed_mps, self._top_mps)
        )
        ends_m = [begin_m, begin_m + max(least_m, min(room_m, most_m))]
        over = BPoly.from_derivatives(ends_m, [[now_m, slope, bend], [to_m, 0.0, 0.0]])
        return np.where(s < begin_m, line_m, over(np.clip(s, *ends_m)))

    def shift_length_m(self, shift_m: float, speed_mps: float, slope: float = 0.0) -> float:
        """Return the distance over which the car shifts across the road, positive: to the left [m].

        Where its slope to the left leads away at first, it takes longer.
        """
        least_m, most_mps2 = self._shifts.shift_m, self._shifts.shift_mps2
        turns = max(-slope * math.copysign(1.0, shift_m), 0.0)
        turning_m = 2.0 * turns * speed_mps**2 / most_mps2
        return max(least_m, turning_m + speed_mps * math.sqrt(_PEAK * abs(shift_m) / most_mps2))

    def bend_mps(self, bend: np.ndarray, road_bend: np.ndarray, s_m: np.ndarray) -> np.ndarray:
        """Return the speeds (..., N) with which the car follows the bends of lines [m/s].

        The lines bend so much more (..., N) than the route (N,) [1/m], at arc lengths 1 m apart.
        """
        # Where it is as good as parallel to the route, the speeds of the route are right.
        bend = np.where(np.abs(bend) > _STRAIGHT, np.abs(bend + road_bend), 0.0)
        bend = maximum_filter1d(bend, int(self._shifts.shift_m))
        square = 2.0 * self._shifts.shift_mps2 / np.maximum(bend, _STRAIGHT)
        # It brakes in time.
        before = 2.0 * self._shifts.shift_mps2 * s_m
        later = np.minimum.accumulate((square + before)[..., ::-1], axis=-1)[..., ::-1]
        return np.sqrt(later - before)
