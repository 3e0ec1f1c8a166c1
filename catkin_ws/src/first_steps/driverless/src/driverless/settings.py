"""The parameters of the driver, checked."""

from __future__ import annotations

import math
from typing import NamedTuple


class SettingsError(ValueError):
    """A parameter that cannot be used; the text names it and the mend."""


class Settings(NamedTuple):
    """What config/driverless.yaml holds; units are told there."""

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


def read_settings(parameters):
    """Settings from a dictionary of parameters. Raises SettingsError for a missing, odd or impossible one."""
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
            mend = "above 0" if limit == math.inf else f"above 0, at most {limit:.4g}"
            raise SettingsError(f"parameter ~{name} is {value!r}: give a number {mend}")
    patience = settings.search_patience
    if isinstance(patience, bool) or not isinstance(patience, int) or patience < 1:
        raise SettingsError(
            f"parameter ~search_patience is {patience!r}: give a whole number of at least 1"
        )
    if not isinstance(settings.use_map, bool):
        raise SettingsError(f"parameter ~use_map is {settings.use_map!r}: give true or false")
    return settings
