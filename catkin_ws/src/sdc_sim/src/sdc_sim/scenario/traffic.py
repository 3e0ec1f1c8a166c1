"""Read the traffic of a scenario: its obstacles and traffic lights, which the simulator needs."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan
from sdc_sim.physics.traffic_lights import COLOURS, TrafficLightPlan
from sdc_sim.yaml_document import YamlDocument, file_version, load_yaml, validate

# Shorter segments of an obstacle's path have no direction.
_MIN_SEGMENT_M = 1e-3
# The other keys of a scenario. `./drive` and the tools that drive scenarios check their values.
CONDITIONS = (
    *("about", "route", "vehicle", "sensors", "stack", "camera", "sync", "limits"),
    *("seed", "friction", "side_wind_mps", "sensor_latency_s", "command_latency_s", "daylight"),
    *("weather", "unstamped_patience_s", "odometry_noise", "start", "truth"),
    *("imu", "gnss", "speedometer", "lidar", "planar_lidar", "wheel_speeds"),
)
MAX_DISTANCE_M = 1e5
MAX_TIME_S = 1e6


def number_schema(low: float, high: float, kind: str = "number") -> dict:
    """Return the schema of a number within bounds."""
    text = "a whole number" if kind == "integer" else "a number"
    return {
        "type": kind,
        "minimum": low,
        "maximum": high,
        "description": f"{text} from {low:g} to {high:g}",
    }


def text_schema(pattern: str, description: str) -> dict:
    """Return the schema of a text of a pattern."""
    return {"type": "string", "pattern": pattern, "description": description}


def mapping_schema(properties: dict, required: tuple = (), rules: dict | None = None) -> dict:
    """Return the schema of a mapping with these keys."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
        "description": "a mapping with lines of 'key: value'",
        **(rules or {}),
    }


def list_schema(items: dict, description: str, min_items: int = 0, max_items: int = 10**6) -> dict:
    """Return the schema of a list."""
    return {
        "type": "array",
        "items": items,
        "minItems": min_items,
        "maxItems": max_items,
        "description": description,
    }


_POINT = list_schema(
    number_schema(-MAX_DISTANCE_M, MAX_DISTANCE_M), "a list of 2 numbers, such as [1.0, 1.0]", 2, 2
)
_OBSTACLE = mapping_schema(
    {
        "kind": {"enum": list(KINDS)},
        "at": _POINT,
        "yaw_rad": number_schema(-7.0, 7.0),
        "path": list_schema(_POINT, "a list of at least 2 points, such as [[0, 0], [5, 0]]", 2),
        "speed_mps": number_schema(0.01, 60.0),
        "start_s": number_schema(0.0, MAX_TIME_S),
        "trigger_m": number_schema(0.1, MAX_DISTANCE_M),
        "size_m": list_schema(
            number_schema(0.05, 50.0), "a list of 3 numbers, such as [1.0, 1.0, 1.0]", 3, 3
        ),
    },
    required=("kind",),
    rules={
        "dependencies": {
            "yaw_rad": ["at"],
            "path": ["speed_mps"],
            "speed_mps": ["path"],
            "start_s": ["path"],
            "trigger_m": ["path"],
        },
        "allOf": [
            {
                "oneOf": [{"required": ["at"]}, {"required": ["path"]}],
                "description": "an obstacle with either 'at' (parked) or 'path' (moving)",
            },
            {
                "not": {"required": ["start_s", "trigger_m"]},
                "description": "an obstacle with only one of 'start_s' and 'trigger_m'",
            },
        ],
    },
)

_PHASE = mapping_schema(
    {colour: number_schema(0.05, MAX_TIME_S) for colour in COLOURS},
    rules={
        "minProperties": 1,
        "maxProperties": 1,
        "description": "one colour and its duration in seconds, such as 'red: 8.0'",
    },
)
_LIGHT = mapping_schema(
    {
        "stop_line_m": number_schema(0.0, MAX_DISTANCE_M),
        "phases": list_schema(_PHASE, "a list of phases, such as '- red: 8.0'", 1),
        "offset_s": number_schema(-MAX_TIME_S, MAX_TIME_S),
    },
    required=("stop_line_m", "phases"),
)

