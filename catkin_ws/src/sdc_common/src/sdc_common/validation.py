"""Checks of the figures that a parameter file gives: whatever stands there, the mistake is named before the car moves."""

from __future__ import annotations

import math


def check_positive(**figures) -> None:
    """Raises ValueError, by name, for the first of these figures that is no positive, finite number."""
    for name, value in figures.items():
        if not (is_number(value) and value > 0.0):
            raise ValueError(f"{name} must be a positive number, got {value!r}")


def check_non_negative(**figures) -> None:
    """Raises ValueError, by name, for the first of these figures that is no finite number from 0 on."""
    for name, value in figures.items():
        if not (is_number(value) and value >= 0.0):
            raise ValueError(f"{name} must be a number that is not negative, got {value!r}")


def check_finite(**figures) -> None:
    """Raises ValueError, by name, for the first of these figures that is no finite number."""
    for name, value in figures.items():
        if not is_number(value):
            raise ValueError(f"{name} must be a finite number, got {value!r}")


def check_between(low: float, high: float, **figures) -> None:
    """Raises ValueError, by name, for the first of these figures that is no number from `low` to `high`."""
    for name, value in figures.items():
        if not (is_number(value) and low <= value <= high):
            raise ValueError(f"{name} must be a number from {low:g} to {high:g}, got {value!r}")


def is_number(value) -> bool:
    """Whether this is a finite number that arithmetic can be done with; yes and no are none."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
