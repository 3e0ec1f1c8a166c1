"""Look up what the packages contain: scenarios, routes, vehicles and configurations."""

from __future__ import annotations

import copy
import os
import sys
from typing import Any, Mapping, Sequence

import yaml

from sdc_common.configuration import node_config as node_config  # its old place, for workspaces
from sdc_common.configuration import package_folder
from sdc_common.validation import DocumentError, suggestion
from sdc_sim.road.route_generator import csv_lines, generate_route
from sdc_sim.scenario.reader import Scenario
from sdc_sim.sensors.model import SENSORS
from sdc_sim.yaml_document import packaged_config

# Package, folder and file ending of what a scenario names.
_FOLDERS = {
    "scenario": ("sdc_sim", "scenarios", ".yaml"),
    "vehicle": ("sdc_sim", "config/vehicles", ".yaml"),
    "sensors": ("sdc_sim", "config/sensors", ".yaml"),
    "route": ("sdc_common", "data", ".csv"),
}
_ROUTES = {"town": "waypoints.csv"}


def folder_of(kind: str) -> str:
    """Return the folder of the packaged files of a kind, a key of the table."""
    package, folder, _ = _FOLDERS[kind]
    return os.path.join(package_folder(package), folder)


def overridden(
    parameters: Mapping[str, Any], options: Mapping[str, Any], name: str
) -> dict[str, Any]:
    """Return parameters with some of them replaced; sections are merged.

    Args:
        parameters: all parameters
        options: the parameters to replace
        name: name of the options in error messages, such as sim_options

    Raises:
        DocumentError: an option is no parameter, or a section is given as a value
    """
    result = dict(parameters)
    for key, value in options.items():
        if key not in parameters:
            hint = suggestion(str(key), map(str, parameters), "remove it")
            raise DocumentError(f"{name}: unknown parameter '{key}'; {hint}")
        section = parameters[key]
        if isinstance(section, Mapping):
            if not isinstance(value, Mapping):
                raise DocumentError(
                    f"{name}: '{key}' is a section with the parameters {', '.join(section)}, "
                    f"got {value!r}"
                )
            value = overridden(section, value, f"{name}, section '{key}'")
        result[key] = value
    return result


def find_scenario(name: str) -> str:
    """Return the path of a scenario, given its packaged name or its path.

    Raises:
        DocumentError: no packaged scenario has this name.
    """
    return name if name.endswith(".yaml") else find_packaged("scenario", name, "scenario:=NAME")


def sensor_options(scenario: Scenario) -> dict[str, Any]:
    """Return the parameters of config/sim.yaml that the sensors of a scenario replace.

    Raises:
        DocumentError: the scenario names unknown sensors.
    """
    if scenario.sensors is None:
        return {}
    find_packaged("sensors", scenario.sensors, scenario.path)
    return copy.deepcopy(packaged_config("sensors/" + scenario.sensors))


def options_text(options: Mapping[str, Any]) -> str:
    """Return parameters as an argument of roslaunch: a mapping in one line of YAML."""
    return yaml.safe_dump(dict(options), default_flow_style=True, width=sys.maxsize).strip()


def parse_options(text: str, name: str = "sim_options") -> dict:
    """Return the mapping of an argument.

    Raises:
        DocumentError: it is no mapping
    """
    try:
        options = yaml.safe_load(text)
    except yaml.YAMLError:
        options = None
    if not isinstance(options, dict):
        raise DocumentError(
            f"{name}:={text}: must be a mapping, such as sim_options:='{{friction: 0.6, seed: 7}}'"
        )
    return options


def sim_options(scenario: Scenario, own_options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of config/sim.yaml that a drive of a scenario replaces.

    Args:
        scenario: the scenario
        own_options: parameters that override those of the scenario; of a sensor, single settings

    Raises:
        DocumentError: the scenario names an unknown vehicle.
    """
    options = dict(scenario.sim)
    if scenario.vehicle is not None:
        find_packaged("vehicle", scenario.vehicle, scenario.path)
        options["vehicle"] = scenario.vehicle
    for name, value in own_options.items():
        before = options.get(name)
        if name in SENSORS and isinstance(before, dict) and isinstance(value, dict):
            value = {**before, **value}
        options[name] = value
    return options


def generated_lines(elements: Sequence[Mapping]) -> list[str]:
    """Return the lines of the waypoint file of a list of straights and bends.

    Raises:
        RouteSpecError: the list is no route
    """
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}
    return csv_lines(generate_route({"elements": elements, "spacing_m": 1.0, "start": start}))


def find_route(scenario_path: str, route: str) -> str:
    """Return the path of a waypoint file, given a packaged name or the path in a scenario.

    Raises:
        DocumentError: no packaged route has this name.
    """
    if route.endswith(".csv"):
        folder = os.path.dirname(os.path.abspath(scenario_path))
        return os.path.join(folder, os.path.expanduser(route))
    if route not in _ROUTES:
        raise DocumentError(
            f"{scenario_path}: unknown route '{route}'; use {' or '.join(_ROUTES)}, the path of a "
            ".csv file relative to this file, or a list of straights and bends"
        )
    return os.path.join(folder_of("route"), _ROUTES[route])


def find_packaged(kind: str, name: str, place: str) -> str:
    """Return the path of a packaged file.

    Args:
        kind: scenario, vehicle or sensors
        name: its name without extension
        place: where the name is written, for the error message

    Raises:
        DocumentError: no file has this name.
    """
    folder, extension = folder_of(kind), _FOLDERS[kind][2]
    known = sorted(
        entry[: -len(extension)] for entry in os.listdir(folder) if entry.endswith(extension)
    )
    if name not in known:
        hint = suggestion(name, known, "")
        raise DocumentError(
            f"{place}: unknown {kind} '{name}'; {hint and hint + ' '}"
            f"The known ones are: {' '.join(known)}"
        )
    return os.path.join(folder, name + extension)
