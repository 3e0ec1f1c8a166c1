"""Validate numeric parameters; the error names the parameter."""

from __future__ import annotations

import math


def check_positive(**values: object) -> None:
    """Raise ValueError for the first value that is no positive, finite number.

    Args:
        values: the value of each parameter, by the parameter's name
    """
    for name, value in values.items():
        if not (is_number(value) and value > 0.0):  # type: ignore[operator]
            raise ValueError(f"{name} must be a positive number, got {value!r}")


def check_non_negative(**values: object) -> None:
    """Raise ValueError for the first value that is no finite number of at least 0."""
    for name, value in values.items():
        if not (is_number(value) and value >= 0.0):  # type: ignore[operator]
            raise ValueError(f"{name} must be a number that is not negative, got {value!r}")


def check_finite(**values: object) -> None:
    """Raise ValueError for the first value that is no finite number."""
    for name, value in values.items():
        if not is_number(value):
            raise ValueError(f"{name} must be a finite number, got {value!r}")


def check_between(low: float, high: float, **values: object) -> None:
    """Raise ValueError for the first value that is no number from `low` to `high`."""
    for name, value in values.items():
        if not (is_number(value) and low <= value <= high):  # type: ignore[operator]
            raise ValueError(f"{name} must be a number from {low:g} to {high:g}, got {value!r}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite int or float; booleans are not numbers."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
