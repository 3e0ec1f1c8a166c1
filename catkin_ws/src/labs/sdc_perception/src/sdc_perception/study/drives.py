"""Drive by what the lab's nodes find in the picture, in lockstep, and print how well.

    python3 -m sdc_perception.study.drives [NAME ...] [--weather NAME | all] [--frames FOLDER]

A NAME is the seed of a random route or "town", which the car drives by the lane, or a scenario,
which it drives by lane, lights and obstacles. The exit status is 1 if a drive is not completed, or
violates a limit of its scenario.
"""

from __future__ import annotations

import argparse
import itertools
import os
import sys
from typing import Any, Mapping, NamedTuple, Sequence

import cv2
import numpy as np
import rosbag
from cv_bridge import CvBridge

from sdc_sim.road.random_routes import random_route
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report
from sdc_sim.scenario.packaged import options_text

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
_LANE, _OVERLAY = "/perception/lane", "/perception/lane_overlay"
# The world starts when the recorder, too, receives it.
_ODOMETRY = "/sim/ground_truth/odometry"
_NO_OPTIONS: Mapping[str, Any] = {}


class NodesDrive(NamedTuple):
    """A drive of the nodes in lockstep."""

    metrics: dict[str, Any]  # the report of the referee
    trace: np.ndarray  # columns of report.csv by name, such as `cross_track_m`
    problems: list[str]  # one line for each limit of the scenario that is violated
    offset_errors_m: np.ndarray  # (N,) offset of the car in each found lane minus the true one [m]


def drive_nodes(
    scenario: str = "",
    route_m: np.ndarray | None = None,
    sim_options: Mapping[str, Any] = _NO_OPTIONS,
    frames: str = "",
    **arguments: str,
) -> NodesDrive:
    """Drive in lockstep under a ROS master of its own.

    Args:
        scenario: name of a scenario, "" for the route alone
        route_m: (N, 2) waypoints [m], None for the route of the scenario or the town
        sim_options: parameters that replace those of config/sim.yaml
        frames: beginning of the names of pictures of the lane; "" for none
        arguments: other arguments of ./drive
    """
    # On a busy machine an answer may take long; no tick is driven without one.
    sim_options = {
        "patience_s": 60.0,
        "first_answer_s": 60.0,
        "start_patience_s": 120.0,
        **sim_options,
    }
    arguments = {**arguments, "sim_options": options_text(sim_options)}
    pictures = [_OVERLAY] if frames else []
    topics = {"record": {"topics": [_LANE, *pictures, _ODOMETRY]}}
    with isolated_drive(scenario, arguments, topics, route_m) as (drive, problems):
        base = os.path.splitext(drive.report_path)[0]
        trace = np.genfromtxt(f"{base}.csv", delimiter=",", names=True, usecols=range(8))
        errors_m = _offset_errors(f"{base}.bag", trace, frames) if "record" in arguments else []
        metrics = read_report(drive.report_path)[0]
        return NodesDrive(metrics, trace, problems[:-1], np.array(errors_m))


def _offset_errors(bag_path: str, trace: np.ndarray, frames: str) -> list[float]:
    """Return the errors of the offset of each lane in a bag [m]; store its pictures."""
    true_m = dict(zip(np.round(trace["time_s"], 3).tolist(), trace["cross_track_m"].tolist()))
    errors_m = []
    with rosbag.Bag(bag_path) as bag:
        for topic, message, _ in bag.read_messages([_LANE, _OVERLAY]):
            time_s = round(message.header.stamp.to_sec(), 3)
            if topic == _OVERLAY:
                picture = CvBridge().imgmsg_to_cv2(message, "bgr8")
                cv2.imwrite(f"{frames}{time_s:08.2f}.png", picture)
            elif message.confidence > 0.0 and time_s in true_m:
                errors_m.append(message.offset_m - true_m[time_s])
    return errors_m


def drive(name: str, weather: str = "day", frames: str = "") -> NodesDrive:
    """Drive with what the nodes find in the picture, in a weather of WEATHERS.

    `name` is the seed of a random route, "town", or a scenario. `frames` is the folder of the
    pictures of the lane; "" for none.
    """
    by_lane = name == TOWN or name.isdecimal()
    return drive_nodes(
        "" if by_lane else name,
        random_route(int(name))[0] if name.isdecimal() else None,
        WEATHERS[weather],
        os.path.join(frames, f"{name}_{weather}_") if frames else "",
        perception="lane" if by_lane else "all",
        camera="true",
        record="true",
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="drive by what is found in the picture")
    parser.add_argument("names", nargs="*", default=[TOWN], help=f"seeds, {TOWN}, or scenarios")
    parser.add_argument("--weather", choices=[*WEATHERS, "all"], default="day")
    parser.add_argument("--frames", default="", help="folder for the pictures of the lane")
    options = parser.parse_args(arguments)
    weathers = list(WEATHERS) if options.weather == "all" else [options.weather]
    failed = False
    for name, weather in itertools.product(options.names, weathers):
        metrics, _, problems, errors_m = drive(name, weather, options.frames)
        off_m = np.percentile(np.abs(errors_m), 95) if len(errors_m) else np.nan
        print(
            f"{name:20s} {weather:8s} {metrics['status']:9s} {metrics['duration_s']:6.1f} s, "
            f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
            f"{metrics['cross_track_max_m']:.3f} m at worst, offset error {off_m:.3f} m (95 %), "
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
