"""Run scenarios: turn them into launch arguments, drive them and check their limits.

    python3 -m sdc_sim.scenario.runner arguments NAME REPORT [ARG:=VALUE ...]

prints the arguments of all.launch, one per line. Given arguments override those of the scenario,
given `sim_options` are merged with its options.

    python3 -m sdc_sim.scenario.runner check NAME REPORT

prints one line for each limit that the report violates.

The exit status is 1 for errors and for violations.
"""

from __future__ import annotations

import contextlib
import difflib
import os
import signal
import subprocess
import sys
import time
from typing import Callable, Mapping, NamedTuple

import rospkg
import yaml

from sdc_common.geometry.road_line import road_route
from sdc_common.ros.catkin_workspace import (
    WorkspaceError,
    check_stack,
    workspace_environment,
)
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints
from sdc_sim.report.completion import complete_report, is_complete
from sdc_sim.report.writer import EVENT_LOG, companion
from sdc_sim.road.route_generator import csv_lines, generate_route
from sdc_sim.scenario.acceptance_limits import AcceptanceLimits, read_report, violations
from sdc_sim.scenario.reader import Scenario, load_lights, load_obstacles, load_scenario
from sdc_sim.scenario.yaml_document import DocumentError
from sdc_sim.sensors.settings import SENSORS

_ROUTES = {"town": "waypoints.csv"}
_SPACING_M = 1.0
_SHUTDOWN_TIMEOUT_S = 30.0
_LOG_TAIL_LINES = 25


class PackagedFolders(NamedTuple):
    """The folders in which the names of a scenario are looked up."""

    scenarios: str
    stacks: str
    vehicles: str
    routes: str
    sensors: str

    @staticmethod
    def find() -> PackagedFolders:
        """Return the folders of the installed packages."""
        packages = rospkg.RosPack()
        sim, common = packages.get_path("sdc_sim"), packages.get_path("sdc_common")
        return PackagedFolders(
            scenarios=os.path.join(sim, "scenarios"),
            stacks=os.path.join(sim, "scenarios", "stacks"),
            vehicles=os.path.join(sim, "config", "vehicles"),
            routes=os.path.join(common, "data"),
            sensors=os.path.join(sim, "config", "sensors"),
        )


def find_scenario(name: str, folders: PackagedFolders) -> str:
    """Return the path of a scenario, given its packaged name or its path.

    Raises:
        DocumentError: no packaged scenario has this name.
    """
    if name.endswith(".yaml"):
        return name
    return _find_packaged("scenario", name, folders.scenarios, ".yaml", "scenario:=NAME")


def launch_arguments(
    scenario: Scenario, folders: PackagedFolders, generated_path: str, given: Mapping[str, str]
) -> dict[str, str]:
    """Return the arguments of all.launch, by name, for a scenario.

    Args:
        scenario: the scenario
        folders: where to look up its names
        generated_path: the file of the route if the scenario generates one
        given: arguments that override those of the scenario

    Raises:
        DocumentError: a name in the scenario is unknown.
    """
    arguments = {"obstacles_path": os.path.abspath(scenario.path)}
    if isinstance(scenario.route, list):
        arguments["waypoints_path"] = generated_path
    elif scenario.route is not None:
        arguments["waypoints_path"] = _route_path(scenario.path, scenario.route, folders)
    if scenario.stack is not None and not given.get("workspace"):
        arguments["stack"] = _find_packaged(
            "stack", scenario.stack, folders.stacks, ".launch", scenario.path
        )
    if scenario.sensors is not None:
        _find_packaged("sensors", scenario.sensors, folders.sensors, ".yaml", scenario.path)
        arguments["sensors"] = scenario.sensors
    sim = dict(scenario.sim)
    if scenario.vehicle is not None:
        _find_packaged("vehicle", scenario.vehicle, folders.vehicles, ".yaml", scenario.path)
        sim["vehicle"] = scenario.vehicle
    options = {**sim, **_parse_options(given.get("sim_options", "{}"))}
    for name in set(sim) & set(SENSORS):
        if isinstance(options[name], dict):
            options[name] = {**sim[name], **options[name]}
    text = yaml.safe_dump(options, default_flow_style=True, width=sys.maxsize).strip()
    return {**arguments, **given, "sim_options": text}


