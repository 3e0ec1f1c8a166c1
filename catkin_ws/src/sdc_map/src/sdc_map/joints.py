"""Lines from the end of a lane to the start of the next one."""

from __future__ import annotations

from typing import Iterable

import numpy as np

from sdc_common.geometry.road_line import arc_lengths, turns_rad
from sdc_map.network import part_of

_STEP_M = 0.5
# A line that turns by more at a step is no way for a car: its radius is below 1.9 m.
_SHARPEST_RAD = np.radians(15.0)
# A shorter line, and one between places that are closer to each other, is as long as its errors.
_SHORTEST_M = 0.5
# Its direction is that of the lanes so close to it.
_NEAR_M = 1.0


def joint(before: np.ndarray, after: np.ndarray, lines: Iterable[np.ndarray]) -> np.ndarray:
    """Return the first of some lines that joins two lanes, else a curve (N, 3) between them [m].

    A line is moved to the ends of the lanes, and joins them if it has no sharp bend then.

    Args:
        before: (M, 3) points of the lane before it [m]
        after: (K, 3) points of the lane after it [m]
        lines: (L, 3) points of each line [m]
    """
    tail, head = _start_of(before[::-1])[::-1], _start_of(after)
    start, end = tail[-1], head[0]
    for line in lines:
        s = arc_lengths(line)
        if min(s[-1], np.hypot(*(end - start)[:2])) < _SHORTEST_M:
            continue
        along = (s / s[-1])[:, None]
        line = line + (1.0 - along) * (start - line[0]) + along * (end - line[-1])
        whole = np.vstack([tail, line, head])
        s = arc_lengths(whole)
        turns = turns_rad(whole, s, np.arange(_STEP_M, s[-1] - _STEP_M, _STEP_M), _STEP_M)
        if turns.max(initial=0.0) < _SHARPEST_RAD:
            return line
    return curve(tail, head)


def curve(tail: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Return the cubic Hermite spline (N, 3) from the end of a line to the start of another [m].

    Between the ends of an arc, it is nearly that arc.
    """
    start, end = tail[-1], head[0]
    leave, arrive = _direction(tail), _direction(head)
    half_cos = np.sqrt(np.clip(0.5 + 0.5 * (leave[:2] @ arrive[:2]), 0.0, 1.0))
    tangent_m = np.hypot(*(end - start)[:2]) * 2.0 / (1.0 + half_cos)
    t = np.linspace(0.0, 1.0, int(tangent_m / _STEP_M) + 2)[:, None]
    leave, arrive = tangent_m * leave, tangent_m * arrive
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
    return step / max(float(np.hypot(*step[:2])), 1e-9)
