"""Read a route from a CSV file of waypoints.

Check a file with: python3 -m sdc_common.routes.waypoint_file FILE
"""

from __future__ import annotations

import csv
import math
import os
import sys

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import sharpest_turn
from sdc_common.routes.csv_columns import Table, check_count, doubt, is_number, read_table

SHORTEST_STEP_M = 1e-3
LARGEST_COORDINATE_M = 1e5
# The coordinates of a shorter route are not in metres.
_SHORTEST_ROUTE_M = 1.0
# A car leaves its lane in a sharper turn, measured over 4 m.
_SHARPEST_TURN_RAD = math.radians(100.0)


class WaypointError(ValueError):
    """A waypoint file is wrong; the message names the file, the row, the mistake and the fix."""


def load_waypoints(path: str) -> np.ndarray:
    """Load a CSV file of CARLA coordinates as points in the ROS map frame.

    x and y are in metres, y to the right as in CARLA: the columns that a header names so, or else
    the first two. The file can have further columns, blank lines, comments after `#`, and any kind
    of line end. Between columns are commas, semicolons, tabs or blanks. `~` is the home folder.

    Returns:
        (N, 2) points, N >= 2, y to the left (REP 103) [m]

    Raises:
        WaypointError: the file cannot be read, its columns x and y are not clear, a value is not a
            finite number, a coordinate is beyond 100 km, a point repeats the one before it, there
            are fewer than two points, or the route turns more sharply than a car can
    """
    path = os.path.expanduser(path)
    return parse_waypoints(_read_text(path), path)


def parse_waypoints(text: str, path: str) -> np.ndarray:
    """Return the points of the text of a file that errors name, see `load_waypoints`."""
    if text.lstrip()[:1] in ("<", "{", "["):
        kind = "a road network (OpenDRIVE)" if "<OpenDRIVE" in text[:1000] else "XML or JSON"
        raise WaypointError(
            f"{path}: the file is {kind}, not a route; set waypoints_path to a CSV file of x,y"
        )
    try:
        table = read_table(text)
        route = np.array([_point(row, fields, table) for row, fields in table.rows])
        _check_route(route, table)
    except (ValueError, csv.Error) as error:
        place = f"{path}, " if str(error).startswith("row ") else f"{path}: "
        raise WaypointError(f"{place}{error}") from None
    route[:, 1] = -route[:, 1]
    return route


def _read_text(path: str) -> str:
    if not path:
        raise WaypointError("waypoints_path is empty; set it to a CSV file of x,y")
    try:
        with open(path, "rb") as file:
            return file.read().decode("utf-8-sig")
    except OSError as error:
        problem = f"the file cannot be read ({error.strerror or error}); "
        problem += "set waypoints_path to a readable CSV file"
    except UnicodeDecodeError as error:
        problem = f"the file is not text (byte {error.start}); save it as CSV in UTF-8"
    raise WaypointError(f"{path}: {problem}")


def _point(row: int, fields: list[str], table: Table) -> tuple[float, float]:
    """Return x and y of a row [m].

    Raises:
        ValueError: they are missing, or the row has other columns; the message starts with the row
    """
    try:
        if len(fields) <= max(table.x, table.y):
            raise ValueError(
                f"the row has one column ({fields[0]!r}), but needs two; write x,y with a comma"
            )
        for name, column in (("x", table.x), ("y", table.y)):
            field = fields[column]
            if not (is_number(field) and abs(float(field)) <= LARGEST_COORDINATE_M):
                raise ValueError(
                    f"{name} is {field!r}, not a number of metres up to "
                    f"{LARGEST_COORDINATE_M:.0f}; write it with a decimal point, in a local frame"
                )
        check_count(fields, table)
    except ValueError as error:
        raise ValueError(f"row {row}: {error}") from None
    return float(fields[table.x]), float(fields[table.y])


def _check_route(route: np.ndarray, table: Table) -> None:
    """Raise ValueError if no car can drive a route (N, 2) [m], or if it is in other columns."""
    if len(route) < 2:
        raise ValueError(
            f"the file has {len(route)} waypoint(s), but a route needs at least 2; "
            "add rows of x,y in metres"
        )
    rows = [row for row, _ in table.rows]
    repeats = np.hypot(*np.diff(route, axis=0).T) < SHORTEST_STEP_M
    turn, index = sharpest_turn(route)
    refused = bool(repeats.any() or turn > _SHARPEST_TURN_RAD)
    if np.ptp(route, axis=0).max() < _SHORTEST_ROUTE_M:
        raise ValueError(
            f"all waypoints are within {_SHORTEST_ROUTE_M:g} m; if x and y are degrees or in other "
            "units, convert them to metres in a local frame"
        )
    if cause := doubt(table, route, refused):
        raise ValueError(f"{cause}; name the columns in the first line, in this way or as x,y,z")
    if repeats.any():
        first = int(np.argmax(repeats))
        raise ValueError(
            f"row {rows[first + 1]}: the row repeats the point of row {rows[first]}; "
            "delete one of them"
        )
    if turn > _SHARPEST_TURN_RAD:
        raise ValueError(
            f"row {rows[index]}: the route turns by {math.degrees(turn):.0f} degrees within 4 m, "
            "sharper than a car can drive; check the order of rows and columns, or round the turn "
            "with a radius of 4 m"
        )


def main() -> int:
    """Check the file that the command line names; return the exit status."""
    try:
        route = load_waypoints(sys.argv[1] if len(sys.argv) > 1 else "")
    except WaypointError as error:
        print(error, file=sys.stderr)
        return 1
    length_m = Polyline(route.tolist()).s[-1]
    print(f"{sys.argv[1]}: {len(route)} waypoints, {length_m:.1f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
