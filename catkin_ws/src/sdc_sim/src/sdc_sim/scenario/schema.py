"""The JSON schema of a scenario file. scenarios/README.md describes the format for people."""

from __future__ import annotations

import dataclasses
import math

from sdc_sim.road.route_generator import ELEMENTS
from sdc_sim.scenario.acceptance_limits import INFRACTIONS, METRICS, STATUSES
from sdc_sim.scenario.traffic import (
    MAX_DISTANCE_M,
    MAX_TIME_S,
    RULES,
    TRAFFIC,
    list_schema,
    mapping_schema,
    number_schema,
    text_schema,
)
from sdc_sim.sensors.settings import CLASSES

_ZONE = mapping_schema(
    {
        "from_m": number_schema(0.0, MAX_DISTANCE_M),
        "to_m": number_schema(0.0, MAX_DISTANCE_M),
        "from_s": number_schema(0.0, MAX_TIME_S),
        "to_s": number_schema(0.0, MAX_TIME_S),
        "offset_m": number_schema(0.0, 1e3),
    },
    rules={
        "oneOf": [{"required": ["from_m", "to_m"]}, {"required": ["from_s", "to_s"]}],
        "description": "a zone with either from_m and to_m, or from_s and to_s",
    },
)
_ZONES = list_schema(_ZONE, "a list of zones, such as '- {from_m: 100, to_m: 200}'")


def _sensor(settings_class: type) -> dict:
    names = [field.name for field in dataclasses.fields(settings_class)]
    return mapping_schema(
        {
            name: _ZONES if name in ("outages", "multipath") else number_schema(0.0, 1e3)
            for name in names
        }
    )


# Options of config/sim.yaml that a scenario may set.
SIM_OPTIONS = {
    "seed": number_schema(0, 2**32 - 1, "integer"),
    "friction": number_schema(0.05, 2.0),
    "side_wind_mps": number_schema(-40.0, 40.0),
    "sensor_latency_s": number_schema(0.0, 2.0),
    "command_latency_s": number_schema(0.0, 2.0),
    "daylight": number_schema(0.0, 1.0),
    "weather": mapping_schema(
        {
            "fog_m": number_schema(0.0, 10_000.0),
            "rain": number_schema(0.0, 1.0),
            "low_sun": {"type": "boolean", "description": "true or false"},
            "worn_lines": number_schema(0.0, 1.0),
        }
    ),
    "unstamped_patience_s": number_schema(0.001, 10.0),
    "odometry_noise": mapping_schema(
        {
            "position_m": number_schema(0.0, 5.0),
            "heading_rad": number_schema(0.0, 1.0),
            "speed_mps": number_schema(0.0, 10.0),
        }
    ),
    "start": mapping_schema(
        {
            "along_m": number_schema(0.0, MAX_DISTANCE_M),
            "left_m": number_schema(-50.0, 50.0),
            "turned_rad": number_schema(-math.pi, math.pi),
        }
    ),
    "truth": {"type": "boolean", "description": "true or false"},
    **{name: _sensor(settings_class) for name, settings_class in CLASSES.items()},
}

_BOUNDS = mapping_schema(
    {name: number_schema(-1e9, 1e9) for name in (*METRICS, "infractions", *INFRACTIONS)}
)
_STOP = mapping_schema(
    {"at_m": number_schema(0.0, MAX_DISTANCE_M), "within_m": number_schema(0.01, 1e3)},
    required=("at_m", "within_m"),
)

_NAME = text_schema(r"^[^\W\d]\w*\Z", "a name of letters, digits and _, not a path")
_ELEMENT = mapping_schema({key: number_schema(*bounds) for key, bounds in ELEMENTS.items()})

SCENARIO = mapping_schema(
    {
        "about": text_schema(r"\S", "a line of text"),
        "route": {
            "if": {"type": "array"},
            "then": list_schema(_ELEMENT, "a list of elements, such as '- straight_m: 50'", 1),
            "else": text_schema(
                r"\S", "the name or path of a route, or a list of straights and bends"
            ),
        },
        "vehicle": _NAME,
        "sensors": _NAME,
        "stack": _NAME,
        "camera": {"type": "boolean", "description": "true or false"},
        "sync": {"type": "boolean", "description": "true or false"},
        **SIM_OPTIONS,
        **TRAFFIC,
        "limits": mapping_schema(
            {
                "status": {"enum": list(STATUSES)},
                "at_most": _BOUNDS,
                "at_least": _BOUNDS,
                "stops": list_schema(_STOP, "a list of stops, such as '- {at_m: 40, within_m: 1}'"),
            }
        ),
    },
    rules=RULES,
)
