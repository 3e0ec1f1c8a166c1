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


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/driverless.yaml.

    Args:
        parameters: values by name; other names are ignored

    Raises:
        ValueError: a parameter is missing, has the wrong type or is out of range
    """
    for name in (*LIMITS, "use_map"):
        if name not in parameters:
            raise ValueError(
                f"parameter ~{name} is missing: load config/driverless.yaml, "
                "as driverless.launch does"
            )
        value, limit = parameters[name], LIMITS.get(name)
        if limit is None:
            is_valid, valid = isinstance(value, bool), "true or false"
        else:
            kind = int if name == "search_patience" else (int, float)
            is_valid = isinstance(value, kind) and not isinstance(value, bool)
            is_valid = is_valid and math.isfinite(value) and 0.0 < value <= limit
            whole = "whole " if kind is int else ""
            valid = f"a {whole}number above 0" + (f", at most {limit:.4g}" if limit < 10 else "")
        if not is_valid:
            raise ValueError(f"parameter ~{name} is {value!r}: give {valid}")
    return SimpleNamespace(**{name: parameters[name] for name in (*LIMITS, "use_map")})
