"""The segments of a line, in functions of numbers: plain on lists, or in machine code on arrays."""

from __future__ import annotations

import math
from itertools import chain
from math import atan2, pi, sqrt
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from sdc_common.machine_code import compiled, numba_module

# A repeated point has no direction. NaN is never nearer than another segment.
_NO_SEGMENT = (math.nan, math.nan, 0.0, 0.0, 0.0, 0.0)

_in_machine_code = False


class LineNumbers(NamedTuple):
    """The numbers of a line of n points: lists for plain functions, arrays for compiled ones."""

    points: Any  # x and y of each point, n rows [m]
    # x and y of the start, x and y of the unit direction, and the positions along the direction at
    # which the segment starts and ends, n - 1 rows [m]
    segments: Any
    lengths: Any  # length of each segment, n - 1 numbers [m]
    headings: Any  # heading at each point, n numbers [rad]

    @property
    def are_arrays(self) -> bool:
        """Return whether the numbers are for compiled functions."""
        return not isinstance(self.segments, list)

    def with_headings(self, headings: list[float]) -> LineNumbers:
        """Return the numbers with other headings."""
        return self._replace(headings=np.array(headings) if self.are_arrays else headings)

    def function(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of such numbers, compiled if it gets arrays."""
        return compiled(plain) if self.are_arrays else plain


def use_machine_code() -> None:
    """Let lines that are built from now on compute in machine code, if Numba is installed.

    It pays for thousands of drives; a node would wait for the compiler at its start.
    """
    global _in_machine_code
    _in_machine_code = numba_module() is not None


def new_rows(count: int, are_arrays: bool) -> Any:
    """Return a list or an array for so many rows of x and y."""
    return np.empty((count, 2)) if are_arrays else [(0.0, 0.0)] * count


def line_numbers(points: Sequence, extend: bool) -> LineNumbers:
    """Return the numbers of a line; see Polyline for the arguments."""
    n = len(points)
    if _in_machine_code:
        if not isinstance(points, np.ndarray):
            points = np.fromiter(chain.from_iterable(points), float).reshape(n, 2)
        numbers = LineNumbers(points, np.empty((n - 1, 6)), np.empty(n - 1), np.empty(n))
    else:
        numbers = LineNumbers(points, [_NO_SEGMENT] * (n - 1), [0.0] * (n - 1), [0.0] * n)
    numbers.function(measure)(*numbers, extend)
    return numbers


def measure(points: Any, segments: Any, lengths: Any, headings: Any, extend: bool) -> None:
    """Fill in the segments, lengths and headings of a line; see LineNumbers.

    The headings are continuous, not wrapped. At an inner point, the heading is the mean of those of
    its two segments. With `extend`, the line continues straight beyond its ends.
    """
    last = len(points) - 1
    x, y = points[0]
    heading = before = 0.0
    for i in range(last):
        next_x, next_y = points[i + 1]
        step_x, step_y = next_x - x, next_y - y
        length = sqrt(step_x * step_x + step_y * step_y)
        lengths[i] = length
        if length > 0.0:
            segments[i] = (x, y, step_x / length, step_y / length, 0.0, length)
            direction = atan2(step_y, step_x)
            if not -pi < heading - direction < pi and i > 0:
                direction += 2.0 * pi * round((heading - direction) / (2.0 * pi))
            heading = direction
        else:
            segments[i] = _NO_SEGMENT
        headings[i] = 0.5 * (before + heading) if i > 0 else heading
        x, y, before = next_x, next_y, heading
    headings[last] = heading
    if extend:
        x, y, direction_x, direction_y, low, high = segments[0]
        segments[0] = (x, y, direction_x, direction_y, -math.inf, high)
        x, y, direction_x, direction_y, low, high = segments[last - 1]
        segments[last - 1] = (x, y, direction_x, direction_y, low, math.inf)


def nearest_segment(
    segments: Any, x_m: float, y_m: float, first: int, last: int
) -> tuple[int, float, float]:
    """Return the segment nearest to a point, of those from `first` to before `last`.

    Returns:
        index of the segment, position of the nearest place along it [m], and distance of the point
        from that place, positive left of the line [m]; for a point that is not finite, the position
        is NaN and the distance is infinite
    """
    best = math.inf
    segment, along, side = first, math.nan, math.nan
    i = first
    for x, y, direction_x, direction_y, low, high in segments[first:last]:
        offset_x, offset_y = x_m - x, y_m - y
        position = offset_x * direction_x + offset_y * direction_y
        if position < low:
            position = low
        elif position > high:
            position = high
        away_x, away_y = offset_x - position * direction_x, offset_y - position * direction_y
        square = away_x * away_x + away_y * away_y
        if square < best:
            best, segment, along = square, i, position
            side = direction_x * away_y - direction_y * away_x
        i += 1
    return segment, along, math.copysign(sqrt(best), side)
