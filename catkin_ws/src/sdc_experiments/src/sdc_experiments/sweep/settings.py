"""The settings of a study: arguments of a drive and parameters of its nodes."""

from __future__ import annotations

import functools
import os
import re
from typing import Any, Iterable, Mapping

import yaml

from sdc_common.configuration import node_config, package_folder
from sdc_common.validation import is_number, suggestion
from sdc_sim.scenario.packaged import overridden

IN_PROCESS, ROS = "in_process", "ros"
CONTROLLER = "simple_controller"
# The parameters that a study can set, by the first part of their names.
_CONFIGURATIONS = {
    "sim_options": ("sdc_sim", "sim"),
    "planner_options": ("sdc_package", "local_planner"),
    CONTROLLER: ("sdc_package", CONTROLLER),
    "referee_options": ("sdc_sim", "referee"),
}
# Without ROS there are no processes and windows: only these arguments of all.launch have a meaning.
_IN_PROCESS_ARGUMENTS = ("waypoints_path", "planned_speed_mps", "steering_method")
# Arguments that the sweep sets, or that make no sense in a drive that no person watches.
_FIXED_ARGUMENTS = (
    *("sim", "headless", "rviz", "cockpit", "cockpit_port", "cockpit_address"),
    *("report", "record", "obstacles_path"),
)
_PATHS = ("waypoints_path", "workspace", "stack")
_ARGUMENT = re.compile(r'<arg name="([^"]*)" default=')
_KINDS = {bool: "true or false", str: "a text", list: "a list"}


def checked(name: str, value: Any, stack: str, folder: str) -> Any:
    """Check the name and the type of a setting; return its value, with a path made absolute.

    Args:
        name: argument of all.launch, or a parameter such as simple_controller/stanley/k
        value: its value
        stack: IN_PROCESS or ROS
        folder: paths are relative to it

    Raises:
        ValueError: there is no such setting, its value has a wrong type, or a path does not exist;
            the message is one line
    """
    if name == "scenario" or name.startswith("sim_options/seed"):
        raise ValueError(f"'{name}' is no setting; write '{name.split('/')[-1]}s: [...]'")
    first, *keys = name.split("/")
    if first in _CONFIGURATIONS:
        if not keys and not isinstance(value, dict):
            raise ValueError(f"'{name}' must be a mapping, got {text(value)[:40]}")
        present, changes = node_config(*_CONFIGURATIONS[first]), nested({name: value}, first)
        overridden(present, changes, first)
        _check_types(first, present, changes)
        return value
    known = _arguments() if stack == ROS else _IN_PROCESS_ARGUMENTS
    if name not in known:
        if name in _arguments():
            raise ValueError(f"'{name}' needs nodes; add 'stack: ros' or remove it")
        fix = suggestion(name, known, f"use one of {', '.join(known)}")
        raise ValueError(f"unknown setting '{name}'; {fix}")
    if isinstance(value, (dict, list)) or value is None:
        raise ValueError(f"'{name}' must be one word or one number")
    if name not in _PATHS or not isinstance(value, str) or not value:
        return value
    path = os.path.normpath(os.path.join(folder, os.path.expanduser(value)))
    if os.path.exists(path):
        return path
    if name != "stack":  # it can be the name of a launch file in the workspace
        raise ValueError(f"'{name}': {path} does not exist; correct the path")
    return value


def check_together(names: Iterable[str]) -> None:
    """Raise ValueError if two settings exclude each other."""
    names = list(names)
    own = [name for name in names if name.split("/")[0] in ("planner_options", CONTROLLER)]
    other = [name for name in names if name in ("workspace", "stack")]
    if own and other:
        raise ValueError(
            f"'{own[0]}' is a parameter of this project's stack, and '{other[0]}' starts another "
            "one; remove one of them"
        )
    for name in names:
        if any(name != longer and longer.startswith(name + "/") for longer in names):
            raise ValueError(f"'{name}' contains another setting; name each key of it alone")


def nested(settings: Mapping[str, Any], first: str) -> dict:
    """Return the parameters whose names begin with `first`, as a mapping of mappings."""
    found: dict = {}
    for name, value in settings.items():
        head, *keys = name.split("/")
        if head == first:
            place = found
            for key in keys[:-1]:
                place = place.setdefault(key, {})
            place.update({keys[-1]: value} if keys else value)
    return found


def text(value: Any) -> str:
    """Return a value as an argument of roslaunch, and as people read it in a table."""
    if isinstance(value, str):
        return value
    if isinstance(value, float):
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    shown = yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
    return shown[: -len("\n...")] if shown.endswith("\n...") else shown


@functools.lru_cache(maxsize=None)
def _arguments() -> tuple[str, ...]:
    """Return the arguments of all.launch that a study can set."""
    path = os.path.join(package_folder("sdc_package"), "launch", "all.launch")
    with open(path, encoding="utf-8") as file:
        names = _ARGUMENT.findall(file.read())
    return tuple(name for name in names if name not in _FIXED_ARGUMENTS)


def _check_types(name: str, present: Any, value: Any) -> None:
    """Raise ValueError unless a value has the type of the present one."""
    if isinstance(present, dict):
        for key, entry in value.items():
            _check_types(f"{name}/{key}", present[key], entry)
        return
    if is_number(present):
        good, wanted = is_number(value), "a number"
    else:
        kind = next(kind for kind in _KINDS if isinstance(present, kind))
        good, wanted = isinstance(value, kind), _KINDS[kind]
    # The parameter of some texts may also be true or false: ackermann_cmd.
    if not good and not (isinstance(present, str) and isinstance(value, bool)):
        raise ValueError(f"'{name}' must be {wanted}, got {text(value)[:40]}")
