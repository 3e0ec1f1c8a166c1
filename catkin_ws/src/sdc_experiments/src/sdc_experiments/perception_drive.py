"""Drive scenarios on detections alone, in one process without ROS.

    python3 -m sdc_experiments.perception_drive [SCENARIO ...] [--weather NAME] [--frames FOLDER]

The car finds lane, traffic lights and obstacles in the picture of the front camera, and has wheel
speeds and yaw rate of sensors:=standard. The drive is that of ./drive perception:=all in lockstep,
bit for bit. The exit status is 1 if a drive violates a limit of its
scenario.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np

from sdc_experiments.car_stack import Rows, pose_and_speed, yaw_of_quaternion
from sdc_experiments.perception import (
    WEATHERS,
    LaneDriver,
    as_local_path,
    drive_by_picture,
    lab_parameters,
)
from sdc_perception.detection_overlay import draw_lights, draw_obstacles
from sdc_perception.light_tracker import LightSettings, LightTracker
from sdc_perception.obstacle_detection import covered_boxes
from sdc_perception.obstacle_tracker import (
    ObstacleSettings,
    ObstacleTracker,
    TrackedBody,
    body_finder,
)
from sdc_perception.traffic_following import TrafficFollower, TrafficSettings
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.scenario.acceptance_limits import violations
from sdc_sim.scenario.drive_setup import DriveSetup, drive_setup
from sdc_sim.scenario.packaged import node_config
from sdc_sim.simulation.observation import Observation

SCENARIOS = ("traffic_lights", "stopped_car", "crossing_pedestrian", "slow_leader")
# As in sdc_sim.scenario.acceptance_limits.
_STANDSTILL_MPS = 0.05


class TrafficDriver(LaneDriver):
    """The nodes of perception:=all as plain objects.

    Attributes:
        lights: detector of traffic lights
        bodies: detector of obstacles
        detection_s: CPU time of lane, lights and obstacles (N, 3) in each tick
    """

    def __init__(self) -> None:
        super().__init__()
        intrinsic = CameraModel().intrinsic_matrix()
        lights = lab_parameters("traffic_light_detector").__getitem__
        bodies = lab_parameters("obstacle_detector").__getitem__
        self.lights = LightTracker(LightSettings.read(lights), intrinsic)
        self.bodies = ObstacleTracker(ObstacleSettings.read(bodies), intrinsic)
        self._finder = body_finder(ObstacleSettings.read(bodies), intrinsic)
        # As in launch/perception.launch.
        follower = {
            **node_config("sdc_package", "local_planner"),
            **lab_parameters("lane_follower"),
            **lab_parameters("traffic_follower"),
        }
        self._traffic = TrafficFollower(TrafficSettings.read(follower.__getitem__))

    def answer(self, believed: Observation, picture: np.ndarray) -> Rows:
        """See LaneDriver."""
        x, y, yaw, speed = pose_and_speed(believed)
        pose, time_s = (x, y, yaw), believed.time_s
        times = [time.thread_time()]
        covered = covered_boxes(self._finder.find(picture))
        lane = self.detector.detect(picture, pose, covered)
        times.append(time.thread_time())
        lights = self.lights.detect(picture, pose, time_s)
        times.append(time.thread_time())
        bodies = self.bodies.detect(picture, pose, time_s)
        times.append(time.thread_time())
        self.detection_s.append(np.diff(times).tolist())
        path = self.path(lane, pose)
        if lane is not None and lane.confidence > 0.0:
            published = [*map(_as_published, bodies)]
            path = self._traffic.limited(path, pose, speed, published, lights)
        self.lanes.append(lane)
        return as_local_path(path)

    def overlay(self, picture: np.ndarray, believed: Observation) -> np.ndarray:
        """See LaneDriver."""
        drawn = super().overlay(picture, believed)
        return draw_lights(draw_obstacles(drawn, self.bodies.seen), self.lights.seen)


def _as_published(body: TrackedBody) -> TrackedBody:
    """Return a body with the precision of the message Obstacle."""
    speed = float(np.float32(body.speed_mps))
    return body._replace(yaw_rad=yaw_of_quaternion(body.yaw_rad), speed_mps=speed)


class TrafficDrive(NamedTuple):
    """A drive on detections.

    Attributes:
        result: the drive as the referee evaluates it
        problems: one line for each limit of the scenario that is violated
        detection_s: see TrafficDriver
    """

    result: DriveResult
    problems: list[str]
    detection_s: np.ndarray


def drive_on_detections(
    scenario: str,
    weather: str = "day",
    show: Callable[[int, Callable[[], np.ndarray]], Any] | None = None,
) -> TrafficDrive:
    """Drive a scenario.

    Args:
        scenario: name of a packaged scenario or path of a scenario file
        weather: a key of WEATHERS
        show: called in each tick with its number and a function that returns the overlay picture
    """
    sensors = node_config("sdc_sim", "sensors/standard")
    setup = drive_setup(scenario, None, {**sensors, **WEATHERS[weather]})
    driver = TrafficDriver()
    result = drive_by_picture(setup, driver, show=show)
    return TrafficDrive(result, _problems(setup, result), np.array(driver.detection_s))


def _problems(setup: DriveSetup, result: DriveResult) -> list[str]:
    assert setup.scenario is not None
    speed, s_m = result.progress.column("speed_mps"), result.progress.column("s_m")
    stops_m = s_m[1:][(speed[:-1] >= _STANDSTILL_MPS) & (speed[1:] < _STANDSTILL_MPS)].tolist()
    # A drive in process misses no tick.
    metrics = {**result.metrics, "missed_ticks": 0}
    return violations(setup.scenario.limits, metrics, stops_m)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="drive scenarios on detections alone")
    parser.add_argument("scenarios", nargs="*", default=SCENARIOS)
    parser.add_argument("--weather", choices=list(WEATHERS), default="day")
    parser.add_argument("--frames", help="folder for overlay pictures, one each second")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    failed = False
    for scenario in given.scenarios:

        def store(number: int, picture: Callable[[], np.ndarray], name: str = scenario) -> None:
            if given.frames and number % 20 == 0:
                path = os.path.join(given.frames, f"{name}_{given.weather}_{number:04d}.png")
                cv2.imwrite(path, picture())

        drive = drive_on_detections(scenario, given.weather, store)
        metrics = drive.result.metrics
        times = " + ".join(f"{1e3 * one:.1f}" for one in np.median(drive.detection_s, axis=0))
        print(
            f"{scenario:20s} {metrics['status']:9s} {metrics['duration_s']:5.1f} s  "
            f"infractions {sum(metrics['infractions'].values())}  "
            f"cross-track at worst {metrics['cross_track_max_m']:.2f} m  "
            f"lane + lights + obstacles {times} ms",
            flush=True,
        )
        for problem in drive.problems:
            print(f"  {problem}")
        failed = failed or bool(drive.problems)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