TRAFFIC = {
    "frame": {"enum": ["map", "route"]},
    "obstacles": list_schema(_OBSTACLE, "a list of obstacles, such as '- kind: car'"),
    "lights": list_schema(_LIGHT, "a list of lights, such as '- stop_line_m: 50'"),
}
RULES = {
    "dependencies": {"obstacles": ["frame"]},
    # A file of obstacles alone needs both keys; a scenario may have a frame without obstacles.
    "if": {"propertyNames": {"enum": ["frame", "obstacles"]}},
    "then": {"required": ["frame", "obstacles"]},
}
_TRAFFIC_AND_CONDITIONS = mapping_schema(
    {**{name: {} for name in CONDITIONS}, **TRAFFIC}, rules=RULES
)


def load_obstacles(path: str, route: Route) -> list[ObstaclePlan]:
    """Read the obstacles of a scenario; return an empty list for an empty path.

    A point is [x, y] with `frame: map`, and [distance along the route, distance to its left] with
    `frame: route`.

    Raises:
        DocumentError: the file is not valid, or a point is not on the route.
    """
    if not path:
        return []
    document = _load(path)
    return [
        _obstacle(document, ("obstacles", index), entry, route)
        for index, entry in enumerate(document.values.get("obstacles", ()))
    ]


def load_lights(path: str, route: Route) -> list[TrafficLightPlan]:
    """Read the traffic lights of a scenario; return an empty list for an empty path.

    Raises:
        DocumentError: the file is not valid, or a stop line is not on the route.
    """
    if not path:
        return []
    document = _load(path)
    plans = []
    for index, entry in enumerate(document.values.get("lights", ())):
        keys = ("lights", index, "stop_line_m")
        x, y, heading = _on_route(document, keys, entry["stop_line_m"], route)
        phases = tuple(item for phase in entry["phases"] for item in phase.items())
        plans.append(TrafficLightPlan(x, y, heading, phases, entry.get("offset_s", 0.0)))
    return plans


def _load(path: str) -> YamlDocument:
    return _read(path, file_version(path))


@lru_cache(maxsize=64)
def _read(path: str, version: tuple[int, ...]) -> YamlDocument:
    document = parse(path, version)
    validate(document, _TRAFFIC_AND_CONDITIONS)
    return document


@lru_cache(maxsize=64)
def parse(path: str, _version: tuple[int, ...]) -> YamlDocument:
    """Return a document that is not validated; to parse it takes some milliseconds.

    Args:
        path: the file
        _version: as of `file_version`: the file is read again when it changes

    Raises:
        DocumentError: the file cannot be read, is not YAML, or is empty
    """
    document = load_yaml(path, "name a readable YAML file (scenario:=, obstacles_path:=)")
    if document.values is None:
        raise document.error(
            (), "the file is empty; add 'frame: map' and 'obstacles:', or a scenario"
        )
    return document


def _obstacle(document: YamlDocument, keys: tuple, entry: dict, route: Route) -> ObstaclePlan:
    length, width, height = entry.get("size_m", KINDS[entry["kind"]][:3])
    size = (length, width, height)
    if "at" in entry:
        point, heading = _place(document, (*keys, "at"), entry["at"], route)
        return ObstaclePlan(entry["kind"], (point,), size, heading + entry.get("yaw_rad", 0.0))
    points: list[tuple[float, float]] = []
    for index, place in enumerate(entry["path"]):
        point, _ = _place(document, (*keys, "path", index), place, route)
        if points and math.dist(points[-1], point) < _MIN_SEGMENT_M:
            raise document.error(
                (*keys, "path", index), "'path' repeats the previous point; remove one of them"
            )
        points.append(point)
    timing = {key: entry[key] for key in ("speed_mps", "start_s", "trigger_m") if key in entry}
    return ObstaclePlan(entry["kind"], tuple(points), size, **timing)


def _place(
    document: YamlDocument, keys: tuple, place: list, route: Route
) -> tuple[tuple[float, float], float]:
    """Return a point (x, y) in the map [m], and the heading that yaw_rad is added to [rad]."""
    first, second = place
    if document.values["frame"] == "map":
        return (first, second), 0.0
    x, y, heading = _on_route(document, keys, first, route)
    return (x - second * math.sin(heading), y + second * math.cos(heading)), heading


def _on_route(
    document: YamlDocument, keys: tuple, along_m: float, route: Route
) -> tuple[float, float, float]:
    """Return x, y [m] and the heading [rad] of the route at a distance along it [m]."""
    if not 0.0 <= along_m <= route.length_m:
        raise document.error(
            keys,
            f"the place is {along_m:g} m along a route of {route.length_m:.1f} m; "
            f"give a distance from 0 to {route.length_m:.1f}",
        )
    x, y, heading = (
        float(np.interp(along_m, route.s, values)) for values in (*route.points.T, route.heading)
    )
    return x, y, heading
