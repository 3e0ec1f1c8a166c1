"""The points of the route: generated on an ellipse, or loaded from a file."""

from __future__ import annotations

import csv
import math
from typing import NamedTuple, Sequence

from world.car import Field

IDX_MAX = 65535  # um_msgs/Waypoint.idx is a uint16


class Waypoint(NamedTuple):
    """A point of the route at `x`, `y` [u]; sorts by `idx`, its number in the order of visits."""

    idx: int
    x: float
    y: float


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
        ValueError: the file is not readable or a row is not a point
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = enumerate(csv.reader(file), start=1)
            rows = [(line, row) for line, row in lines if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ValueError(
            f"waypoints_path {path}: {error}; give a readable CSV file of x,y"
        ) from error
    columns = ["x", "y"]
    if rows and rows[0][1][0].strip()[:1].isalpha():
        columns = [cell.strip().lower() for cell in rows.pop(0)[1]]
        if not {"x", "y"} <= set(columns):
            raise ValueError(
                f"{path}: row 1: the header {','.join(columns)} lacks x or y; call the columns x,y"
            )
    waypoints = []
    for line, row in rows:
        cells = dict(zip(columns, row))
        try:
            waypoint = Waypoint(
                int(cells.get("idx", len(waypoints))), float(cells["x"]), float(cells["y"])
            )
        except (KeyError, ValueError):
            waypoint = Waypoint(-1, math.nan, math.nan)
        if not (math.isfinite(waypoint.x + waypoint.y) and 0 <= waypoint.idx <= IDX_MAX):
            raise ValueError(
                f"{path}: row {line}: '{','.join(row)}' is not a point; "
                f"write x,y in plain numbers, and idx, if given, within 0..{IDX_MAX}"
            )
        waypoints.append(waypoint)
    return waypoints


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
        ValueError: fewer than 2 points, a point outside the walls, or all points close together
    """
    if len(waypoints) < 2:
        raise ValueError(
            f"{source}: {len(waypoints)} waypoint(s); a lap needs at least 2, add some"
        )
    for waypoint in waypoints:
        if not field.contains(waypoint.x, waypoint.y):
            raise ValueError(
                f"{source}: waypoint {waypoint.idx} at ({waypoint.x:g}, {waypoint.y:g}) is outside "
                f"the walls at x +-{field.width / 2:g}, y +-{field.height / 2:g}; "
                "move it inside or enlarge field_width, field_height"
            )
    first = waypoints[0]
    if all(math.hypot(w.x - first.x, w.y - first.y) <= 2.0 * touch_distance for w in waypoints):
        raise ValueError(
            f"{source}: all waypoints are within twice touch_distance ({touch_distance:g} u), "
            "so no lap can be counted; spread them or lower touch_distance"
        )
