"""Read and validate the parameters of the window, and read the sizes of the world."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Mapping, NamedTuple

# The parameters of config/qt_interface.yaml, which documents their units
NUMBERS = ("frame_rate", "trail_jump", "plain_car_size")
WHOLE_NUMBERS = ("window_width", "window_height", "trail_points")


class SettingsError(ValueError):
    """An invalid parameter; the message names the parameter and the fix."""


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
        SettingsError: a parameter is missing, has the wrong type or is out of range
    """
    settings = SimpleNamespace()
    for name in NUMBERS + WHOLE_NUMBERS:
        if name not in parameters:
            raise SettingsError(
                f"parameter ~{name} is missing: load config/qt_interface.yaml, "
                "as qt_interface.launch does"
            )
        value = parameters[name]
        if not is_positive(value):
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number above 0")
        if name in WHOLE_NUMBERS and not isinstance(value, int):
            raise SettingsError(f"parameter ~{name} is {value!r}: give a whole number")
        setattr(settings, name, value)
    return settings


def read_world_sizes(parameters: Mapping[str, Any]) -> WorldSizes:
    """Return the sizes from the world's parameters; a missing or invalid size is None."""
    names = ("field_width", "field_height", "car_size", "sensor_range")
    sizes = {name: parameters[name] for name in names if is_positive(parameters.get(name))}
    return WorldSizes(**sizes, sensor_front_only=parameters.get("sensor_front_only") is True)
