"""Read and validate the parameters of the world."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Mapping

from world.rules import checked


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the settings of `world.rules.checked`.

    Raises:
        ValueError: they refuse a parameter, or the car has no room or starts in a wall
    """
    settings = checked("world", parameters)
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
