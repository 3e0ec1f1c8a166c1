"""The arguments of ./drive that a page may choose. Each value is checked against a fixed list."""

from __future__ import annotations

import json
from typing import Any, Collection, Mapping

from sdc_common.validation import check_between
from sdc_package.steering.loader import METHODS

# Arguments of ./drive that are true or false.
SWITCHES = ("sync", "camera", "record")
# Options of config/sim.yaml with their ranges.
SIM_OPTIONS = {
    "friction": (0.05, 2.0),
    "side_wind_mps": (-40.0, 40.0),
    "seed": (0, 2**32 - 1),
}
_PLANNED_SPEED_MPS = (0.5, 60.0)


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
    arguments = []
    if scenario:
        arguments.append(f"scenario:={_one_of('scenario', scenario, scenarios)}")
    for name in SWITCHES:
        if name in values:
            arguments.append(f"{name}:={_switch(name, values[name])}")
    if "steering_method" in values:
        method = _one_of("steering_method", values["steering_method"], METHODS)
        arguments.append(f"steering_method:={method}")
    if "planned_speed_mps" in values:
        speed_mps = values["planned_speed_mps"]
        check_between(*_PLANNED_SPEED_MPS, planned_speed_mps=speed_mps)
        arguments.append(f"planned_speed_mps:={speed_mps!r}")
    options = {name: values[name] for name in SIM_OPTIONS if name in values}
    for name, value in options.items():
        check_between(*SIM_OPTIONS[name], **{name: value})
    if "seed" in options and not isinstance(options["seed"], int):
        raise ValueError(f"seed must be a whole number, got {options['seed']!r}")
    if options:
        arguments.append(f"sim_options:={json.dumps(options)}")
    unknown = set(values) - {*SWITCHES, *SIM_OPTIONS, "steering_method", "planned_speed_mps"}
    if unknown:
        raise ValueError(f"a page cannot choose {sorted(unknown)[0][:40]!r}")
    return arguments


def _one_of(name: str, value: Any, known: Collection[str]) -> str:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} must be one of {', '.join(sorted(known))}")
    return value


def _switch(name: str, value: Any) -> str:
    if not isinstance(value, bool):
        raise ValueError(f"{name} must be true or false")
    return str(value).lower()