def prepare(
    scenario: Scenario, report_path: str, given: Mapping[str, str], folders: PackagedFolders
) -> dict[str, str]:
    """Return the launch arguments of a scenario after a check that it can be driven.

    A generated route is written next to the report.

    Raises:
        DocumentError, WaypointError, OSError: the scenario cannot be driven.
    """
    generated_path = os.path.splitext(os.path.abspath(report_path))[0] + ".route.csv"
    arguments = launch_arguments(scenario, folders, generated_path, given)
    if arguments.get("waypoints_path") == generated_path:
        spec = {
            "elements": scenario.route,
            "spacing_m": _SPACING_M,
            "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0},
        }
        os.makedirs(os.path.dirname(generated_path), exist_ok=True)
        with open(generated_path, "w", encoding="utf-8") as file:
            file.writelines(csv_lines(generate_route(spec)))
    default_path = os.path.join(folders.routes, _ROUTES["town"])
    route = road_route(load_waypoints(arguments.get("waypoints_path") or default_path))
    load_obstacles(arguments["obstacles_path"], route)
    load_lights(arguments["obstacles_path"], route)
    along_m = scenario.sim.get("start", {}).get("along_m", 0.0)
    if along_m > route.length_m:
        raise DocumentError(
            f"{scenario.path}: the start is {along_m:g} m along a route of {route.length_m:.1f} m; "
            f"give a distance from 0 to {route.length_m:.1f}"
        )
    return arguments


class CheckedDrive:
    """One headless drive of a scenario, started through all.launch, and the check of its report.

    Args:
        scenario: name or path of the scenario; empty for the route alone
        report_path: where to write the report
        given: arguments of all.launch that override those of the scenario

    Raises:
        DocumentError, WaypointError, WorkspaceError, OSError: the scenario cannot be driven.
    """

    def __init__(self, scenario: str, report_path: str, given: Mapping[str, str]):
        self.report_path = report_path
        self.log_path = os.path.splitext(report_path)[0] + ".log"
        os.makedirs(os.path.dirname(report_path), exist_ok=True)
        check_stack(given.get("workspace", ""), given.get("stack", ""))
        self._environment = None
        if given.get("workspace"):
            self._environment = _world_environment()
        else:
            _check_all_launch()
        self.limits, camera = AcceptanceLimits(), True
        if scenario:
            folders = PackagedFolders.find()
            loaded = load_scenario(find_scenario(scenario, folders))
            self.limits, camera = loaded.limits, loaded.camera
            given = prepare(loaded, report_path, given, folders)
        self.arguments = {
            "sync": "true",
            "camera": str(camera).lower(),
            **given,
            "headless": "true",
            "report": report_path,
        }

    def run(
        self,
        timeout_s: float,
        is_stopped: Callable[[], bool] = lambda: False,
        environment: Mapping[str, str] | None = None,
    ) -> list[str]:
        """Drive until the launch ends, complete the report and check it.

        All nodes have ended on return.

        Args:
            timeout_s: wall time after which the drive is interrupted [s]
            is_stopped: returns True to interrupt the drive earlier
            environment: environment variables of the launch

        Returns:
            one line for each violation, followed by the end of the log; empty if there is none
        """
        for path in (self.report_path, companion(self.report_path, EVENT_LOG)):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        status = self._launch(timeout_s, is_stopped, environment)
        try:
            if not is_complete(self.report_path):
                complete_report(self.report_path)
            lines = violations(self.limits, *read_report(self.report_path))
        except (OSError, ValueError) as error:
            lines = [f"roslaunch ended with status {status} and wrote no report ({error})"]
        return [*lines, self._log_tail()] if lines else []

    def _launch(
        self,
        timeout_s: float,
        is_stopped: Callable[[], bool],
        environment: Mapping[str, str] | None,
    ) -> int | None:
        command = [sys.executable, "-m", "sdc_common.ros.safe_launch", "sdc_package", "all.launch"]
        command += [f"{key}:={value}" for key, value in self.arguments.items()]
        with open(self.log_path, "wb") as log:
            launch = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment or self._environment,
                start_new_session=True,
            )
        deadline = time.monotonic() + timeout_s
        try:
            while launch.poll() is None and time.monotonic() < deadline and not is_stopped():
                time.sleep(0.05)
        finally:
            _terminate(launch)
        return launch.returncode

    def _log_tail(self) -> str:
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            lines = file.read().splitlines()[-_LOG_TAIL_LINES:]
        return "\n".join([f"the last lines of {self.log_path}:", *lines])


