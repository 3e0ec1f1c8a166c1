"""Read and validate the parameters of the driver."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Mapping

# Largest values of the numbers in config/driverless.yaml, which documents their units
LIMITS = {
    "reach_distance": math.inf,
    "turn_gain": 1.0,
    "max_turn": math.pi,
    "search_patience": math.inf,
    "search_turn": math.pi,
}


class SettingsError(ValueError):
    """An invalid parameter; the message names the parameter and the fix."""


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/driverless.yaml.

    Args:
        parameters: values by name; other names are ignored

    Raises:
        SettingsError: a parameter is missing, has the wrong type or is out of range
    """
    settings = SimpleNamespace()
    for name in (*LIMITS, "use_map"):
        if name not in parameters:
            raise SettingsError(
                f"parameter ~{name} is missing: load config/driverless.yaml, "
                "as driverless.launch does"
            )
        setattr(settings, name, parameters[name])
    for name, limit in LIMITS.items():
        value = parameters[name]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not (is_number and math.isfinite(value) and 0.0 < value <= limit):
            valid = "above 0" if limit == math.inf else f"above 0, at most {limit:.4g}"
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number {valid}")
    if not isinstance(settings.search_patience, int):
        raise SettingsError(
            f"parameter ~search_patience is {settings.search_patience!r}: give a whole number"
        )
    if not isinstance(settings.use_map, bool):
        raise SettingsError(f"parameter ~use_map is {settings.use_map!r}: give true or false")
    return settings
