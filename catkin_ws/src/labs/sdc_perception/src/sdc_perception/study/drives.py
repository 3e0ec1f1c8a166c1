"""Drive by what the lab's nodes find in the picture, in lockstep, and print how well.

    python3 -m sdc_perception.study.drives [NAME ...] [--weather NAME | all]

A NAME is the seed of a random route or "town", which the car drives by the lane, or a scenario,
which it drives by lane, lights and obstacles. The exit status is 1 if a drive is not completed, or
violates a limit of its scenario.
"""

from __future__ import annotations

import argparse
import itertools
import os
import sys
import tempfile
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np
import yaml

from sdc_common.processes import isolated_ros_environment
from sdc_sim.road.random_routes import random_route
from sdc_sim.runner import CheckedDrive
from sdc_sim.scenario.acceptance_limits import read_report
from sdc_sim.scenario.packaged import node_config

TOWN = "town"
# Name: parameters of config/sim.yaml.
WEATHERS: dict[str, dict[str, Any]] = {
    "day": {},
    "dusk": {"daylight": 0.25},
    "low_sun": {"weather": {"low_sun": True}},
    "fog": {"weather": {"fog_m": 45.0}},
    "rain": {"weather": {"rain": 1.0}, "daylight": 0.8},
    "worn": {"weather": {"worn_lines": 0.6}},
}
_TIMEOUT_S = 1200.0
_NO_OPTIONS: Mapping[str, Any] = {}


def lab_parameters(node: str) -> dict[str, Any]:
    """Return the parameters of a node of sdc_perception, from its file in config/."""
    return node_config("sdc_perception", node)


class NodesDrive(NamedTuple):
    """A drive of the nodes in lockstep.

    Attributes:
        metrics: the report of the referee
        trace: columns of report.csv by name, such as `cross_track_m`
        problems: one line for each limit of the scenario that is violated
    """

    metrics: dict[str, Any]
    trace: np.ndarray
    problems: list[str]


def drive_nodes(
    scenario: str = "",
    route_m: np.ndarray | None = None,
    sim_options: Mapping[str, Any] = _NO_OPTIONS,
    **given: str,
) -> NodesDrive:
    """Drive in lockstep under a ROS master of its own.

    Args:
        scenario: name of a scenario, "" for the route alone
        route_m: (N, 2) waypoints [m], None for the route of the scenario or the town
        sim_options: parameters that replace those of config/sim.yaml
        given: other arguments of ./drive
    """
    options = yaml.safe_dump(dict(sim_options), default_flow_style=True, width=10**6).strip()
    given = {**given, "sim_options": options, "referee_options": "{pictures: false}"}
    with tempfile.TemporaryDirectory(prefix="perception_") as folder:
        if route_m is not None:
            given["waypoints_path"] = os.path.join(folder, "route.csv")
            # The y axis of a waypoint file points to the right.
            np.savetxt(given["waypoints_path"], route_m * (1.0, -1.0), fmt="%.9f", delimiter=",")
        with isolated_ros_environment(os.path.join(folder, "ros")) as environment:
            drive = CheckedDrive(scenario, os.path.join(folder, "report.json"), given)
            problems = drive.run(_TIMEOUT_S, environment=environment)
        trace = np.genfromtxt(
            os.path.join(folder, "report.csv"), delimiter=",", names=True, usecols=range(8)
        )
        return NodesDrive(read_report(drive.report_path)[0], trace, problems[:-1])


def drive(name: str, weather: str = "day") -> NodesDrive:
    """Drive with what the nodes find in the picture.

    Args:
        name: seed of a random route, "town", or the name of a scenario
        weather: a key of WEATHERS
    """
    by_lane = name == TOWN or name.isdecimal()
    return drive_nodes(
        "" if by_lane else name,
        random_route(int(name))[0] if name.isdecimal() else None,
        WEATHERS[weather],
        perception="lane" if by_lane else "all",
        camera="true",
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="drive by what is found in the picture")
    parser.add_argument("names", nargs="*", default=[TOWN], help=f"seeds, {TOWN}, or scenarios")
    parser.add_argument("--weather", choices=[*WEATHERS, "all"], default="day")
    given = parser.parse_args(arguments)
    weathers = list(WEATHERS) if given.weather == "all" else [given.weather]
    failed = False
    for name, weather in itertools.product(given.names, weathers):
        metrics, _, problems = drive(name, weather)
        print(
            f"{name:20s} {weather:8s} {metrics['status']:9s} {metrics['duration_s']:6.1f} s, "
            f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
            f"{metrics['cross_track_max_m']:.3f} m at worst, "
            f"{sum(metrics['infractions'].values())} infractions, "
            f"{1e3 * metrics['wall_duration_s'] / metrics['ticks']:.1f} ms a tick",
            flush=True,
        )
        for problem in problems:
            print(f"  {problem}")
        failed = failed or bool(problems) or metrics["status"] != "completed"
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
