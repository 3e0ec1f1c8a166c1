"""Read and validate the parameters of the window, and read the sizes of the world."""

from __future__ import annotations

import math
from typing import Any, Mapping, NamedTuple


class SettingsError(ValueError):
    """An invalid parameter; the message names the parameter and the fix."""


class Settings(NamedTuple):
    """The parameters of config/qt_interface.yaml, which documents their units."""

    frame_rate: float
    window_width: int
    window_height: int
    trail_points: int
    trail_jump: float
    plain_car_size: float


class WorldSizes(NamedTuple):
    """The parameters of the world that the window uses [u]; None if the world does not set one."""

    field_width: float | None
    field_height: float | None
    car_size: float | None
    sensor_range: float | None
    sensor_front_only: bool


def is_positive(value: object) -> bool:
    """Return True if the value is a finite number above 0."""
    return (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and math.isfinite(value)
        and value > 0
    )


def read_settings(parameters: Mapping[str, Any]) -> Settings:
    """Return the validated settings.

    Args:
        parameters: values by name, as in config/qt_interface.yaml; other names are ignored

    Raises:
        SettingsError: a parameter is missing, has the wrong type or is out of range
    """
    for name in Settings._fields:
        if name not in parameters:
            raise SettingsError(
                f"parameter ~{name} is missing: load config/qt_interface.yaml, "
                "as qt_interface.launch does"
            )
        value = parameters[name]
        if not is_positive(value):
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number above 0")
    for name in ("window_width", "window_height", "trail_points"):
        if not isinstance(parameters[name], int):
            raise SettingsError(f"parameter ~{name} is {parameters[name]!r}: give a whole number")
    return Settings(**{name: parameters[name] for name in Settings._fields})


def read_world_sizes(parameters: Mapping[str, Any]) -> WorldSizes:
    """Return the sizes from the world's parameters; a missing or invalid size is None."""
    lengths = {
        name: parameters.get(name) if is_positive(parameters.get(name)) else None
        for name in ("field_width", "field_height", "car_size", "sensor_range")
    }
    return WorldSizes(**lengths, sensor_front_only=parameters.get("sensor_front_only") is True)
