"""Makes a drive of a scenario.

    python3 -m sdc_sim.scenario.runner arguments NAME REPORT [ARG:=VALUE ...]

prints the arguments of all.launch, one a line. Those that are given win, and given options are merged with the scenario's.

    python3 -m sdc_sim.scenario.runner check NAME REPORT

holds the report of the drive against the scenario's limits. Exit status 1, and one line for each thing that is not well.
"""

from __future__ import annotations

import difflib
import os
import sys
from typing import NamedTuple

import rospkg
import yaml

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints
from sdc_sim.road.route_generator import csv_lines, draw
from sdc_sim.scenario.acceptance_limits import read_report, violations
from sdc_sim.scenario.reader import Scenario, load_lights, load_obstacles, load_scenario
from sdc_sim.scenario.yaml_reader import ScenarioError

_ROUTES = {"town": "waypoints.csv"}
_SPACING_M = 1.0


class Packaged(NamedTuple):
    """The folders in which a scenario's names are looked up."""

    scenarios: str
    stacks: str
    vehicles: str
    routes: str

    @staticmethod
    def found() -> Packaged:
        """Those of the installed packages."""
        sim, common = (rospkg.RosPack().get_path(name) for name in ("sdc_sim", "sdc_common"))
        return Packaged(
            *(
                os.path.join(sim, *parts)
                for parts in (("scenarios",), ("scenarios", "stacks"), ("config", "vehicles"))
            ),
            os.path.join(common, "data"),
        )


def find_scenario(name: str, packaged: Packaged) -> str:
    """The path of a scenario: a packaged one by its name, any other by its path. Raises ScenarioError."""
    return (
        name
        if name.endswith(".yaml")
        else _named("scenario", name, packaged.scenarios, ".yaml", "scenario:=NAME")
    )


def launch_arguments(scenario: Scenario, packaged: Packaged, drawn_path: str, given: dict) -> dict:
    """The arguments of all.launch, by name, that make this scenario, with the given ones over them.

    A route that the scenario draws is to be found at `drawn_path`. Raises ScenarioError for names that nothing is packaged under.
    """
    arguments = {"obstacles_path": os.path.abspath(scenario.path)}
    if isinstance(scenario.route, list):
        arguments["waypoints_path"] = drawn_path
    elif scenario.route is not None:
        arguments["waypoints_path"] = _route_path(scenario, packaged)
    if scenario.stack is not None:
        arguments["stack"] = _named(
            "stack", scenario.stack, packaged.stacks, ".launch", scenario.path
        )
    sim = dict(scenario.sim)
    if scenario.vehicle is not None:
        _named("vehicle", scenario.vehicle, packaged.vehicles, ".yaml", scenario.path)
        sim["vehicle"] = scenario.vehicle
    options = {**sim, **_options(given.get("sim_options", "{}"))}
    return {
        **arguments,
        **given,
        "sim_options": yaml.safe_dump(options, default_flow_style=True, width=sys.maxsize).strip(),
    }


def prepare(name: str, report_path: str, given: dict, packaged: Packaged) -> dict:
    """The launch arguments of the scenario with this name or path. A route that it draws is written beside the report; what
    stands on the road is tried. Raises ScenarioError, WaypointError and OSError."""
    scenario = load_scenario(find_scenario(name, packaged))
    drawn_path = os.path.splitext(os.path.abspath(report_path))[0] + ".route.csv"
    arguments = launch_arguments(scenario, packaged, drawn_path, given)
    if arguments.get("waypoints_path") == drawn_path:
        spec = {
            "elements": scenario.route,
            "spacing_m": _SPACING_M,
            "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0},
        }
        os.makedirs(os.path.dirname(drawn_path), exist_ok=True)
        with open(drawn_path, "w", encoding="utf-8") as file:
            file.writelines(csv_lines(draw(spec)))
    route = Route(
        load_waypoints(
            arguments.get("waypoints_path") or os.path.join(packaged.routes, _ROUTES["town"])
        )
    )
    load_obstacles(arguments["obstacles_path"], route)
    load_lights(arguments["obstacles_path"], route)
    along_m = scenario.sim.get("start", {}).get("along_m", 0.0)
    if along_m > route.length_m:
        raise ScenarioError(
            f"{scenario.path}: the start lies {along_m:g} m along a route of {route.length_m:.1f} m; give a place on it"
        )
    return arguments


def _route_path(scenario: Scenario, packaged: Packaged) -> str:
    if scenario.route.endswith(".csv"):
        return os.path.join(
            os.path.dirname(os.path.abspath(scenario.path)), os.path.expanduser(scenario.route)
        )
    if scenario.route not in _ROUTES:
        raise ScenarioError(
            f"{scenario.path}: there is no packaged route '{scenario.route}'; write {' or '.join(_ROUTES)}, the path of a "
            ".csv file from this file's folder, or a list of straights and bends"
        )
    return os.path.join(packaged.routes, _ROUTES[scenario.route])


def _named(what: str, name: str, folder: str, ending: str, place: str) -> str:
    known = sorted(entry[: -len(ending)] for entry in os.listdir(folder) if entry.endswith(ending))
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        raise ScenarioError(
            f"{place}: there is no {what} '{name}'; "
            + (f"did you mean '{close[0]}'? " if close else "")
            + f"The known ones are: {' '.join(known)}"
        )
    return os.path.join(folder, name + ending)


def _options(text: str) -> dict:
    try:
        options = yaml.safe_load(text)
    except yaml.YAMLError:
        options = None
    if not isinstance(options, dict):
        raise ScenarioError(
            f"sim_options:={text}: is no mapping; write it as in sim_options:='{{friction: 0.6, seed: 7}}'"
        )
    return options


def _check(name: str, report_path: str) -> list:
    limits = load_scenario(find_scenario(name, Packaged.found())).limits
    return [
        f"{os.path.abspath(report_path)}: {line}"
        for line in violations(limits, *read_report(report_path))
    ]


def main() -> int:
    """Do what the command line asks for; returns the exit status."""
    task, name, report_path, *given = sys.argv[1:]
    try:
        if task == "check":
            lines = _check(name, report_path)
            print(
                "\n".join(
                    [*lines, f"scenario {name}: {'not kept' if lines else 'all limits are kept'}"]
                )
            )
            return 1 if lines else 0
        arguments = prepare(
            name,
            report_path,
            dict(argument.split(":=", 1) for argument in given if ":=" in argument),
            Packaged.found(),
        )
    except (ScenarioError, WaypointError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(
        "\n".join(
            [f"{key}:={value}" for key, value in arguments.items()]
            + [argument for argument in given if ":=" not in argument]
        )
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
