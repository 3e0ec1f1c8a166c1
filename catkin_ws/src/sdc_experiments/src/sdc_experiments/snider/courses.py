"""The courses of the comparison: lane change, figure-eight and road course."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.special import j0

from sdc_common.geometry.polyline import Place, Polyline
from sdc_sim.road.route_generator import curvature_profile

CurvatureProfile = Callable[[float], float]

_SAMPLE_M = 0.05
# Places are searched this far around the expected place.
_SEARCH_M = 0.5


class Course:
    """A road that is defined by its curvature.

    Attributes:
        name: name of the course
        curvature_at: curvature at an arc length, positive left [1/m]
        length_m: length of the road [m]
        measured: stretches (from, to) of arc length on which errors count [m]
        line: points of the road, 5 cm apart, with exact headings; it continues beyond its ends
    """

    def __init__(
        self,
        name: str,
        curvature_at: CurvatureProfile,
        length_m: float,
        measured: Sequence[tuple[float, float]],
    ):
        self.name, self.curvature_at, self.measured = name, curvature_at, measured
        s = np.arange(int(round(length_m / _SAMPLE_M)) + 1) * _SAMPLE_M
        middle = np.array([curvature_at(value) for value in s[:-1] + 0.5 * _SAMPLE_M])
        heading = np.concatenate([[0.0], np.cumsum(middle) * _SAMPLE_M])
        direction = heading[:-1] + 0.5 * middle * _SAMPLE_M
        steps = np.column_stack([np.cos(direction), np.sin(direction)])
        points = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0) * _SAMPLE_M])
        self.line = Polyline(list(map(tuple, points.tolist())))
        self.line.set_headings(heading.tolist())
        self.length_m = float(s[-1])

    def place(self, x_m: float, y_m: float, near_s_m: float) -> Place:
        """Return the place nearest to a point (x, y), searched from an arc length on [m]."""
        while True:
            place = self.line.project(x_m, y_m, near_s_m, _SEARCH_M, _SEARCH_M)
            # A place at the edge of the searched stretch is only the nearest of this stretch.
            if abs(place.s_m - near_s_m) < 0.9 * _SEARCH_M:
                return place
            near_s_m = place.s_m


def _piecewise(name: str, knots_m: np.ndarray, curvatures: np.ndarray, *measured: tuple) -> Course:
    """Return a course whose curvature is linear between knots."""
    length_m = float(knots_m[-1])
    return Course(name, lambda s: float(np.interp(s, knots_m, curvatures)), length_m, measured)


def lane_change() -> Course:
    """Return a double lane change: 3.5 m to the left, 25 m straight on, and back.

    The curvature of each change is one period of a sine over 30 m, which has no jump and no corner.
    99 % of the lateral motion happens within 25 m, the length in the plot of the paper.
    """
    width, length, gap = 3.5, 30.0, 25.0
    # With h = a T / (2 pi), the curvature a sin(2 pi s / T) gives the heading
    # h (1 - cos(2 pi s / T)), and moves the car sideways by T sin(h) J0(h).
    mean_heading = brentq(lambda h: length * math.sin(h) * j0(h) - width, 0.0, 0.5)
    peak = 2.0 * math.pi / length * mean_heading

    def curvature_at(s_m: float) -> float:
        for start, side in ((30.0, 1.0), (30.0 + length + gap, -1.0)):
            if start <= s_m <= start + length:
                return side * peak * math.sin(2.0 * math.pi * (s_m - start) / length)
        return 0.0

    return Course("lane change", curvature_at, 180.0, [(20.0, 160.0)])


def figure_eight() -> Course:
    """Return a figure-eight of two three-quarter circles of 64 m radius.

    Errors count on the second half of each circle, where the car is in a steady state.
    """
    circle, bend = 64.0 * 1.5 * math.pi, 1.0 / 64.0
    pieces = [(0.0, 0.0), (30.0, 0.0), (40.0, bend), (circle, bend), (80.0, -bend), (circle, -bend)]
    lengths, curvatures = np.array([*pieces, (40.0, 0.0)]).T
    ends = np.cumsum(lengths)
    halves = (ends[2] + 0.5 * circle, ends[3]), (ends[4] + 0.5 * circle, ends[5])
    return _piecewise("figure-eight", ends, curvatures, *halves)


def road_course() -> Course:
    """Return 1.3 km of country road with eight bends of 60 to 200 m radius.

    The paper uses a road of its own, which is not published.
    """
    elements = [{"straight_m": 40.0}]
    # Radius [m], positive left, angle [deg], and length of the straight after the bend [m].
    for radius, angle, straight in (
        *((80.0, 70.0, 30.0), (-60.0, 90.0, 0.0), (70.0, 60.0, 50.0), (200.0, 40.0, 0.0)),
        *((-100.0, 80.0, 20.0), (-65.0, 45.0, 0.0), (60.0, 100.0, 40.0), (-150.0, 50.0, 0.0)),
    ):
        side = "left_deg" if radius > 0.0 else "right_deg"
        elements.append({side: angle, "radius_m": abs(radius), "transition_m": 25.0})
        elements += [{"straight_m": straight}] if straight else []
    knots_m, curvatures = curvature_profile([*elements, {"straight_m": 60.0}])
    return _piecewise("road course", knots_m, curvatures, (20.0, knots_m[-1] - 30.0))
