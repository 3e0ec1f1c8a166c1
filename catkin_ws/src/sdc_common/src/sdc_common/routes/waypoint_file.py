"""Read a route from a CSV file of waypoints.

Check a file with: python3 -m sdc_common.routes.waypoint_file FILE
"""

from __future__ import annotations

import math
import os
import re
import sys

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import sharpest_turn

# The published Town03 file ends its lines with "\r\r\n": all carriage returns before a line feed
# belong to one end.
_LINE_END = re.compile(r"\r*\n|\r")
SHORTEST_STEP_M = 1e-3
LARGEST_COORDINATE_M = 1e5
# A car leaves its lane in a sharper turn, measured over 4 m.
_SHARPEST_TURN_RAD = math.radians(100.0)


class WaypointError(ValueError):
    """A waypoint file is wrong; the message names the file, the row, the mistake and the fix."""


def load_waypoints(path: str) -> np.ndarray:
    """Load a CSV file of CARLA coordinates as points in the ROS map frame.

    The first two columns are x and y in metres, y to the right as in CARLA. The file can have
    further columns, one header line, blank lines, comments after `#`, and any kind of line end.

    Args:
        path: the file; `~` is the home folder

    Returns:
        (N, 2) points, N >= 2, y to the left (REP 103) [m]

    Raises:
        WaypointError: the file cannot be read, a value is not a finite number, a coordinate is
            beyond 100 km, a point repeats the one before it, there are fewer than two points, or
            the route turns more sharply than a car can
    """
    path = os.path.expanduser(path)
    return parse_waypoints(_read_text(path), path)


def parse_waypoints(text: str, path: str) -> np.ndarray:
    """Return the points of the text of a waypoint file, see `load_waypoints`.

    Args:
        text: content of the file
        path: name of the file in error messages
    """
    if "<OpenDRIVE" in text[:1000]:
        raise WaypointError(
            f"{path}: the file is a road network (OpenDRIVE), not a route; set waypoints_path to a "
            "CSV file of x,y"
        )
    points: list[tuple[float, float]] = []
    rows: list[int] = []
    header_allowed = True
    for row, line in enumerate(_LINE_END.split(text), start=1):
        fields = [field.strip().strip('"') for field in line.split("#", 1)[0].split(",")]
        if not any(fields):
            continue
        try:
            if header_allowed and not any(map(_is_number, fields)):
                _check_header(fields)
            else:
                point = _point(fields)
                if points and math.dist(point, points[-1]) < SHORTEST_STEP_M:
                    raise ValueError(
                        f"the row repeats the point of row {rows[-1]}; delete one of them"
                    )
                points.append(point)
                rows.append(row)
        except ValueError as error:
            raise WaypointError(f"{path}, row {row}: {error}") from None
        header_allowed = False
    if len(points) < 2:
        raise WaypointError(
            f"{path}: the file has {len(points)} waypoint(s), but a route needs at least 2; "
            "add rows of x,y in metres"
        )
    route = np.array(points)
    turn, index = sharpest_turn(route)
    if turn > _SHARPEST_TURN_RAD:
        raise WaypointError(
            f"{path}, row {rows[index]}: the route turns by {math.degrees(turn):.0f} degrees "
            "within 4 m, sharper than a car can drive; round it with a radius of 4 m, or delete "
            "the rows that lead back"
        )
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


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _check_header(fields: list[str]) -> None:
    names = [name.lower() for name in fields]
    if "x" in names and "y" in names and names[:2] != ["x", "y"]:
        raise ValueError(
            f"the header has x in column {names.index('x') + 1} and y in column "
            f"{names.index('y') + 1}; move them to columns 1 and 2"
        )


def _point(fields: list[str]) -> tuple[float, float]:
    if len(fields) < 2:
        raise ValueError(
            f"the row has one column ({fields[0]!r}), but needs two; write x,y with a comma"
        )
    for name, field in zip("xy", fields):
        if not (_is_number(field) and abs(float(field)) <= LARGEST_COORDINATE_M):
            raise ValueError(
                f"{name} is {field!r}, not a number of metres up to {LARGEST_COORDINATE_M:.0f}; "
                "write it with a decimal point, in a local frame"
            )
    return float(fields[0]), float(fields[1])


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
