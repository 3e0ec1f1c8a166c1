"""Validate parameters and files; the error names what is wrong and suggests a fix."""

from __future__ import annotations

import difflib
import sys
from typing import Any, Callable, Iterable, Mapping


class DocumentError(ValueError):
    """A file that cannot be used; the one-line message names file, line, problem and fix."""


def check_positive(**values: object) -> None:
    """Raise ValueError, with the name, for the first value that is no positive, finite number."""
    _check("a positive number", lambda value: value > 0.0, values)


def check_non_negative(**values: object) -> None:
    """Raise ValueError for the first value that is no finite number of at least 0."""
    _check("a number that is not negative", lambda value: value >= 0.0, values)


def check_finite(**values: object) -> None:
    """Raise ValueError for the first value that is no finite number."""
    _check("a finite number", lambda value: True, values)


def check_between(low: float, high: float, **values: object) -> None:
    """Raise ValueError for the first value that is no number from `low` to `high`."""
    _check(f"a number from {low:g} to {high:g}", lambda value: low <= value <= high, values)


def _check(text: str, is_valid: Callable[[Any], bool], values: Mapping[str, object]) -> None:
    for name, value in values.items():
        if not (is_number(value) and is_valid(value)):
            raise ValueError(f"{name} must be {text}, got {value!r}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite int or float; booleans are not numbers."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= sys.float_info.max


def suggestion(word: str, known: Iterable[str], otherwise: str) -> str:
    """Return the question whether the nearest known word was meant, `otherwise` if none is near."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean '{close[0]}'?" if close else otherwise
