"""The road around the car as the controller sees it: the points ahead, and the last ones that it passed."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_package.route import wrap_angle

_KEEP_BEHIND_M = 8.0


@dataclass(frozen=True)
class PathPoint:
    """The point of a path nearest to the car. cross_track_m is positive when the car is to the left of the path."""

    s_m: float
    cross_track_m: float
    heading_rad: float
    speed_mps: float
    acceleration_mps2: float


class LocalPath:
    """A polyline of x, y (metres) and target speed (m/s) in the map frame.

    Each new path from the planner starts ahead of the car. What was passed stays known for a few metres, so that the car
    always has a piece of road under it.
    """

    def __init__(self):
        self.rows = np.empty((0, 3))

    def update(self, rows: np.ndarray) -> None:
        """Take the (n, 3) points of a new path, n >= 2. Raises ValueError for fewer points, other shapes, numbers that are not
        finite, negative speeds, and points that all coincide; the last path stays in place then."""
        rows = np.asarray(rows, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != 3 or len(rows) < 2:
            raise ValueError(f"a path needs at least 2 points of x, y and v, got {len(rows)}")
        if not np.isfinite(rows).all():
            raise ValueError("a point of the path is not finite")
        if rows[:, 2].min() < 0.0:
            raise ValueError("a target speed of the path is negative")
        distinct = np.append(True, np.hypot(*np.diff(rows[:, :2], axis=0).T) > 1e-6)
        if distinct.sum() < 2:
            raise ValueError("all points of the path coincide")
        rows = rows[distinct]
        self.rows = np.vstack([self._passed(rows[0]), rows])
        self._measure()

    def _passed(self, first: np.ndarray) -> np.ndarray:
        """The points of the last path that come before `first`, if `first` is one of its points."""
        same = np.flatnonzero((self.rows[:, 0] == first[0]) & (self.rows[:, 1] == first[1]))
        if not len(same):
            return np.empty((0, 3))
        behind = self.rows[:same[-1]]
        distance = np.hypot(behind[:, 0] - first[0], behind[:, 1] - first[1])
        near = np.flatnonzero(distance > _KEEP_BEHIND_M)
        return behind[near[-1] + 1:] if len(near) else behind

    def _measure(self) -> None:
        steps = np.diff(self.rows[:, :2], axis=0)
        self.lengths = np.hypot(steps[:, 0], steps[:, 1])
        self.s = np.concatenate([[0.0], np.cumsum(self.lengths)])
        self.headings = vertex_headings(steps)

    def nearest(self, x_m: float, y_m: float) -> PathPoint:
        """The place on the path nearest to a point; the first and last pieces reach on beyond their ends."""
        return nearest_point(self.rows, self.s, self.headings, x_m, y_m)


def vertex_headings(steps: np.ndarray) -> np.ndarray:
    """Continuous headings (n,) radians at the points of a polyline from its (n - 1, 2) steps: at inner points, that of the chord
    between the unit vectors of both steps."""
    segment = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return np.concatenate([segment[:1], 0.5 * (segment[:-1] + segment[1:]), segment[-1:]])


def nearest_point(rows: np.ndarray, s: np.ndarray, headings: np.ndarray, x_m: float, y_m: float) -> PathPoint:
    """The place nearest to a point on a polyline of (n, 3) rows x, y, v with arc lengths `s` and vertex headings."""
    start = rows[:-1]
    length = np.diff(s)
    step_x = (rows[1:, 0] - start[:, 0]) / length
    step_y = (rows[1:, 1] - start[:, 1]) / length
    offset_x = x_m - start[:, 0]
    offset_y = y_m - start[:, 1]
    along = offset_x * step_x + offset_y * step_y
    low = np.zeros(len(length))
    high = length.copy()
    low[0] = -math.inf
    high[-1] = math.inf
    along = np.minimum(np.maximum(along, low), high)
    away_x = offset_x - along * step_x
    away_y = offset_y - along * step_y
    i = int(np.argmin(away_x * away_x + away_y * away_y))
    fraction = min(max(float(along[i] / length[i]), 0.0), 1.0)
    side = float(step_x[i] * away_y[i] - step_y[i] * away_x[i])
    speed, next_speed = float(start[i, 2]), float(rows[i + 1, 2])
    square = max(0.0, speed * speed + fraction * (next_speed * next_speed - speed * speed))
    return PathPoint(
        s_m=float(s[i] + along[i]),
        cross_track_m=math.copysign(math.hypot(away_x[i], away_y[i]), side),
        heading_rad=wrap_angle(float(headings[i]) + fraction * float(headings[i + 1] - headings[i])),
        speed_mps=math.sqrt(square),
        acceleration_mps2=(next_speed * next_speed - speed * speed) / (2.0 * float(length[i])))
