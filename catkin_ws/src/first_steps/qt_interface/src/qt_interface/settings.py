"""Read and validate the parameters of the window, and read the sizes of the world."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Mapping, NamedTuple

# The parameters of config/qt_interface.yaml, which documents their units, with their types
TYPES: dict[str, Any] = {
    "frame_rate": (int, float),
    "trail_jump": (int, float),
    "plain_car_size": (int, float),
    "window_width": int,
    "window_height": int,
    "trail_points": int,
}


class WorldSizes(NamedTuple):
    """The parameters of the world that the window uses [u]; None if the world does not set one."""

    field_width: float | None = None
    field_height: float | None = None
    car_size: float | None = None
    sensor_range: float | None = None
    sensor_front_only: bool = False


def is_positive(value: object) -> bool:
    """Return True if the value is a finite number above 0."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_number and math.isfinite(value) and value > 0


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/qt_interface.yaml.

    Args:
        parameters: values by name; other names are ignored

    Raises:
        ValueError: a parameter is missing, has the wrong type or is out of range
    """
    for name, kind in TYPES.items():
        if name not in parameters:
            raise ValueError(
                f"parameter ~{name} is missing: load config/qt_interface.yaml, "
                "as qt_interface.launch does"
            )
        value = parameters[name]
        if not (is_positive(value) and isinstance(value, kind)):
            valid = "a whole number above 0" if kind is int else "a number above 0"
            raise ValueError(f"parameter ~{name} is {value!r}: give {valid}")
    return SimpleNamespace(**{name: parameters[name] for name in TYPES})


def read_world_sizes(parameters: Mapping[str, Any]) -> WorldSizes:
    """Return the sizes from the world's parameters; a missing or invalid size is None."""
    names = ("field_width", "field_height", "car_size", "sensor_range")
    sizes = {name: parameters[name] for name in names if is_positive(parameters.get(name))}
    return WorldSizes(**sizes, sensor_front_only=parameters.get("sensor_front_only") is True)
