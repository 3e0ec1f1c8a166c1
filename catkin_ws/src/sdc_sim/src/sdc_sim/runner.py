"""Run scenarios: turn them into launch arguments, drive them and check their limits.

    python3 -m sdc_sim.runner arguments NAME REPORT [ARG:=VALUE ...]

prints the arguments of all.launch, one per line. Given arguments override those of the scenario,
given `sim_options` are merged with its options. On a map, the first mission is written beside the
report; what is in the file of a map is printed to the standard error. Without a scenario NAME is
empty.

    python3 -m sdc_sim.runner check NAME REPORT

prints one line for each limit that the report violates.

The exit status is 1 for errors and for violations.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from typing import Callable, Iterator, Mapping

import numpy as np

from sdc_common.configuration import package_folder
from sdc_common.processes import isolated_ros_environment
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_common.validation import DocumentError
from sdc_map.map_report import report_lines
from sdc_map.network_file import load_network
from sdc_sim.catkin_workspace import WorkspaceError, check_stack, workspace_environment
from sdc_sim.report.writer import EVENTS, companion, complete_report, is_complete
from sdc_sim.scenario.acceptance_limits import read_report, violations
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.scenario.map_drive import given_points
from sdc_sim.scenario.packaged import (
    find_route,
    find_scenario,
    options_text,
    parse_options,
    sim_options,
)
from sdc_sim.scenario.reader import Scenario, load_scenario
from sdc_sim.scenario.traffic import load_traffic

_SHUTDOWN_TIMEOUT_S = 30.0
_LOG_TAIL_LINES = 25
# Wall time between two looks at a drive that is watched.
_WATCH_PERIOD_S = 0.25
# A node that does not end by itself is killed after this time.
_LEFT_BEHIND_S = 10.0
# Environment variables of the ROS master of a drive.
_NETWORK = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOME")


def launch_arguments(name: str, report: str, arguments: Mapping[str, str]) -> dict[str, str]:
    """Return the arguments of all.launch for a drive, after a check that it can be driven.

    A generated route, or the first mission on a map, is written beside the report.

    Args:
        name: name or path of the scenario, "" without one
        report: path of report.json
        arguments: arguments that override those of the scenario

    Raises:
        ValueError, OSError: the drive cannot start, or a goal cannot be reached
    """
    options = _given_options(arguments)
    if not (name or arguments.get("map")):
        return {**arguments, "sim_options": options_text(options)}
    scenario = load_scenario(find_scenario(name)) if name else Scenario("")
    route_path = arguments.get("waypoints_path")
    route = load_waypoints(route_path) if route_path else None
    start, goals = (given_points(word, arguments) for word in ("start", "goal"))
    place = arguments.get("map", ""), start[0] if start else None, goals or None
    setup = drive_setup(name, route, options, *place)
    own = {"obstacles_path": os.path.abspath(scenario.path)} if name else {}
    of_map: dict[str, str] = {}
    if isinstance(scenario.route, str):
        own["waypoints_path"] = find_route(scenario.path, scenario.route)
    if scenario.sensors is not None:
        own["sensors"] = scenario.sensors
    if setup.missions or (route is None and isinstance(scenario.route, list)):
        path = os.path.splitext(os.path.abspath(report))[0] + ".route.csv"
        os.makedirs(os.path.dirname(path), exist_ok=True)
        # The y axis of a waypoint file points to the right.
        np.savetxt(path, setup.waypoints_m * (1.0, -1.0), fmt="%.6f", delimiter=",")
        own["waypoints_path"] = path
    if setup.missions:
        goals_text = str([list(map(float, goal)) for goal in setup.missions.goals])
        of_map = {"map": setup.parameters["map_path"], "goal": goals_text}
        of_map["waypoints_path"] = own["waypoints_path"]
    own.update(arguments)
    load_traffic(own.get("obstacles_path", ""), setup.route, setup.parameters["map_path"])
    along_m, length_m = setup.parameters["start"]["along_m"], setup.route.length_m
    if along_m > length_m:
        raise DocumentError(
            f"{scenario.path or 'sim_options'}: the start is {along_m:g} m along a route of "
            f"{length_m:.1f} m; give a distance from 0 to {length_m:.1f}"
        )
    return {**own, **of_map, "sim_options": options_text(sim_options(scenario, options))}


def _given_options(arguments: Mapping[str, str]) -> dict:
    """Return the given sim_options, with the seed and the traffic of the drive."""
    options = parse_options(arguments.get("sim_options") or "{}")
    for name in ("seed", "traffic"):
        if not arguments.get(name):
            continue
        number = int(arguments[name]) if arguments[name].isdecimal() else -1
        if options.setdefault(name, number) != number or number < 0:
            text = f"must be a number of at least 0, and no other than the {name} in sim_options"
            raise ValueError(f"{name}:={arguments[name]}: {text}")
    return options


class CheckedDrive:
    """One headless drive of a scenario, started through all.launch, and the check of its report.

    Args:
        scenario: name or path of the scenario; empty for the route alone
        report_path: where to write the report
        arguments: arguments of all.launch that override those of the scenario
        parameters: parameters by the name of their node, which override its configuration

    Raises:
        DocumentError, WaypointError, WorkspaceError, OSError: the scenario cannot be driven.
    """

    def __init__(
        self,
        scenario: str,
        report_path: str,
        arguments: Mapping[str, str],
        parameters: Mapping[str, Mapping] | None = None,
    ):
        self.report_path = report_path
        self._parameters = parameters or {}
        self.log_path = os.path.splitext(report_path)[0] + ".log"
        os.makedirs(os.path.dirname(report_path), exist_ok=True)
        check_stack(arguments.get("workspace", ""), arguments.get("stack", ""))
        self.environment: Mapping[str, str] = os.environ  # environment variables of the launch
        if arguments.get("workspace"):
            self.environment = _world_environment() or os.environ
        self.limits, camera, sync = {}, True, True
        if scenario:
            loaded = load_scenario(find_scenario(scenario))
            self.limits, camera, sync = loaded.limits, loaded.camera, loaded.sync
        self.arguments = {
            "sync": str(sync).lower(),
            "camera": str(camera).lower(),
            **launch_arguments(scenario, report_path, arguments),
            "headless": "true",
            "report": report_path,
        }

    def run(
        self, timeout_s: float, watch: Callable[[CheckedDrive], object] = lambda _: None
    ) -> list[str]:
        """Drive until the launch ends, complete the report and check it.

        All nodes have ended on return.

        Args:
            timeout_s: wall time after which the drive is interrupted [s]
            watch: called again and again during the drive

        Returns:
            one line for each violation, followed by the end of the log; empty if there is none
        """
        for path in (self.report_path, companion(self.report_path, EVENTS)):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        # The launch ends with this process, also when it is killed.
        command = ["setpriv", "--pdeathsig", "INT", sys.executable, "-m"]
        command += ["sdc_sim.ros.safe_launch", "sdc_package", "all.launch"]
        if self._parameters:
            command.append(self._parameters_file())
        command += [f"{key}:={value}" for key, value in self.arguments.items()]
        with open(self.log_path, "wb") as log:
            launch = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self.environment,
                start_new_session=True,
            )
        until_s = time.monotonic() + timeout_s
        try:
            while launch.poll() is None and time.monotonic() < until_s:
                watch(self)
                with contextlib.suppress(subprocess.TimeoutExpired):
                    launch.wait(_WATCH_PERIOD_S)
        finally:
            _terminate(launch)
        try:
            if not is_complete(self.report_path):
                complete_report(self.report_path)
            lines = violations(self.limits, *read_report(self.report_path))
        except (OSError, ValueError) as error:
            status = launch.returncode
            lines = [f"roslaunch ended with status {status} and wrote no report ({error})"]
        return [*lines, self._log_tail()] if lines else []

    def _parameters_file(self) -> str:
        """Write a launch file of the parameters next to the report; the last file decides."""
        path = os.path.splitext(self.report_path)[0] + ".parameters.launch"
        launch = ElementTree.Element("launch")
        for node, values in self._parameters.items():
            element = ElementTree.SubElement(launch, "rosparam", ns=node)
            element.text = options_text(values)
        ElementTree.ElementTree(launch).write(path)
        return path

    def _log_tail(self) -> str:
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            # A drive that does not advance prints the same line many times.
            lines = [line for line, _ in itertools.groupby(file.read().splitlines())]
        return "\n".join([f"the last lines of {self.log_path}:", *lines[-_LOG_TAIL_LINES:]])


@contextlib.contextmanager
def isolated_drive(
    scenario: str,
    arguments: Mapping[str, str],
    parameters: Mapping[str, Mapping] | None = None,
    route_m: np.ndarray | None = None,
    timeout_s: float = 1200.0,
    report_path: str = "",
    watch: Callable[[CheckedDrive], object] = lambda _: None,
    environment: Mapping[str, str] | None = None,
) -> Iterator[tuple[CheckedDrive, list[str]]]:
    """Drive under a ROS master of its own; by default, its files exist during the block.

    Args:
        scenario: as that of CheckedDrive
        arguments: the same
        parameters: the same
        route_m: (N, 2) waypoints, in place of the route of the scenario [m]
        timeout_s: wall time after which the drive is interrupted [s]
        report_path: where to write the report, "" for a folder that is deleted after the block
        watch: as that of `CheckedDrive.run`
        environment: environment variables of another workspace, whose all.launch is launched

    Yields:
        the drive, and the lines that `CheckedDrive.run` returns
    """
    with tempfile.TemporaryDirectory(prefix="drive_") as folder:
        arguments = {"referee_options": "{pictures: false}", **arguments}
        if route_m is not None:
            arguments["waypoints_path"] = route_path = os.path.join(folder, "route.csv")
            # The y axis of a waypoint file points to the right.
            np.savetxt(route_path, route_m * (1.0, -1.0), fmt="%.9f", delimiter=",")
        with isolated_ros_environment(os.path.join(folder, "ros"), _LEFT_BEHIND_S) as variables:
            path = report_path or os.path.join(folder, "report.json")
            drive = CheckedDrive(scenario, path, arguments, parameters)
            network = {name: variables[name] for name in _NETWORK}
            drive.environment = {**(environment or drive.environment), **network}
            lines = drive.run(timeout_s, watch)
        yield drive, lines


def _world_environment() -> dict[str, str] | None:
    """Return the environment of the workspace of this package, without any that overlays it."""
    source = os.path.realpath(package_folder("sdc_sim"))
    try:
        return workspace_environment(os.path.dirname(os.path.dirname(source)))
    except WorkspaceError:
        return None  # Installed outside a workspace.


def _terminate(launch: subprocess.Popen) -> None:
    """End a launch and its nodes. roslaunch ends its nodes in order on SIGINT only."""
    for signal_number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        if launch.poll() is not None:
            return
        os.killpg(launch.pid, signal_number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            launch.wait(_SHUTDOWN_TIMEOUT_S)


def _print_check(name: str, scenario: Scenario, report_path: str) -> int:
    lines = violations(scenario.limits, *read_report(report_path))
    for line in lines:
        print(f"{os.path.abspath(report_path)}: {line}")
    print(f"scenario {name}: {'limits violated' if lines else 'all limits are met'}")
    return 1 if lines else 0


def main() -> int:
    """Run the command line and return the exit status."""
    task, name, report_path, *rest = sys.argv[1:]
    arguments = dict(argument.split(":=", 1) for argument in rest if ":=" in argument)
    options = [argument for argument in rest if ":=" not in argument]
    try:
        if task == "check":
            return _print_check(name, load_scenario(find_scenario(name)), report_path)
        if "." in arguments.get("map", ""):  # a file
            print(*report_lines(load_network(arguments["map"])), sep="\n", file=sys.stderr)
        arguments = launch_arguments(name, report_path, arguments)
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join([*(f"{key}:={value}" for key, value in arguments.items()), *options]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
