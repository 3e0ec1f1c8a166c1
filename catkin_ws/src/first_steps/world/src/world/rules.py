"""Validate the parameters of a node by the rules in its package."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Mapping

import rospkg
import yaml
from jsonschema import Draft4Validator


def checked(package: str, parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/PACKAGE.yaml.

    Args:
        package: the package, whose config/rules.yaml has a JSON schema for each parameter
        parameters: values by name; other names are ignored

    Raises:
        ValueError: a parameter is missing, or the rules refuse its value
    """
    folder = Path(rospkg.RosPack().get_path(package))
    rules = yaml.safe_load((folder / "config" / "rules.yaml").read_text(encoding="utf-8"))
    for name, rule in rules.items():
        if name not in parameters:
            raise ValueError(
                f"parameter ~{name} is missing: load config/{package}.yaml, "
                f"as {package}.launch does"
            )
        value = parameters[name]
        is_finite = not isinstance(value, float) or math.isfinite(value)
        if not (is_finite and Draft4Validator(rule).is_valid(value)):
            raise ValueError(f"parameter ~{name} is {value!r}: give {rule['description']}")
    return SimpleNamespace(**{name: parameters[name] for name in rules})


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the settings of the world, see `checked`.

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
