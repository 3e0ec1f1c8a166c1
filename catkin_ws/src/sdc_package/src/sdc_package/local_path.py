"""The road around the car as the controller sees it: the points ahead, and the last ones that it passed.

A path has some twenty points: plain Python floats are faster here than arrays.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

from sdc_common.geometry.polyline import Polyline

_KEEP_BEHIND_M = 8.0
_SAME_POINT_M = 1e-6
_SHORTEST_PREVIEW_M = 0.1
# Speeds are read a little ahead of the car: pedals have a lag, and better short of a stop line than over it.
_AIM_AHEAD_M = 0.3
# A car that is so far beyond the last point has no road: it is to stop, whatever speed that point had.
_BEYOND_END_M = 1.0


@dataclass(frozen=True)
class PathPoint:
    """The point of a path nearest to the car. cross_track_m is positive when the car is to the left of the path; speed and
    acceleration are those planned from a little ahead of it on, over the distance of the preview."""

    s_m: float
    cross_track_m: float
    heading_rad: float
    speed_mps: float
    acceleration_mps2: float


class ReferencePath:
    """A polyline of x, y (metres) and target speed (m/s) in the map frame.

    Each new path from the planner starts ahead of the car. What was passed stays known for a few metres, so that the car
    always has a piece of road under it.
    """

    def __init__(self):
        self.rows = []
        self.line = None

    def update(self, rows) -> None:
        """Take the (x, y, v) points of a new path, at least two. Raises ValueError for fewer points, numbers that are not finite,
        negative speeds, and points that all coincide; the last path stays in place then."""
        if len(rows) < 2:
            raise ValueError(f"a path needs at least 2 points of x, y and v, got {len(rows)}")
        distinct = []
        for x, y, v in rows:
            if not math.isfinite(x + y + v):
                raise ValueError("a point of the path is not finite")
            if v < 0.0:
                raise ValueError("a target speed of the path is negative")
            if not distinct or abs(x - distinct[-1][0]) + abs(y - distinct[-1][1]) > _SAME_POINT_M:
                distinct.append((x, y, v))
        if len(distinct) < 2:
            raise ValueError("all points of the path coincide")
        passed = self._passed(distinct[0])
        self.rows = passed + distinct
        self.line = Polyline([(x, y) for x, y, _ in self.rows])
        stops = (s for s, row in zip(self.line.s[len(passed) :], distinct) if row[2] == 0.0)
        self._stop_s = next(stops, self.line.s[-1])

    def _passed(self, first):
        """The points of the last path that come before `first`, if `first` is one of its points."""
        for i, row in enumerate(self.rows):
            if row[0] == first[0] and row[1] == first[1]:
                return self.rows[bisect_right(self.line.s, self.line.s[i] - _KEEP_BEHIND_M) : i]
        return []

    def nearest(self, x_m: float, y_m: float, preview_m: float = _SHORTEST_PREVIEW_M) -> PathPoint:
        """The place on the path nearest to a point; the first and last pieces reach on beyond their ends, with a speed of zero where
        the whole path lies behind."""
        _, _, s, cross_track, heading = self.line.nearest(x_m, y_m)
        if s > self.line.s[-1] + _BEYOND_END_M:
            return PathPoint(s, cross_track, heading, 0.0, 0.0)
        aim_s = s + _AIM_AHEAD_M
        # Beyond a stop nothing is planned: an average that reached over it would brake too little before it.
        reach_m = max(_SHORTEST_PREVIEW_M, min(preview_m, self._stop_s - aim_s))
        here, there = self._speed_squared(aim_s), self._speed_squared(aim_s + reach_m)
        return PathPoint(s, cross_track, heading, math.sqrt(here), (there - here) / (2.0 * reach_m))

    def _speed_squared(self, s: float) -> float:
        """At constant acceleration the square of the speed is linear over distance."""
        i = bisect_right(self.line.s, s, 1, len(self.line.s) - 1) - 1
        fraction = min(max((s - self.line.s[i]) / self.line.lengths[i], 0.0), 1.0)
        speed, next_speed = self.rows[i][2], self.rows[i + 1][2]
        return speed * speed + fraction * (next_speed * next_speed - speed * speed)
