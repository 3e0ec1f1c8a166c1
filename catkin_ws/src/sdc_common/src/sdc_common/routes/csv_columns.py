"""The columns x and y of a CSV file: its header says which they are."""

from __future__ import annotations

import csv
import re
from typing import NamedTuple, Sequence

import numpy as np

# The published Town03 file ends its lines with "\r\r\n": all carriage returns before a line feed
# belong to one end.
_LINE_END = re.compile(r"\r*\n|\r")
_DELIMITERS = (";", ",", "\t", None)  # None: blanks
_DECIMAL_COMMA = re.compile(r"([-+]?\d*),(\d+)")
_DECIMALS = "write numbers with a decimal point and without thousands separators"
# Words in the name of a column that do not change what it is.
_NEUTRAL = re.compile(
    r"m|in|met(re|er)s?|pos|position|pose|points?|coord(inate)?s?|field|loc|location|transform|opt"
    r"|translation|map|world|local|global|odom(etry)?|ref(erence)?|cent(er|re)|line|raceline|track"
    r"|wp|waypoints?|car|vehicle|ego|gps|gnss"
)
_DEGREES = re.compile("lat|latitude|lon|lng|long|longitude")
_OTHER_UNITS = re.compile("[mck]m|ft|feet|foot|inch(es)?|yd|mi|px|pixels?|deg|degrees")
# Relative and absolute error of a distance that is computed from two columns.
_DISTANCE_ERROR = (0.02, 1e-3)
# Column 2 may be a height if it varies by less than this share of what column 3 varies by.
_HEIGHT_SHARE = 0.1
# A third column that varies by less is no coordinate [m].
_LEAST_SPAN_M = 1.0


class Table(NamedTuple):
    """The lines of a CSV file that have values."""

    rows: list[tuple[int, list[str]]]  # number of the line, from 1, and its fields
    names: Sequence[str] = ()  # of the columns, empty without a header
    x: int = 0  # column of x, from 0
    y: int = 1  # column of y


def read_table(text: str) -> Table:
    """Return the lines of a CSV file with values, and the columns x and y.

    A header names the columns: the first line, or a comment above the first values. Without one, x
    and y are columns 1 and 2.

    Raises:
        ValueError: a header does not name x and y, or numbers have commas of several meanings
    """
    lines = [line.strip() for line in _LINE_END.split(text)]
    filled = [(row, line.split("#", 1)[0]) for row, line in enumerate(lines, 1)]
    filled = [(row, line) for row, line in filled if line[:1] != "%" and line.strip(' ",;\t')]
    values = "\n".join(line for _, line in filled)
    delimiter = _delimiter(values.split("\n"))
    rows = [(row, _fields(line, delimiter)) for row, line in filled]
    table = _table(rows, lines)
    decimal_points = re.search(r"\d\.\d", values)
    if delimiter != "," and decimal_points and re.search(r"\d,\d", values):
        raise ValueError(f"the file has commas and points in its numbers; {_DECIMALS}")
    # No integer begins with 0.
    if delimiter == "," and not decimal_points and (found := re.search(r"\d+,0\d+", values)):
        raise ValueError(f"{found[0]!r} is a number with a decimal comma; {_DECIMALS}")
    return table


def _table(rows: list[tuple[int, list[str]]], lines: Sequence[str]) -> Table:
    """Return the rows without the header, and what the header says."""
    row, first = rows[0] if rows else (0, ["0"])
    above = range(row - 1, 0, -1)
    try:
        if not any(map(is_number, first)):
            if not (columns := _columns(first)):
                raise ValueError(
                    f"the header {', '.join(first)!r} does not name one column x and one column y; "
                    "name them, in metres, y to the right of x"
                )
            return Table(rows[1:], first, *columns)
        for row in above:
            for names in (_fields(lines[row - 1].lstrip("#% "), mark) for mark in _DELIMITERS):
                # With half as many names as columns, each number has a decimal comma.
                if len(names) in (len(first), len(first) / 2) and (columns := _columns(names)):
                    return Table(rows, names, *columns)
    except ValueError as error:
        raise ValueError(f"row {row}: {error}") from None
    return Table(rows)