def _world_environment() -> dict[str, str] | None:
    """Return the environment of the workspace of this package, without any that overlays it."""
    source = os.path.realpath(rospkg.RosPack().get_path("sdc_sim"))
    try:
        return workspace_environment(os.path.dirname(os.path.dirname(source)))
    except WorkspaceError:
        return None  # Installed outside a workspace.


def _check_all_launch() -> None:
    """Raise WorkspaceError if an overlay's package of the same name hides sdc_package."""
    try:
        folder = rospkg.RosPack().get_path("sdc_package")
    except rospkg.ResourceNotFound:
        return  # roslaunch names the missing package.
    path = os.path.join(folder, "launch", "all.launch")
    text = ""
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            text = file.read()
    if "sdc_sim" not in text:
        raise WorkspaceError(
            f"{folder}: this sdc_package hides the one whose all.launch starts the world; "
            "add workspace:=FOLDER, the workspace that it belongs to"
        )


def _terminate(launch: subprocess.Popen) -> None:
    """End a launch and its nodes. roslaunch ends its nodes in order on SIGINT only."""
    for signal_number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        if launch.poll() is not None:
            return
        os.killpg(launch.pid, signal_number)
        try:
            launch.wait(_SHUTDOWN_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            continue


def _route_path(scenario_path: str, route: str, folders: PackagedFolders) -> str:
    if route.endswith(".csv"):
        folder = os.path.dirname(os.path.abspath(scenario_path))
        return os.path.join(folder, os.path.expanduser(route))
    if route not in _ROUTES:
        raise DocumentError(
            f"{scenario_path}: unknown route '{route}'; use {' or '.join(_ROUTES)}, the path of a "
            ".csv file relative to this file, or a list of straights and bends"
        )
    return os.path.join(folders.routes, _ROUTES[route])


def _find_packaged(kind: str, name: str, folder: str, extension: str, place: str) -> str:
    known = sorted(
        entry[: -len(extension)] for entry in os.listdir(folder) if entry.endswith(extension)
    )
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean '{close[0]}'? " if close else ""
        raise DocumentError(
            f"{place}: unknown {kind} '{name}'; {hint}The known ones are: {' '.join(known)}"
        )
    return os.path.join(folder, name + extension)


def _parse_options(text: str) -> dict:
    try:
        options = yaml.safe_load(text)
    except yaml.YAMLError:
        options = None
    if not isinstance(options, dict):
        raise DocumentError(
            f"sim_options:={text}: must be a mapping, such as "
            "sim_options:='{friction: 0.6, seed: 7}'"
        )
    return options


def _print_check(name: str, scenario: Scenario, report_path: str) -> int:
    lines = violations(scenario.limits, *read_report(report_path))
    for line in lines:
        print(f"{os.path.abspath(report_path)}: {line}")
    print(f"scenario {name}: {'limits violated' if lines else 'all limits are met'}")
    return 1 if lines else 0


def main() -> int:
    """Run the command line and return the exit status."""
    task, name, report_path, *rest = sys.argv[1:]
    given = dict(argument.split(":=", 1) for argument in rest if ":=" in argument)
    options = [argument for argument in rest if ":=" not in argument]
    try:
        folders = PackagedFolders.find()
        scenario = load_scenario(find_scenario(name, folders))
        if task == "check":
            return _print_check(name, scenario, report_path)
        arguments = prepare(scenario, report_path, given, folders)
    except (DocumentError, WaypointError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join([*(f"{key}:={value}" for key, value in arguments.items()), *options]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
