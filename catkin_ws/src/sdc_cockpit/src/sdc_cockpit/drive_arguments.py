"""The arguments of ./drive that a page may choose; config/page.yaml has what each value may be."""

from __future__ import annotations

import json
from typing import Any, Collection, Mapping

from sdc_cockpit.protocol import check_fields, page_schemas
from sdc_package.steering.loader import METHODS

_SIM_OPTIONS = ("friction", "side_wind_mps", "seed")


def drive_arguments(
    scenario: str, values: Mapping[str, Any], scenarios: Collection[str]
) -> list[str]:
    """Return the arguments of ./drive.

    Args:
        scenario: a name of `scenarios`, or empty for the packaged route
        values: the chosen values by name; names that are absent keep their default
        scenarios: the packaged scenarios

    Raises:
        ValueError: a name is unknown or a value is not allowed
    """
    chosen: dict[str, Any] = {**({"scenario": scenario} if scenario else {}), **values}
    fields = {
        "scenario": {"enum": sorted(scenarios)},
        **page_schemas()["drive"],
        "steering_method": {"enum": sorted(METHODS)},
    }
    check_fields("arguments", chosen, fields, ())
    options = {name: chosen.pop(name) for name in _SIM_OPTIONS if name in chosen}
    if options:
        chosen["sim_options"] = options
    return [
        f"{name}:={value if isinstance(value, str) else json.dumps(value)}"
        for name in [*fields, "sim_options"]
        if name in chosen
        for value in [chosen[name]]
    ]
