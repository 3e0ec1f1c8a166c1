"""The geometry of a route: arc length, heading, curvature, and where a car is on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from sdc_common.geometry.angles import wrap_angle

# Spacing and width (standard deviation) of the window in which heading and curvature are estimated. A recorded route has about
# 1 m between its points, and the tightest bend of a town (4 m radius) is some 6 m long: the window must span points, not bends.
_SAMPLE_M = 0.5
_SIGMA_M = 1.0


def checked_points(points_m) -> np.ndarray:
    """Return a copy of (N, 2) points, N >= 2. Raises ValueError for fewer points, other shapes, numbers that are not finite, and
    a point that repeats the one before it."""
    points = np.array(points_m, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(
            f"a route needs at least 2 points of x and y, got an array of shape {points.shape}"
        )
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        raise ValueError(f"point {int(np.argmin(finite))} of the route is not finite")
    repeats = (np.diff(points, axis=0) == 0.0).all(axis=1)
    if repeats.any():
        raise ValueError(f"points {int(np.argmax(repeats))} and the next of the route coincide")
    return points


def arc_length(points_m: np.ndarray) -> np.ndarray:
    """Distance along an (N, 2) polyline from its first point to each of its points: (N,) metres."""
    steps = np.hypot(*np.diff(points_m, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def respace(points_m: np.ndarray, shortest_m: float, longest_m: float) -> np.ndarray:
    """Return the (N, 2) polyline with points left out where they lie closer than `shortest_m` to the last one kept, and
    points added on the line where two lie farther apart than `longest_m`. The first and the last point always stay.

    Raises ValueError unless 0 <= shortest_m < longest_m, and for points that are no route.
    """
    if not 0.0 <= shortest_m < longest_m:
        raise ValueError(f"the shortest step {shortest_m} must lie below the longest {longest_m}")
    kept = _thinned(checked_points(points_m), shortest_m)
    lengths = np.hypot(*np.diff(kept, axis=0).T)
    parts = np.maximum(1, np.ceil(lengths / longest_m - 1e-9)).astype(int)
    start = np.repeat(np.arange(len(parts)), parts)
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    fraction = within / parts[start]
    dense = kept[start] + fraction[:, np.newaxis] * (kept[start + 1] - kept[start])
    return np.vstack([dense, kept[-1]])


def _thinned(points_m: np.ndarray, shortest_m: float) -> np.ndarray:
    steps = np.hypot(*np.diff(points_m, axis=0).T)
    if len(points_m) == 2 or steps.min() >= shortest_m:
        return points_m
    keep = [0]
    travelled = 0.0
    for index, step in enumerate(steps[:-1].tolist(), start=1):
        travelled += step
        if travelled >= shortest_m:
            keep.append(index)
            travelled = 0.0
    keep.append(len(points_m) - 1)
    return points_m[keep]


@dataclass(frozen=True)
class Place:
    """Where a point lies in relation to a route. cross_track_m is positive to the left of the route."""

    s_m: float
    cross_track_m: float
    heading_rad: float
    distance_m: float


class Route:
    """An open polyline with arc length `s` (N,) metres, `heading` (N,) radians (continuous, not wrapped) and `curvature`
    (N,) 1/m, positive to the left, at each of its `points` (N, 2).

    Heading and curvature are those of the line smoothed by a Gaussian (F. Mokhtarian and A. Mackworth, IEEE Trans. PAMI 8(1),
    1986, section III), so that the noise of a recorded route does not become a bend.
    Raises ValueError for fewer than two points, coincident neighbours and numbers that are not finite.
    """

    def __init__(self, points_m):
        self.points = checked_points(points_m)
        self.s = arc_length(self.points)
        self._lengths = np.diff(self.s)
        self._directions = np.diff(self.points, axis=0) / self._lengths[:, np.newaxis]
        self.heading, self.curvature = self._fit()
        self._tree = None

    @property
    def length_m(self) -> float:
        """Arc length of the whole route, metres."""
        return float(self.s[-1])

    def _fit(self):
        count = max(2, int(round(self.length_m / _SAMPLE_M)) + 1)
        s, step = np.linspace(0.0, self.length_m, count, retstep=True)
        xy = np.column_stack([np.interp(s, self.s, self.points[:, axis]) for axis in (0, 1)])
        # Beyond its ends the line goes on, mirrored in its end points: straight on, whatever it does before.
        reach = min(int(math.ceil(4.0 * _SIGMA_M / step)), count - 1)
        xy = np.vstack([2.0 * xy[0] - xy[reach:0:-1], xy, 2.0 * xy[-1] - xy[-2 : -2 - reach : -1]])
        sigma = min(_SIGMA_M, 0.25 * self.length_m) / step
        smooth = gaussian_filter1d(xy, sigma, axis=0, mode="nearest")
        first = np.gradient(smooth, step, axis=0)
        second = np.gradient(first, step, axis=0)[reach : reach + count]
        first = first[reach : reach + count]
        heading = np.unwrap(np.arctan2(first[:, 1], first[:, 0]))
        speed = np.maximum(np.hypot(first[:, 0], first[:, 1]), 1e-6)
        curvature = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
        return np.interp(self.s, s, heading), np.interp(self.s, s, curvature)

    def locate(self, x_m: float, y_m: float, yaw_rad: float = None) -> Place:
        """Find the place on the whole route nearest to a point, with a KD-tree.

        Where several passes of the route lie about equally near, one that runs in the direction of `yaw_rad` is taken
        before one that does not, and the earliest before the later.
        """
        if self._tree is None:
            self._tree = cKDTree(self.points)
        nearest, _ = self._tree.query((x_m, y_m))
        candidates = np.sort(self._tree.query_ball_point((x_m, y_m), nearest + 1.0))
        if yaw_rad is not None:
            along = candidates[np.cos(self.heading[candidates] - yaw_rad) > 0.0]
            candidates = along if len(along) else candidates
        passes = np.split(candidates, np.flatnonzero(np.diff(self.s[candidates]) > 5.0) + 1)
        first = passes[0]
        best = first[np.argmin(np.hypot(*(self.points[first] - (x_m, y_m)).T))]
        return self._nearest(x_m, y_m, max(0, best - 1), min(len(self._lengths), best + 1))

    def last_point_s(self, until_s_m: float) -> float:
        """Arc length of the last point of the route up to a place; that of the first point for a place before it."""
        return float(self.s[max(0, int(np.searchsorted(self.s, until_s_m, side="right")) - 1)])

    def project(
        self, x_m: float, y_m: float, near_s_m: float, back_m: float, ahead_m: float
    ) -> Place:
        """Find the place nearest to a point among those from `back_m` behind to `ahead_m` ahead of `near_s_m`.

        The cost does not depend on the length of the route.
        """
        first = int(np.searchsorted(self.s, near_s_m - back_m, side="right")) - 1
        last = int(np.searchsorted(self.s, near_s_m + ahead_m, side="left"))
        first = min(max(0, first), len(self._lengths) - 1)
        return self._nearest(x_m, y_m, first, max(first + 1, min(len(self._lengths), last)))

    def _nearest(self, x_m: float, y_m: float, first: int, last: int) -> Place:
        offset_x = x_m - self.points[first:last, 0]
        offset_y = y_m - self.points[first:last, 1]
        direction_x = self._directions[first:last, 0]
        direction_y = self._directions[first:last, 1]
        along = np.minimum(
            np.maximum(offset_x * direction_x + offset_y * direction_y, 0.0),
            self._lengths[first:last],
        )
        away_x = offset_x - along * direction_x
        away_y = offset_y - along * direction_y
        square = away_x * away_x + away_y * away_y
        best = int(square.argmin())
        segment = first + best
        fraction = float(along[best]) / float(self._lengths[segment])
        heading = float(self.heading[segment]) + fraction * float(
            self.heading[segment + 1] - self.heading[segment]
        )
        distance = math.sqrt(float(square[best]))
        side = direction_x[best] * away_y[best] - direction_y[best] * away_x[best]
        return Place(
            s_m=float(self.s[segment]) + float(along[best]),
            cross_track_m=math.copysign(distance, side),
            heading_rad=wrap_angle(heading),
            distance_m=distance,
        )
