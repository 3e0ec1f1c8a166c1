"""Compares rows of numbers, and says what is typical about their difference."""

from __future__ import annotations

import math

from sdc_workshop.exam.answer import Problem

_NEAR = 1e-3


def points_problem(got: list, wanted: list, what: str, names: str = "x, y") -> Problem | None:
    """What is wrong with rows of x, y and perhaps more; None when they are as wanted."""
    if _equal(got, wanted):
        return None
    expected = f"{what}: {len(wanted)} rows {names}, the first {_row(wanted[0])}"
    if not got:
        return Problem(
            expected,
            "none at all",
            "Nothing arrived in it: is the list empty, or made of something else?",
        )
    seen = f"{len(got)} rows, the first {_row(got[0])}"
    if _equal([(row[1], row[0], *row[2:]) for row in got], wanted):
        return Problem(expected, seen, "x and y are swapped.")
    if _equal([(row[0], -row[1], *row[2:]) for row in got], wanted):
        return Problem(
            expected,
            seen,
            "The sign of y is wrong: it is turned round once too often, or once too few.",
        )
    if len(wanted[0]) == 3:
        if _equal(
            [(row[0], row[1], 0.0) for row in got], [(row[0], row[1], 0.0) for row in wanted]
        ):
            return Problem(
                expected,
                seen,
                "The speed v is not handed on: each row has x, y and v, and so has each point.",
            )
        for order, text in (
            ((0, 2, 1), "y and v are swapped."),
            ((2, 1, 0), "x and v are swapped."),
            ((1, 2, 0), "x, y and v are in the wrong order."),
            ((2, 0, 1), "x, y and v are in the wrong order."),
        ):
            if _equal([tuple(row[i] for i in order) for row in got], wanted):
                return Problem(expected, seen, text)
    if len(got) != len(wanted):
        for shift in (1, 2, 3, -1, -2, -3):
            if _equal(got, wanted[shift:]) or _equal(got[max(-shift, 0) :], wanted):
                return Problem(expected, seen, "It begins at the wrong point.")
    nearest = math.dist(got[0][:2], wanted[0][:2])
    return Problem(
        expected,
        f"{seen}, {nearest:.2f} m away",
        "Compare the numbers: where does the first difference come from?",
    )


def _equal(a, b) -> bool:
    return len(a) == len(b) and all(
        len(p) == len(q) and all(abs(x - y) < _NEAR for x, y in zip(p, q)) for p, q in zip(a, b)
    )


def _row(row) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in row) + ")"
