"""Read and validate the parameters of the world."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Mapping


def is_number(value: Any) -> bool:
    """Return True for a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def is_positive(value: Any) -> bool:
    """Return True for a finite number above 0."""
    return is_number(value) and value > 0


# The parameters of config/world.yaml, which documents their units: a test and a valid value
POSITIVE = (is_positive, "a number above 0")
NUMBER = (is_number, "a number")
RULES = {
    "field_width": POSITIVE,
    "field_height": POSITIVE,
    "car_size": POSITIVE,
    "speed": POSITIVE,
    "rate": POSITIVE,
    "start_x": NUMBER,
    "start_y": NUMBER,
    "start_direction": NUMBER,
    "waypoint_count": (
        lambda value: is_number(value) and isinstance(value, int) and 2 <= value <= 65536,
        "a whole number within 2..65536; a lap needs at least 2 waypoints",
    ),
    "ellipse_width": POSITIVE,
    "ellipse_height": POSITIVE,
    "waypoints_path": (lambda value: isinstance(value, str), "a file's path or ''"),
    "waypoints_period": (
        lambda value: is_positive(value) and value <= 3.0,
        "a number above 0, at most 3",
    ),
    "sensor_range": POSITIVE,
    "sensor_front_only": (lambda value: isinstance(value, bool), "true or false"),
    "touch_distance": POSITIVE,
}


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/world.yaml.

    Args:
        parameters: values by name; other names are ignored

    Raises:
        ValueError: a parameter is missing, has the wrong type or is out of range
    """
    for name, (is_valid, valid) in RULES.items():
        if name not in parameters:
            raise ValueError(
                f"parameter ~{name} is missing: load config/world.yaml, as world.launch does"
            )
        if not is_valid(parameters[name]):
            raise ValueError(f"parameter ~{name} is {parameters[name]!r}: give {valid}")
    settings = SimpleNamespace(**{name: parameters[name] for name in RULES})
    for side, start in (("field_width", "start_x"), ("field_height", "start_y")):
        limit = (parameters[side] - settings.car_size) / 2.0
        if limit <= 0.0:
            raise ValueError(
                f"parameter ~{side} is {parameters[side]:g}: make it larger than the car, "
                f"car_size {settings.car_size:g}"
            )
        if abs(parameters[start]) > limit:
            raise ValueError(
                f"parameter ~{start} is {parameters[start]:g}: the car would be in a wall, "
                f"give -{limit:g}..{limit:g}"
            )
    return settings
