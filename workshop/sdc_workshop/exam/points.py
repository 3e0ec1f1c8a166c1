"""Compare rows of numbers, and describe a typical difference."""

from __future__ import annotations

import math
from typing import Sequence

from sdc_workshop.exam.answer import Problem

_TOLERANCE = 1e-3
_ORDER = "x, y and v are in the wrong order."
# Orders of x, y and v that students confuse, as indices into the right order.
_ORDERS = (
    ((0, 2, 1), "y and v are swapped."),
    ((2, 1, 0), "x and v are swapped."),
    ((1, 2, 0), _ORDER),
    ((2, 0, 1), _ORDER),
)


def points_problem(got: list, wanted: list, what: str, columns: str = "x, y") -> Problem | None:
    """Return what is wrong with rows of numbers, or None.

    Args:
        got: rows x, y, and perhaps v
        wanted: the right rows
        what: what the rows are, for the message
        columns: names of the columns, for the message
    """
    if _equal(got, wanted):
        return None
    expected = f"{what}: {len(wanted)} rows {columns}, the first {_row(wanted[0])}"
    if not got:
        hint = "No rows were received: is the list empty, or built from something else?"
        return Problem(expected, "no rows", hint)
    seen = f"{len(got)} rows, the first {_row(got[0])}"
    difference = _difference(got, wanted)
    if difference is not None:
        return Problem(expected, seen, difference)
    distance = math.dist(got[0][:2], wanted[0][:2])
    return Problem(
        expected,
        f"{seen}, {distance:.2f} m away",
        "Compare the numbers: what causes the first difference?",
    )


def _difference(got: list, wanted: list) -> str | None:
    """Return a sentence about a typical difference, or None."""
    if _equal([(row[1], row[0], *row[2:]) for row in got], wanted):
        return "x and y are swapped."
    if _equal([(row[0], -row[1], *row[2:]) for row in got], wanted):
        return "The sign of y is wrong: it is negated once too often, or not at all."
    if len(wanted[0]) == 3:
        if _equal([row[:2] for row in got], [row[:2] for row in wanted]):
            return "The speed v is missing: each row has x, y and v, and so has each point."
        for order, text in _ORDERS:
            if _equal([tuple(row[i] for i in order) for row in got], wanted):
                return text
    if len(got) != len(wanted):
        for shift in (1, 2, 3, -1, -2, -3):
            if _equal(got, wanted[shift:]) or _equal(got[max(-shift, 0) :], wanted):
                return "It begins at the wrong point."
    return None


def _equal(a: Sequence, b: Sequence) -> bool:
    return len(a) == len(b) and all(
        len(p) == len(q) and all(abs(x - y) < _TOLERANCE for x, y in zip(p, q))
        for p, q in zip(a, b)
    )


def _row(row: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in row) + ")"