def _delimiter(lines: Sequence[str]) -> str | None:
    """Return the delimiter with which the first two columns of a line are numbers."""
    for line in lines:
        for delimiter in _DELIMITERS:
            fields = _fields(line, delimiter)
            if len(fields) > 1 and all(map(is_number, fields[:2])):
                return delimiter
    return next((mark for mark in _DELIMITERS if mark and mark in lines[0]), None)


def _fields(line: str, delimiter: str | None) -> list[str]:
    """Return the columns of a line, with decimal points if the delimiter is no comma."""
    fields = line.split()
    if delimiter:
        fields = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    fields = [field.strip(" \t\"'") for field in fields]
    if delimiter == ",":
        return fields
    return [_DECIMAL_COMMA.sub(r"\1.\2", field) for field in fields]


def is_number(field: str) -> bool:
    """Return whether a field is a number."""
    try:
        float(field)
    except ValueError:
        return False
    return True


def _columns(names: Sequence[str]) -> tuple[int, int] | None:
    """Return the columns of x and y, from 0; None if the names are no names of places.

    Raises:
        ValueError: the places are not in metres
    """
    kinds = [_kind(name) for name in names]
    if kinds.count("x") == kinds.count("y") == 1:
        return kinds.index("x"), kinds.index("y")
    other = [name for name, kind in zip(names, kinds) if kind == "other unit"]
    if len(other) < 2:
        return None
    raise ValueError(
        f"{other[0]!r} and {other[1]!r} are degrees or in another unit; convert them to metres in "
        "a local frame, y to the right of x"
    )


def _kind(name: str) -> str:
    """Return x, y, "other unit" for a place that is not in metres, or "" for another column."""
    words = re.findall("[a-z]+", re.sub("([a-z])([A-Z])", r"\1 \2", name).lower())
    words = [word for word in words if not _NEUTRAL.fullmatch(word)]
    what = [word for word in words if not _OTHER_UNITS.fullmatch(word)]
    if len(what) == 1 and (_DEGREES.fullmatch(what[0]) or (what[0] in "xy" and len(words) > 1)):
        return "other unit"
    return what[0] if what in (["x"], ["y"]) else ""


def check_count(fields: Sequence[str], table: Table) -> None:
    """Raise ValueError for a row with other columns, as of numbers with thousands separators."""
    if table.names:
        count = max(n for n, field in enumerate(fields, 1) if field)
        least, most = 0, len(table.names)
    else:
        count = sum(map(is_number, fields))
        least = most = sum(map(is_number, table.rows[0][1]))
    if not least <= count <= most:
        raise ValueError(
            f"the row has {count} columns with numbers, but {most} are expected; write each column "
            f"in each row, and {_DECIMALS}"
        )


def doubt(table: Table, route: np.ndarray, refused: bool) -> str:
    """Return why the columns of a route (N, 2) are perhaps others, empty if they are x and y.

    `refused` is whether no car can drive the route.
    """
    third = [float(fields[2]) for _, fields in table.rows if is_number("".join(fields[2:3]))]
    if len(third) < len(route) or (table.x, table.y) != (0, 1):
        return ""
    along, aside, upwards = np.abs(np.diff(np.column_stack([route, third]), axis=0)).T
    span, third_span = np.ptp(route[:, 1]), np.ptp(third)
    if not _LEAST_SPAN_M <= third_span < np.inf:
        return ""
    steps = np.hypot(aside, upwards)
    scale = steps.sum() / max(along.sum(), 1e-9)
    if not table.names and np.allclose(scale * along, steps, *_DISTANCE_ERROR):
        return "column 1 grows with the distance along columns 2 and 3, as in s,x,y or t,x,y"
    is_flat = not (span or table.names or np.allclose(upwards, along, *_DISTANCE_ERROR))
    if is_flat or (refused and span < _HEIGHT_SHARE * third_span):
        return f"column 2 varies by {span:.1f} in all and column 3 by {third_span:.1f}, as in x,z,y"
    return ""
