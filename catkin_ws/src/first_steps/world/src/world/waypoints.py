"""The points of the route: generated on an ellipse, or loaded from a file."""

from __future__ import annotations

import csv
import math
from typing import Mapping, NamedTuple, Sequence

from world.car import Field

IDX_MAX = 65535  # um_msgs/Waypoint.idx is a uint16


class Waypoint(NamedTuple):
    """A point of the route at `x`, `y` [u]; sorts by `idx`, its number in the order of visits."""

    idx: int
    x: float
    y: float


class WaypointError(ValueError):
    """An invalid route; the message names the file, the row and the fix."""


def ellipse(count: int, width: float, height: float) -> list[Waypoint]:
    """Return waypoints counter-clockwise on an ellipse around the origin, from its right end.

    Args:
        count: number of points
        width: whole width [u]
        height: whole height [u]
    """
    angles = [2.0 * math.pi * idx / count for idx in range(count)]
    return [
        Waypoint(idx, width / 2.0 * math.cos(angle), height / 2.0 * math.sin(angle))
        for idx, angle in enumerate(angles)
    ]


def load_csv(path: str) -> list[Waypoint]:
    """Load waypoints from a CSV file.

    Args:
        path: file with one point x,y[,anything] [u] per row and an optional header line; points are
            numbered from 0, or by the column `idx` if the header has one

    Raises:
        WaypointError: the file is not readable or a row is not a point
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = [
                (line, row)
                for line, row in enumerate(csv.reader(file), start=1)
                if any(cell.strip() for cell in row)
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
    return [_waypoint(path, line, row, columns, index) for index, (line, row) in enumerate(rows)]


def _waypoint(
    path: str, line: int, row: Sequence[str], columns: Mapping[str, int], index: int
) -> Waypoint:
    try:
        x, y = (float(row[columns[name]]) for name in ("x", "y"))
        idx = int(row[columns["idx"]]) if "idx" in columns else index
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


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def check_route(
    waypoints: Sequence[Waypoint], field: Field, touch_distance: float, source: str
) -> None:
    """Check that laps can be driven and counted on a route.

    Args:
        waypoints: points of the route
        field: field that must contain them
        touch_distance: distance at which the lap counter counts a point as touched [u]
        source: file or parameters of the route, for the error message

    Raises:
        WaypointError: fewer than 2 points, a point outside the walls, or all points close together
    """
    if len(waypoints) < 2:
        raise WaypointError(
            f"{source}: {len(waypoints)} waypoint(s); a lap needs at least 2, add some"
        )
    for waypoint in waypoints:
        if not field.contains(waypoint.x, waypoint.y):
            raise WaypointError(
                f"{source}: waypoint {waypoint.idx} at ({waypoint.x:g}, {waypoint.y:g}) is outside "
                f"the walls at x +-{field.width / 2:g}, y +-{field.height / 2:g}; "
                "move it inside or enlarge field_width, field_height"
            )
    first = waypoints[0]
    if all(math.hypot(w.x - first.x, w.y - first.y) <= 2.0 * touch_distance for w in waypoints):
        raise WaypointError(
            f"{source}: all waypoints are within twice touch_distance ({touch_distance:g} u), "
            "so no lap can be counted; spread them or lower touch_distance"
        )
