"""Read and validate the parameters of the driver."""

from __future__ import annotations

import math
from typing import Any, Mapping, NamedTuple


class SettingsError(ValueError):
    """An invalid parameter; the message names the parameter and the fix."""


class Settings(NamedTuple):
    """The parameters of config/driverless.yaml, which documents their units."""

    reach_distance: float
    turn_gain: float
    max_turn: float
    use_map: bool
    search_patience: int
    search_turn: float


UPPER_LIMITS = {
    "reach_distance": math.inf,
    "turn_gain": 1.0,
    "max_turn": math.pi,
    "search_turn": math.pi,
}


def read_settings(parameters: Mapping[str, Any]) -> Settings:
    """Return the validated settings.

    Args:
        parameters: values by name, as in config/driverless.yaml; other names are ignored

    Raises:
        SettingsError: a parameter is missing, has the wrong type or is out of range
    """
    missing = [name for name in Settings._fields if name not in parameters]
    if missing:
        raise SettingsError(
            f"parameter ~{missing[0]} is missing: load config/driverless.yaml, "
            "as driverless.launch does"
        )
    settings = Settings(**{name: parameters[name] for name in Settings._fields})
    for name, limit in UPPER_LIMITS.items():
        value = getattr(settings, name)
        is_number = (
            isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        )
        if not is_number or not 0.0 < value <= limit:
            valid = "above 0" if limit == math.inf else f"above 0, at most {limit:.4g}"
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number {valid}")
    steps = settings.search_patience
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise SettingsError(
            f"parameter ~search_patience is {steps!r}: give a whole number of at least 1"
        )
    if not isinstance(settings.use_map, bool):
        raise SettingsError(f"parameter ~use_map is {settings.use_map!r}: give true or false")
    return settings
