"""The centre line of a lane as a clothoid spline: curvature is linear between knots."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

STEP_M = 0.5
KNOT_M = 3.0
POINTS_PER_KNOT = round(KNOT_M / STEP_M)


class CurvePlace(NamedTuple):
    """The place on a curve next to a point."""

    s_m: float  # arc length from the anchor [m]
    offset_m: float  # distance of the point to the left of the curve [m]
    heading_rad: float  # direction of the curve [rad]


class LaneCurve:
    """A curve from an anchor pose, in a fixed frame.

    Attributes:
        x_m: position of the anchor [m]
        y_m: position of the anchor [m]
        heading_rad: direction at the anchor [rad]
        curvatures_1pm: curvatures (K,) at the knots, KNOT_M apart, positive left [1/m]
        s_m: arc lengths (N,) of the points, STEP_M apart, from the anchor [m]
        points_m: points (N, 2) [m]
        headings_rad: directions (N,) [rad]
    """

    def __init__(self, x_m: float, y_m: float, heading_rad: float, curvatures_1pm: np.ndarray):
        self.x_m, self.y_m, self.heading_rad = x_m, y_m, heading_rad
        self.curvatures_1pm = np.asarray(curvatures_1pm, float)
        self._turn = _turn_matrix(len(self.curvatures_1pm))
        self.s_m = STEP_M * np.arange(len(self._turn))
        self.headings_rad = heading_rad + self._turn @ self.curvatures_1pm
        middle = 0.5 * (self.headings_rad[1:] + self.headings_rad[:-1])
        steps = STEP_M * np.column_stack([np.cos(middle), np.sin(middle)])
        self.points_m = np.array([x_m, y_m]) + np.concatenate(
            [np.zeros((1, 2)), np.cumsum(steps, axis=0)]
        )

    @property
    def left(self) -> np.ndarray:
        """Return unit vectors (N, 2) to the left of the points."""
        return np.column_stack([-np.sin(self.headings_rad), np.cos(self.headings_rad)])

    @property
    def turns(self) -> np.ndarray:
        """Return how the directions of the points change with the parameters (N, 2 + K)."""
        ones = np.ones(len(self.s_m))
        return np.column_stack([np.zeros(len(self.s_m)), ones, self._turn])

    def jacobian(self) -> np.ndarray:
        """Return how the points move to the left with the parameters (N, 2 + K).

        The parameters are the displacement of the anchor to the left [m], its heading [rad] and the
        curvatures at the knots [1/m]. It holds for all lines parallel to the curve.
        """
        turned = self.headings_rad[:, None] - self.headings_rad[None, :]
        along = np.tril(np.cos(turned), -1) * STEP_M
        change = self.turns[:, 1:]
        # The turn in the middle of each step moves everything after it.
        middle = np.vstack([0.5 * (change[1:] + change[:-1]), np.zeros(change.shape[1])])
        return np.column_stack([np.cos(self.headings_rad - self.heading_rad), along @ middle])

    def moved(self, change: np.ndarray) -> LaneCurve:
        """Return the curve with changed parameters (2 + K,), in the order of `jacobian`."""
        return LaneCurve(
            self.x_m - change[0] * math.sin(self.heading_rad),
            self.y_m + change[0] * math.cos(self.heading_rad),
            self.heading_rad + change[1],
            self.curvatures_1pm + change[2:],
        )

    def nearest(self, x_m: float, y_m: float, within_m: float = math.inf) -> CurvePlace:
        """Return the place next to (x, y) within an arc length from the anchor."""
        away = np.array([x_m, y_m]) - self.points_m[self.s_m <= within_m]
        i = int(np.argmin(np.sum(away * away, axis=1)))
        heading, curvature = float(self.headings_rad[i]), float(self.curvature_at(self.s_m[i]))
        c, s = math.cos(heading), math.sin(heading)
        across = float(away[i, 1] * c - away[i, 0] * s)
        # On the inside of a bend, the foot of the perpendicular moves farther than the point.
        nearer = max(0.2, 1.0 - curvature * across)
        along = float(away[i, 0] * c + away[i, 1] * s) / nearer
        offset = across - 0.5 * nearer * curvature * along * along
        return CurvePlace(float(self.s_m[i]) + along, offset, heading + curvature * along)

    def curvature_at(self, s_m: float | np.ndarray) -> np.ndarray:
        """Return the curvature at arc lengths [1/m]."""
        return np.interp(s_m, KNOT_M * np.arange(len(self.curvatures_1pm)), self.curvatures_1pm)


_TURNS: dict[int, np.ndarray] = {}


def _turn_matrix(knots: int) -> np.ndarray:
    """Return the matrix (N, K) from curvatures at the knots to the turn since the anchor [rad]."""
    if knots not in _TURNS:
        s = STEP_M * np.arange((knots - 1) * POINTS_PER_KNOT + 1)
        hats = np.maximum(0.0, 1.0 - np.abs(s[:, None] / KNOT_M - np.arange(knots)))
        steps = 0.5 * STEP_M * (hats[1:] + hats[:-1])
        _TURNS[knots] = np.concatenate([np.zeros((1, knots)), np.cumsum(steps, axis=0)])
    return _TURNS[knots]
