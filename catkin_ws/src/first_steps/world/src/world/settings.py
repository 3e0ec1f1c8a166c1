"""Read and validate the parameters of the world."""

from __future__ import annotations

import math
from typing import Any, Mapping, NamedTuple

POSITIVE = (
    "field_width",
    "field_height",
    "car_size",
    "speed",
    "rate",
    "ellipse_width",
    "ellipse_height",
    "waypoints_period",
    "sensor_range",
    "touch_distance",
)
FINITE = ("start_x", "start_y", "start_direction")


class SettingsError(ValueError):
    """An invalid parameter; the message names the parameter and the fix."""


class Settings(NamedTuple):
    """The parameters of config/world.yaml, which documents their units."""

    field_width: float
    field_height: float
    car_size: float
    speed: float
    rate: float
    start_x: float
    start_y: float
    start_direction: float
    waypoint_count: int
    ellipse_width: float
    ellipse_height: float
    waypoints_path: str
    waypoints_period: float
    sensor_range: float
    sensor_front_only: bool
    touch_distance: float


def read_settings(parameters: Mapping[str, Any]) -> Settings:
    """Return the validated settings.

    Args:
        parameters: values by name, as in config/world.yaml; other names are ignored

    Raises:
        SettingsError: a parameter is missing, has the wrong type or is out of range
    """
    missing = [name for name in Settings._fields if name not in parameters]
    if missing:
        raise SettingsError(
            f"parameter ~{missing[0]} is missing: load config/world.yaml, as world.launch does"
        )
    settings = Settings(**{name: parameters[name] for name in Settings._fields})
    for name in POSITIVE + FINITE:
        _check_number(settings, name)
    count = settings.waypoint_count
    if isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= 65536:
        raise SettingsError(
            f"parameter ~waypoint_count is {count!r}: give a whole number within 2..65536; "
            "a lap needs at least 2 waypoints"
        )
    if not isinstance(settings.sensor_front_only, bool):
        raise SettingsError(
            f"parameter ~sensor_front_only is {settings.sensor_front_only!r}: give true or false"
        )
    if not isinstance(settings.waypoints_path, str):
        raise SettingsError(
            f"parameter ~waypoints_path is {settings.waypoints_path!r}: give a file's path or ''"
        )
    _check_combinations(settings)
    return settings


def _check_number(settings: Settings, name: str) -> None:
    value = getattr(settings, name)
    is_number = (
        isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    )
    if name in POSITIVE and not (is_number and value > 0):
        raise SettingsError(f"parameter ~{name} is {value!r}: give a number above 0")
    if not is_number:
        raise SettingsError(f"parameter ~{name} is {value!r}: give a number")


def _check_combinations(settings: Settings) -> None:
    if settings.waypoints_period > 3.0:
        raise SettingsError(
            f"parameter ~waypoints_period is {settings.waypoints_period:g}: give at most 3 s"
        )
    for side in ("field_width", "field_height"):
        if getattr(settings, side) <= settings.car_size:
            raise SettingsError(
                f"parameter ~{side} is {getattr(settings, side):g}: make it larger than the car, "
                f"car_size {settings.car_size:g}"
            )
    for name, length in (("start_x", settings.field_width), ("start_y", settings.field_height)):
        limit = (length - settings.car_size) / 2.0
        if abs(getattr(settings, name)) > limit:
            raise SettingsError(
                f"parameter ~{name} is {getattr(settings, name):g}: the car would be in a wall, "
                f"give -{limit:g}..{limit:g}"
            )
