"""A short line of points in the plane: arc length, heading, curvature, nearest place.

A path has some twenty points: plain Python floats are faster here than arrays.
"""

from __future__ import annotations

import math
from bisect import bisect_right

# Curvature is taken over so much road before and after a place: the points are about 1 m apart.
_HALF_SPAN_M = 1.0


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
        self.headings = [
            pieces[0],
            *(0.5 * (a + b) for a, b in zip(pieces, pieces[1:])),
            pieces[-1],
        ]

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
