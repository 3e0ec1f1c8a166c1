"""A line of points in the plane: arc length, heading, curvature, nearest place.

All path geometry of the project is computed here and in `segments`. Plain Python floats are faster
than NumPy arrays for the 10 to 60 segments that a node looks at in one tick.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.segments import line_numbers, nearest_segment

# Curvature is the change of heading from this far before a place to this far after it.
_CURVATURE_HALF_SPAN_M = 1.0


class Place(NamedTuple):
    """The place on a line that is nearest to a point."""

    segment: int  # index of the line's segment
    s_m: float  # arc length of the place [m]
    cross_track_m: float  # distance of the point, positive left of the line [m]
    heading_rad: float  # heading of the line at the place, in [-pi, pi) [rad]

    @property
    def distance_m(self) -> float:
        """Return the distance between the point and the line."""
        return abs(self.cross_track_m)


class Polyline:
    """Points with straight segments between them."""

    def __init__(self, points: Sequence, extend: bool = True):
        """Compute the geometry of a line.

        Args:
            points: two or more points (x, y) of Python floats [m]
            extend: whether the first and the last segment continue, straight, beyond the ends of
                the line
        """
        self.points = points
        # For functions that can be compiled
        self.numbers = line_numbers(points, extend)
        lengths, headings = self.numbers.lengths, self.numbers.headings
        if self.numbers.are_arrays:
            lengths, headings = lengths.tolist(), headings.tolist()
        self.lengths: list[float] = lengths  # of each segment [m]
        # At each point, continuous, not wrapped; at an inner one the mean of both segments' [rad]
        self.headings: list[float] = headings
        self.s = [*accumulate(lengths, initial=0.0)]  # arc length at each point [m]

    def set_headings(self, headings: list[float]) -> None:
        """Replace the headings at the points by ones that are known better [rad]."""
        self.headings = headings
        self.numbers = self.numbers.with_headings(headings)

    def nearest(self, x_m: float, y_m: float, first: int = 0, last: int | None = None) -> Place:
        """Return the place nearest to a point on the segments from `first` to before `last`."""
        if last is None:
            last = len(self.lengths)
        segment, along, cross_track = self.numbers.function(nearest_segment)(
            self.numbers.segments, x_m, y_m, first, last
        )
        length = self.lengths[segment]
        share = along / length if length else 0.0  # points may coincide
        heading = wrap_angle(self._heading_in(segment, share))
        return Place(segment, self.s[segment] + along, cross_track, heading)

    def project(
        self, x_m: float, y_m: float, near_s_m: float, back_m: float, ahead_m: float
    ) -> Place:
        """Return the place nearest to a point, so far back and ahead of an arc length [m].

        The cost does not depend on the length of the whole line.
        """
        count = len(self.lengths)
        first = min(max(bisect_right(self.s, near_s_m - back_m) - 1, 0), count - 1)
        last = min(max(bisect_left(self.s, near_s_m + ahead_m), first + 1), count)
        return self.nearest(x_m, y_m, first, last)

    def segment_at(self, s_m: float) -> tuple[int, float]:
        """Return the segment at an arc length and the fraction of it, in 0..1 inside the line."""
        i = min(max(bisect_right(self.s, s_m) - 1, 0), len(self.lengths) - 1)
        while self.lengths[i] == 0.0 and i > 0:
            i -= 1
        length = self.lengths[i]
        return i, (s_m - self.s[i]) / length if length > 0.0 else 0.0

    def point_at(self, s_m: float) -> tuple[float, float]:
        """Return (x, y) at an arc length; beyond the ends, the line continues straight."""
        i, fraction = self.segment_at(s_m)
        (x, y), (next_x, next_y) = self.points[i], self.points[i + 1]
        return x + fraction * (next_x - x), y + fraction * (next_y - y)

    def direction_at(self, s_m: float) -> float:
        """Return the direction of the segment at an arc length [rad]."""
        i, _ = self.segment_at(s_m)
        (x, y), (next_x, next_y) = self.points[i], self.points[i + 1]
        return math.atan2(next_y - y, next_x - x)

    def heading_at(self, s_m: float) -> float:
        """Return the heading at an arc length [rad], linear between points, constant outside."""
        return self._heading_in(*self.segment_at(s_m))

    def curvature_at(self, s_m: float) -> float:
        """Return the curvature at an arc length, averaged over 2 m, positive to the left [1/m]."""
        before = max(s_m - _CURVATURE_HALF_SPAN_M, 0.0)
        after = min(s_m + _CURVATURE_HALF_SPAN_M, self.s[-1])
        if not after > before:
            return 0.0
        return (self.heading_at(after) - self.heading_at(before)) / (after - before)

    def count_until(self, s_m: float) -> int:
        """Return how many points lie up to an arc length; at least 3 if the line has as many."""
        return min(max(3, bisect_right(self.s, s_m)), len(self.points))

    def _heading_in(self, segment: int, fraction: float) -> float:
        fraction = 0.0 if fraction < 0.0 else 1.0 if fraction > 1.0 else fraction
        heading = self.headings[segment]
        return heading + fraction * (self.headings[segment + 1] - heading)
