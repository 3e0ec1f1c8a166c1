"""Read and validate the parameters of the driver."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Mapping

import rospkg
import yaml
from jsonschema import Draft4Validator


def read_settings(parameters: Mapping[str, Any]) -> SimpleNamespace:
    """Return the validated settings, one attribute for each parameter of config/driverless.yaml.

    Args:
        parameters: values by name; other names are ignored

    Raises:
        ValueError: a parameter is missing, or config/rules.yaml refuses its value
    """
    folder = Path(rospkg.RosPack().get_path("driverless"))
    rules = yaml.safe_load((folder / "config" / "rules.yaml").read_text(encoding="utf-8"))
    for name, rule in rules.items():
        if name not in parameters:
            raise ValueError(
                f"parameter ~{name} is missing: load config/driverless.yaml, "
                "as driverless.launch does"
            )
        value = parameters[name]
        is_finite = not isinstance(value, float) or math.isfinite(value)
        if not (is_finite and Draft4Validator(rule).is_valid(value)):
            raise ValueError(f"parameter ~{name} is {value!r}: give {rule['description']}")
    return SimpleNamespace(**{name: parameters[name] for name in rules})
