"""Lines from the end of a lane to the start of the next one."""

from __future__ import annotations

from typing import Iterable

import numpy as np

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_map.network import part_of

_STEP_M = 0.5
# A line that turns by more at a step is no way for a car: its radius is below 1.9 m.
_SHARPEST_RAD = np.radians(15.0)
# Its direction is that of the lanes so close to it.
_NEAR_M = 1.0


def joint(before: np.ndarray, after: np.ndarray, lines: Iterable[np.ndarray]) -> np.ndarray:
    """Return the first of some lines that joins two lanes, else a curve (N, 2) between them [m].

    A line is moved to the ends of the lanes, and joins them if it has no sharp bend then.

    Args:
        before: (M, 2) points of the lane before it [m]
        after: (K, 2) points of the lane after it [m]
        lines: (L, 2) points of each line [m]
    """
    tail, head = _start_of(before[::-1])[::-1], _start_of(after)
    start, end = tail[-1], head[0]
    for line in lines:
        s = arc_lengths(line)
        along = (s / max(s[-1], 1e-9))[:, None]
        line = line + (1.0 - along) * (start - line[0]) + along * (end - line[-1])
        if _sharpest_rad(np.vstack([tail, line, head])) < _SHARPEST_RAD:
            return line
    # A cubic Hermite spline.
    distance_m = np.hypot(*(end - start))
    t = np.linspace(0.0, 1.0, int(distance_m / _STEP_M) + 2)[:, None]
    leave, arrive = (distance_m * _direction(part) for part in (tail, head))
    return (
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * start
        + t * (1.0 - t) ** 2 * leave
        + t * t * (3.0 - 2.0 * t) * end
        - t * t * (1.0 - t) * arrive
    )


def _start_of(points_m: np.ndarray) -> np.ndarray:
    return part_of(points_m, arc_lengths(points_m), 0.0, _NEAR_M)


def _direction(points_m: np.ndarray) -> np.ndarray:
    step = points_m[-1] - points_m[0]
    return step / max(float(np.hypot(*step)), 1e-9)


def _sharpest_rad(points_m: np.ndarray) -> float:
    """Return the greatest angle by which a line turns at a step [rad]."""
    s = arc_lengths(points_m)
    steps = np.diff(interpolate(np.arange(0.0, s[-1], _STEP_M), s, points_m), axis=0)
    x, y = steps.T
    cross = x[:-1] * y[1:] - y[:-1] * x[1:]
    return float(np.abs(np.arctan2(cross, np.sum(steps[1:] * steps[:-1], axis=1))).max(initial=0.0))
