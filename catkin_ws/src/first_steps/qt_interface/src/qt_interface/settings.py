"""The parameters of the window, checked; and those of the world, as far as there is one."""

from __future__ import annotations

import math
from typing import NamedTuple


class SettingsError(ValueError):
    """A parameter that cannot be used; the text names it and the mend."""


class Settings(NamedTuple):
    """What config/qt_interface.yaml holds; units are told there."""

    frame_rate: float
    window_width: int
    window_height: int
    trail_points: int
    trail_jump: float
    plain_car_size: float


class WorldSizes(NamedTuple):
    """What the window knows of the world's parameters; None: no world tells it."""

    field_width: float | None
    field_height: float | None
    car_size: float | None
    sensor_range: float | None
    sensor_front_only: bool


def is_length(value):
    """Whether the value is a finite number above 0."""
    return (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and math.isfinite(value)
        and value > 0
    )


def read_settings(parameters):
    """Settings from a dictionary of parameters. Raises SettingsError for a missing, odd or impossible one."""
    for name in Settings._fields:
        if name not in parameters:
            raise SettingsError(
                f"parameter ~{name} is missing: load config/qt_interface.yaml, "
                "as qt_interface.launch does"
            )
        value = parameters[name]
        if not is_length(value):
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number above 0")
    for name in ("window_width", "window_height", "trail_points"):
        if not isinstance(parameters[name], int):
            raise SettingsError(f"parameter ~{name} is {parameters[name]!r}: give a whole number")
    return Settings(**{name: parameters[name] for name in Settings._fields})


def read_world_sizes(parameters):
    """WorldSizes from the world's own parameters; what is missing or odd there is unknown here."""
    lengths = {
        name: parameters.get(name) if is_length(parameters.get(name)) else None
        for name in ("field_width", "field_height", "car_size", "sensor_range")
    }
    return WorldSizes(**lengths, sensor_front_only=parameters.get("sensor_front_only") is True)
