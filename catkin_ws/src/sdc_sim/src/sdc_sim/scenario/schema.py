"""The JSON schema of a scenario file. scenarios/README.md describes the format for people."""

from __future__ import annotations

import dataclasses
import math

from sdc_sim.physics.obstacles import KINDS
from sdc_sim.physics.traffic_lights import COLOURS
from sdc_sim.road.route_generator import ELEMENTS
from sdc_sim.scenario.acceptance_limits import INFRACTIONS, METRICS, STATUSES
from sdc_sim.sensors.settings import CLASSES

_MAX_DISTANCE_M = 1e5
_MAX_TIME_S = 1e6


def _number(low: float, high: float, kind: str = "number") -> dict:
    text = "a whole number" if kind == "integer" else "a number"
    return {
        "type": kind,
        "minimum": low,
        "maximum": high,
        "description": f"{text} from {low:g} to {high:g}",
    }


def _text(pattern: str, description: str) -> dict:
    return {"type": "string", "pattern": pattern, "description": description}


def _mapping(properties: dict, required: tuple = (), rules: dict | None = None) -> dict:
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
        "description": "a mapping with lines of 'key: value'",
        **(rules or {}),
    }


def _list(items: dict, description: str, min_items: int = 0, max_items: int = 10**6) -> dict:
    return {
        "type": "array",
        "items": items,
        "minItems": min_items,
        "maxItems": max_items,
        "description": description,
    }


_ZONE = _mapping(
    {
        "from_m": _number(0.0, _MAX_DISTANCE_M),
        "to_m": _number(0.0, _MAX_DISTANCE_M),
        "from_s": _number(0.0, _MAX_TIME_S),
        "to_s": _number(0.0, _MAX_TIME_S),
        "offset_m": _number(0.0, 1e3),
    },
    rules={
        "oneOf": [{"required": ["from_m", "to_m"]}, {"required": ["from_s", "to_s"]}],
        "description": "a zone with either from_m and to_m, or from_s and to_s",
    },
)
_ZONES = _list(_ZONE, "a list of zones, such as '- {from_m: 100, to_m: 200}'")


def _sensor(settings_class: type) -> dict:
    names = [field.name for field in dataclasses.fields(settings_class)]
    return _mapping(
        {name: _ZONES if name in ("outages", "multipath") else _number(0.0, 1e3) for name in names}
    )


# Options of config/sim.yaml that a scenario may set.
SIM_OPTIONS = {
    "seed": _number(0, 2**32 - 1, "integer"),
    "friction": _number(0.05, 2.0),
    "side_wind_mps": _number(-40.0, 40.0),
    "sensor_latency_s": _number(0.0, 2.0),
    "command_latency_s": _number(0.0, 2.0),
    "daylight": _number(0.0, 1.0),
    "weather": _mapping(
        {
            "fog_m": _number(0.0, 10_000.0),
            "rain": _number(0.0, 1.0),
            "low_sun": {"type": "boolean", "description": "true or false"},
            "worn_lines": _number(0.0, 1.0),
        }
    ),
    "unstamped_patience_s": _number(0.001, 10.0),
    "odometry_noise": _mapping(
        {
            "position_m": _number(0.0, 5.0),
            "heading_rad": _number(0.0, 1.0),
            "speed_mps": _number(0.0, 10.0),
        }
    ),
    "start": _mapping(
        {
            "along_m": _number(0.0, _MAX_DISTANCE_M),
            "left_m": _number(-50.0, 50.0),
            "turned_rad": _number(-math.pi, math.pi),
        }
    ),
    "truth": {"type": "boolean", "description": "true or false"},
    **{name: _sensor(settings_class) for name, settings_class in CLASSES.items()},
}

_POINT = _list(
    _number(-_MAX_DISTANCE_M, _MAX_DISTANCE_M), "a list of 2 numbers, such as [1.0, 1.0]", 2, 2
)
_OBSTACLE = _mapping(
    {
        "kind": {"enum": list(KINDS)},
        "at": _POINT,
        "yaw_rad": _number(-7.0, 7.0),
        "path": _list(_POINT, "a list of at least 2 points, such as [[0, 0], [5, 0]]", 2),
        "speed_mps": _number(0.01, 60.0),
        "start_s": _number(0.0, _MAX_TIME_S),
        "trigger_m": _number(0.1, _MAX_DISTANCE_M),
        "size_m": _list(_number(0.05, 50.0), "a list of 3 numbers, such as [1.0, 1.0, 1.0]", 3, 3),
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

_PHASE = _mapping(
    {colour: _number(0.05, _MAX_TIME_S) for colour in COLOURS},
    rules={
        "minProperties": 1,
        "maxProperties": 1,
        "description": "one colour and its duration in seconds, such as 'red: 8.0'",
    },
)
_LIGHT = _mapping(
    {
        "stop_line_m": _number(0.0, _MAX_DISTANCE_M),
        "phases": _list(_PHASE, "a list of phases, such as '- red: 8.0'", 1),
        "offset_s": _number(-_MAX_TIME_S, _MAX_TIME_S),
    },
    required=("stop_line_m", "phases"),
)

_BOUNDS = _mapping({name: _number(-1e9, 1e9) for name in (*METRICS, "infractions", *INFRACTIONS)})
_STOP = _mapping(
    {"at_m": _number(0.0, _MAX_DISTANCE_M), "within_m": _number(0.01, 1e3)},
    required=("at_m", "within_m"),
)

_NAME = _text(r"^[^\W\d]\w*\Z", "a name of letters, digits and _, not a path")
_ELEMENT = _mapping({key: _number(*bounds) for key, bounds in ELEMENTS.items()})

SCENARIO = _mapping(
    {
        "about": _text(r"\S", "a line of text"),
        "route": {
            "if": {"type": "array"},
            "then": _list(_ELEMENT, "a list of elements, such as '- straight_m: 50'", 1),
            "else": _text(r"\S", "the name or path of a route, or a list of straights and bends"),
        },
        "vehicle": _NAME,
        "sensors": _NAME,
        "stack": _NAME,
        "camera": {"type": "boolean", "description": "true or false"},
        "sync": {"type": "boolean", "description": "true or false"},
        **SIM_OPTIONS,
        "frame": {"enum": ["map", "route"]},
        "obstacles": _list(_OBSTACLE, "a list of obstacles, such as '- kind: car'"),
        "lights": _list(_LIGHT, "a list of lights, such as '- stop_line_m: 50'"),
        "limits": _mapping(
            {
                "status": {"enum": list(STATUSES)},
                "at_most": _BOUNDS,
                "at_least": _BOUNDS,
                "stops": _list(_STOP, "a list of stops, such as '- {at_m: 40, within_m: 1}'"),
            }
        ),
    },
    rules={
        "dependencies": {"obstacles": ["frame"]},
        # A file of obstacles alone needs both keys; a scenario may have a frame without obstacles.
        "if": {"propertyNames": {"enum": ["frame", "obstacles"]}},
        "then": {"required": ["frame", "obstacles"]},
    },
)
