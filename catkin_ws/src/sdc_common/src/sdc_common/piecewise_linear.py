"""Piecewise linear curves, looked up many times in each tick."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

Segments = Tuple[Tuple[float, float, float], ...]


def linear_segments(points: Sequence[float], values: Sequence[float]) -> Segments:
    """Return the segments of a curve of values at rising points, constant beyond both ends.

    Returns:
        (start x, value there, slope) of each segment, the last segment first
    """
    segments = [(points[-1], values[-1], 0.0)]
    for i in range(len(points) - 2, -1, -1):
        slope = (values[i + 1] - values[i]) / (points[i + 1] - points[i])
        segments.append((points[i], values[i], slope))
    segments.append((-math.inf, values[0], 0.0))
    return tuple(segments)


def evaluate(x: float, segments: Segments) -> float:
    """Return the value of the curve at x.

    Raises:
        ValueError: x is NaN
    """
    for start, value, slope in segments:
        if x >= start:
            return value + slope * (x - start) if slope else value
    raise ValueError("a piecewise linear curve has no value at nan")
