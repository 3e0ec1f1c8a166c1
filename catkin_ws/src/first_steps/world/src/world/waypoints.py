"""The points of the route: on an ellipse, or from a file."""

from __future__ import annotations

import csv
import math
from typing import NamedTuple

IDX_MAX = 65535  # um_msgs/Waypoint.idx is a uint16


class Waypoint(NamedTuple):
    """A point of the route; sorts by `idx`, its place in the order of visits. `x`, `y` in field units."""

    idx: int
    x: float
    y: float


class WaypointError(ValueError):
    """A route that cannot be used; the text names the file and row, and the mend."""


def ellipse(count, width, height):
    """`count` waypoints counter-clockwise on an ellipse around the origin, from its right end; sizes in field units."""
    angles = [2.0 * math.pi * idx / count for idx in range(count)]
    return [
        Waypoint(idx, width / 2.0 * math.cos(a), height / 2.0 * math.sin(a))
        for idx, a in enumerate(angles)
    ]


def load_csv(path):
    """Waypoints from a CSV of x,y[,anything] in field units, one point a row; a header line is allowed.

    The rows number themselves from 0, unless the header calls a column `idx`. Raises WaypointError.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = [
                (line, row)
                for line, row in enumerate(csv.reader(file), start=1)
                if any(c.strip() for c in row)
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise WaypointError(
            f"waypoints_path {path}: {error}; give a readable CSV file of x,y"
        ) from error
    columns = {"x": 0, "y": 1}
    if rows and not _is_number(rows[0][1][0]):
        header = [cell.strip().lower() for cell in rows.pop(0)[1]]
        columns = {name: header.index(name) for name in ("x", "y", "idx") if name in header}
        if not {"x", "y"} <= set(columns):
            raise WaypointError(
                f"{path}: row 1: the header {','.join(header)} lacks x or y; call the columns x,y"
            )
    return [_waypoint(path, line, row, columns, place) for place, (line, row) in enumerate(rows)]


def _waypoint(path, line, row, columns, place):
    try:
        x, y = (float(row[columns[name]]) for name in ("x", "y"))
        idx = int(row[columns["idx"]]) if "idx" in columns else place
    except (IndexError, ValueError):
        raise WaypointError(
            f"{path}: row {line}: '{','.join(row)}' is not a point; write x,y in numbers"
        ) from None
    if not (math.isfinite(x) and math.isfinite(y)):
        raise WaypointError(
            f"{path}: row {line}: '{','.join(row)}' is not finite; write x,y in plain numbers"
        )
    if not 0 <= idx <= IDX_MAX:
        raise WaypointError(
            f"{path}: row {line}: idx {idx} is not within 0..{IDX_MAX}; number the points from 0"
        )
    return Waypoint(idx, x, y)


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def check_route(waypoints, field, touch_distance, source):
    """Raises WaypointError, naming `source`, for a route on which no lap can be driven or counted."""
    if len(waypoints) < 2:
        raise WaypointError(
            f"{source}: {len(waypoints)} waypoint(s); a lap needs at least 2, add some"
        )
    for waypoint in waypoints:
        if not field.contains(waypoint.x, waypoint.y):
            raise WaypointError(
                f"{source}: waypoint {waypoint.idx} at ({waypoint.x:g}, {waypoint.y:g}) lies outside the walls at x +-"
                f"{field.width / 2:g}, y +-{field.height / 2:g}; move it inside or enlarge field_width, field_height"
            )
    first = waypoints[0]
    if all(math.hypot(w.x - first.x, w.y - first.y) <= 2.0 * touch_distance for w in waypoints):
        raise WaypointError(
            f"{source}: all waypoints lie within twice touch_distance ({touch_distance:g} u), "
            "so no lap can be counted; spread them or lower touch_distance"
        )
