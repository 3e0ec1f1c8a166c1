"""The road around the car as the controller sees it: the points ahead, and the last ones that it passed.

A path has some twenty points: plain Python floats are faster here than arrays.
"""
from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

_KEEP_BEHIND_M = 8.0
_SAME_POINT_M = 1e-6
_SHORTEST_PREVIEW_M = 0.1
# Speeds are read a little ahead of the car: pedals have a lag, and better short of a stop line than over it.
_AIM_AHEAD_M = 0.3
# A car that is so far beyond the last point has no road: it is to stop, whatever speed that point had.
_BEYOND_END_M = 1.0
# Curvature is taken over so much road before and after a place: the points are about 1 m apart.
_HALF_SPAN_M = 1.0


@dataclass(frozen=True)
class PathPoint:
    """The point of a path nearest to the car. cross_track_m is positive when the car is to the left of the path; speed and
    acceleration are those planned from a little ahead of it on, over the distance of the preview."""

    s_m: float
    cross_track_m: float
    heading_rad: float
    speed_mps: float
    acceleration_mps2: float


class Polyline:
    """Points (x, y) in metres with `lengths` of the pieces between them, arc length `s` and continuous `headings`, all lists.

    The heading at an inner point is the mean of its two pieces' headings, so that it changes steadily along the line.
    """

    def __init__(self, points):
        self.points = points
        self.lengths = []
        self.s = [0.0]
        pieces = []
        last = None
        for (x, y), (next_x, next_y) in zip(points, points[1:]):
            step_x, step_y = next_x - x, next_y - y
            length = math.sqrt(step_x * step_x + step_y * step_y)
            heading = math.atan2(step_y, step_x)
            if last is not None:
                heading += 2.0 * math.pi * round((last - heading) / (2.0 * math.pi))
            last = heading
            pieces.append(heading)
            self.lengths.append(length)
            self.s.append(self.s[-1] + length)
        self.headings = [pieces[0], *(0.5 * (a + b) for a, b in zip(pieces, pieces[1:])), pieces[-1]]

    def count_until(self, s_m: float) -> int:
        """How many points lie up to arc length `s_m`, and 3 at the least if there are as many."""
        return min(max(3, bisect_right(self.s, s_m)), len(self.points))

    def point_at(self, s_m: float):
        """(x, y) at arc length `s_m`; the first and the last piece reach on beyond the ends."""
        i, along = self._piece_at(s_m)
        (x, y), (next_x, next_y) = self.points[i], self.points[i + 1]
        part = along / self.lengths[i]
        return x + part * (next_x - x), y + part * (next_y - y)

    def heading_at(self, s_m: float) -> float:
        """Heading in radians at arc length `s_m`, linear between the points and constant beyond the ends."""
        i, along = self._piece_at(s_m)
        part = min(max(along / self.lengths[i], 0.0), 1.0)
        return self.headings[i] + part * (self.headings[i + 1] - self.headings[i])

    def curvature_at(self, s_m: float) -> float:
        """Curvature in 1/m at arc length `s_m`, positive to the left: the change of heading over 2 m, or what there is of them."""
        before, after = max(s_m - _HALF_SPAN_M, 0.0), min(s_m + _HALF_SPAN_M, self.s[-1])
        if not after > before:
            return 0.0
        return (self.heading_at(after) - self.heading_at(before)) / (after - before)

    def _piece_at(self, s_m: float):
        i = min(max(bisect_right(self.s, s_m) - 1, 0), len(self.lengths) - 1)
        while self.lengths[i] == 0.0 and i > 0:
            i -= 1
        return i, s_m - self.s[i]

    def nearest(self, x_m: float, y_m: float):
        """(index of the piece, fraction of it, s_m, cross_track_m, heading_rad) of the place nearest to a point.

        The first and the last piece reach on beyond the ends; there the fraction stays within 0..1.
        """
        best = None
        final = len(self.lengths) - 1
        points = self.points
        for i, length in enumerate(self.lengths):
            if length == 0.0:
                continue
            x, y = points[i]
            step_x, step_y = (points[i + 1][0] - x) / length, (points[i + 1][1] - y) / length
            offset_x, offset_y = x_m - x, y_m - y
            along = offset_x * step_x + offset_y * step_y
            if along < 0.0 and i > 0:
                along = 0.0
            elif along > length and i < final:
                along = length
            away_x, away_y = offset_x - along * step_x, offset_y - along * step_y
            square = away_x * away_x + away_y * away_y
            if best is None or square < best[0]:
                best = square, i, along, step_x * away_y - step_y * away_x
        square, i, along, side = best
        fraction = min(max(along / self.lengths[i], 0.0), 1.0)
        heading = self.headings[i] + fraction * (self.headings[i + 1] - self.headings[i])
        return i, fraction, self.s[i] + along, math.copysign(math.sqrt(square), side), heading


class LocalPath:
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
        stops = (s for s, row in zip(self.line.s[len(passed):], distinct) if row[2] == 0.0)
        self._stop_s = next(stops, self.line.s[-1])

    def _passed(self, first):
        """The points of the last path that come before `first`, if `first` is one of its points."""
        for i, row in enumerate(self.rows):
            if row[0] == first[0] and row[1] == first[1]:
                return self.rows[bisect_right(self.line.s, self.line.s[i] - _KEEP_BEHIND_M):i]
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
