"""The path that the controller follows."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import NamedTuple, Sequence

from sdc_common.geometry.polyline import Place, Polyline

Row = Sequence[float]

_KEEP_BEHIND_M = 8.0
_SAME_POINT_M = 1e-6
_MIN_PREVIEW_M = 0.1
# Target speeds are read this far ahead of the car: pedals act with a delay, and the car must stop
# before a stop line rather than behind it.
_AIM_AHEAD_M = 0.3
# A car that is farther beyond the last point has no path left and must stop.
_BEYOND_END_M = 1.0


class PathPoint(NamedTuple):
    """The point of a path nearest to the car."""

    s_m: float  # arc length [m]
    cross_track_m: float  # distance of the car, positive left of the path [m]
    heading_rad: float  # heading of the path [rad]
    speed_mps: float  # planned speed a little ahead of the car [m/s]
    acceleration_mps2: float  # planned acceleration, averaged over the preview [m/s^2]


class ReferencePath:
    """A line of points with target speeds, in the map frame.

    Each new path of the planner starts ahead of the car. The last points that the car has passed
    are kept, so that its place is always on the line.

    Attributes:
        rows: (x, y, v) of each point [m, m, m/s]
        line: geometry of the points; there is one after the first path
    """

    line: Polyline

    def __init__(self):
        self.rows: list[Row] = []
        self._newest: list[Row] | None = None
        self._passed = 0
        self._points: list[tuple[float, float]] = []
        self._stop_s_m = 0.0
        self._place_of: tuple[float, float, Place] | None = None

    @property
    def empty(self) -> bool:
        """Return whether no path has been set."""
        return not self.rows

    def update(self, rows: Sequence[Row]) -> None:
        """Set a new path; keep the last one if the new one is invalid.

        Args:
            rows: (x, y, v) of two or more points [m, m, m/s]

        Raises:
            ValueError: there are fewer than 2 points, a number is not finite, a speed is negative,
                or all points coincide
        """
        rows = [tuple(row) for row in rows]
        if rows == self._newest and len(self._passed_rows(rows[0])) == self._passed:
            return  # the planner repeats its path until the car has passed a point
        distinct = _distinct_rows(rows)
        passed = self._passed_rows(distinct[0])
        self.rows = [*passed, *distinct]
        self._newest, self._passed = distinct, len(passed)
        points = [(x, y) for x, y, _ in self.rows]
        if points != self._points:
            self._points, self.line, self._place_of = points, Polyline(points), None
        stops = (s for s, row in zip(self.line.s[len(passed) :], distinct) if row[2] == 0.0)
        self._stop_s_m = next(stops, self.line.s[-1])

    def place(self, x_m: float, y_m: float) -> Place:
        """Return the place on the line nearest to the car.

        The last place is remembered: the control of the speed and the steering need the same one.
        """
        if self._place_of is None or self._place_of[:2] != (x_m, y_m):
            self._place_of = x_m, y_m, self.line.nearest(x_m, y_m)
        return self._place_of[2]

    def nearest(self, x_m: float, y_m: float, preview_m: float = _MIN_PREVIEW_M) -> PathPoint:
        """Return the point of the path nearest to (x, y), with what is planned there.

        The first and the last segment continue beyond the ends. Where the whole path is behind the
        car, the planned speed is zero.

        Args:
            x_m: position of the car [m]
            y_m: position of the car [m]
            preview_m: distance ahead over which the planned acceleration is averaged [m]
        """
        place = self.place(x_m, y_m)
        if place.s_m > self.line.s[-1] + _BEYOND_END_M:
            return PathPoint(place.s_m, place.cross_track_m, place.heading_rad, 0.0, 0.0)
        aim_s_m = place.s_m + _AIM_AHEAD_M
        # An average that reaches beyond a stop would brake too little before it.
        reach_m = max(_MIN_PREVIEW_M, min(preview_m, self._stop_s_m - aim_s_m))
        square, square_ahead = self._speed_squared(aim_s_m), self._speed_squared(aim_s_m + reach_m)
        acceleration = (square_ahead - square) / (2.0 * reach_m)
        return PathPoint(
            place.s_m, place.cross_track_m, place.heading_rad, math.sqrt(square), acceleration
        )

    def _passed_rows(self, first: Row) -> list[Row]:
        """Return the points of the last path before `first`, if `first` is one of its points."""
        for i, row in enumerate(self.rows):
            if row[0] == first[0] and row[1] == first[1]:
                return self.rows[bisect_right(self.line.s, self.line.s[i] - _KEEP_BEHIND_M) : i]
        return []

    def _speed_squared(self, s_m: float) -> float:
        """Return the squared target speed, which is linear in the distance."""
        i, fraction = self.line.segment_at(s_m)
        fraction = min(max(fraction, 0.0), 1.0)
        speed, next_speed = self.rows[i][2], self.rows[i + 1][2]
        return speed * speed + fraction * (next_speed * next_speed - speed * speed)


def _distinct_rows(rows: Sequence[Row]) -> list[Row]:
    """Return the rows without repeated points. Raises ValueError as `ReferencePath.update` does."""
    if len(rows) < 2:
        raise ValueError(f"a path needs at least 2 points of x, y and v, got {len(rows)}")
    distinct: list[Row] = []
    last_x = last_y = math.inf
    for row in rows:
        x, y, v = row
        if not math.isfinite(x + y + v):
            raise ValueError("a point of the path is not finite")
        if v < 0.0:
            raise ValueError("a target speed of the path is negative")
        if abs(x - last_x) + abs(y - last_y) > _SAME_POINT_M:
            distinct.append(row)
            last_x, last_y = x, y
    if len(distinct) < 2:
        raise ValueError("all points of the path coincide")
    return distinct
