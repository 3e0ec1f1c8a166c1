"""Drive by the lane in the camera picture, in one process without ROS, and print how well.

    python3 -m sdc_experiments.perception [SEED ... | town] [--weather NAME | all] [--frames FOLDER]

Each SEED is that of a random route. The drive uses the renderer of the front camera, the lane
detector, the lane follower, the controller and the simulator with sensors:=standard. Numbers are
rounded as in the messages between the nodes.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import time
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Mapping, Sequence

import cv2
import numpy as np

from sdc_experiments.car_stack import CarController, Rows, pose_and_speed
from sdc_experiments.closed_loop import DriveRecorder, drive_until_over, stamp_nanoseconds
from sdc_experiments.random_routes import random_route
from sdc_perception.dead_reckoning import DeadReckoning, rear_axle_speed
from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_perception.lane_following import FollowingSettings, lane_path, stopping_path
from sdc_perception.lane_tracker import TrackedLane
from sdc_perception.overlay import draw_lane
from sdc_sim.camera.boxes import obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.road import Road
from sdc_sim.scenario.drive_setup import DriveSetup, drive_setup
from sdc_sim.scenario.packaged import node_config
from sdc_sim.sensors.readings import WHEELS
from sdc_sim.simulation.observation import Observation
from sdc_sim.simulation.weather import Weather

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
_NO_OPTIONS: Mapping[str, Any] = {}
_WHEEL_NAMES = [f"{wheel}_wheel" for wheel in WHEELS]


def lab_parameters(node: str) -> dict[str, Any]:
    """Return the parameters of a node of sdc_perception, from its file in config/."""
    return node_config("sdc_perception", node)


@dataclass
class LaneDrive:
    """The record of a drive by the lane.

    Attributes:
        result: the drive as the referee evaluates it
        lanes: the lane of each tick, None where there was none
        detection_s: time of each detection
        rendering_s: time in which each picture was rendered
    """

    result: DriveResult
    lanes: list[TrackedLane | None]
    detection_s: list[float]
    rendering_s: list[float]

    @property
    def offset_errors_m(self) -> np.ndarray:
        """Errors of the offset in the pictures with a lane."""
        truth = self.result.progress.column("cross_track_m")
        pairs = zip(self.lanes, truth.tolist())
        return np.array([lane.offset_m - true_m for lane, true_m in pairs if lane is not None])

    def summary(self) -> str:
        """Return the metrics in one line."""
        metrics, errors = self.result.metrics, np.abs(self.offset_errors_m)
        offset_m = np.percentile(errors, 95) if len(errors) else math.nan
        return (
            f"{metrics['status']:9s} {metrics['route_completion_percent']:4.0f} % "
            f"{metrics['duration_s']:6.1f} s, {metrics['time_ratio'] or math.nan:.2f} of the least "
            f"cross-track RMS {metrics['cross_track_rms_m']:.3f} m, "
            f"worst {metrics['cross_track_max_m']:.3f} m  offset error 95 % {offset_m:.3f} m  "
            f"picture {1e3 * np.median(self.detection_s):.1f} ms, "
            f"rendering {1e3 * np.median(self.rendering_s):.1f} ms"
        )


class LaneDriver:
    """The nodes of the lab as plain objects: dead reckoning, detector, follower.

    Attributes:
        detector: lane detector
        following: settings of the follower
        motion: dead reckoning
        lanes: the lane of each tick, None where there was none
        detection_s: CPU time of the detectors (N, D) in each tick
        rendering_s: CPU time in which each picture was rendered
    """

    def __init__(self, options: Mapping[str, Any] = _NO_OPTIONS):
        """Build the nodes.

        Args:
            options: parameters that replace those of config/lane_detector.yaml
        """
        parameters = {**lab_parameters("lane_detector"), **options}
        self.detector = LaneDetector(
            DetectorSettings.read(parameters.__getitem__), CameraModel().intrinsic_matrix()
        )
        self.following = FollowingSettings.read(lab_parameters("lane_follower").__getitem__)
        car = lab_parameters("dead_reckoning")
        self._wheel_radius_m = car["wheel_radius_m"]
        self.motion = DeadReckoning(car["rear_m"], car["rear_compliance"])
        self._last_ns: int | None = None
        self.lanes: list[TrackedLane | None] = []
        self.detection_s: list[list[float]] = []
        self.rendering_s: list[float] = []

    def move(self, observation: Observation) -> Observation:
        """Return the observation with the odometry of wheels and gyroscope."""
        readings, motion = observation.readings, self.motion
        assert readings.imu is not None
        assert readings.wheel_speeds_radps is not None
        stamp_ns = stamp_nanoseconds(observation)
        step_s = 0.0 if self._last_ns is None else (stamp_ns - self._last_ns) / 1e9
        self._last_ns = stamp_ns
        rates = readings.wheel_speeds_radps
        speed = rear_axle_speed(_WHEEL_NAMES, rates, self._wheel_radius_m)
        motion.update(speed, readings.imu.rate_radps[2], step_s)
        pose = motion.x_m, motion.y_m, motion.yaw_rad
        state = VehicleState(*pose, motion.speed_mps, motion.lateral_mps)
        return observation._replace(measured=state)

    def answer(self, believed: Observation, picture: np.ndarray) -> Rows:
        """Return the path ahead.

        Args:
            believed: observation with the odometry of wheels and gyroscope
            picture: camera picture
        """
        pose, start_s = pose_and_speed(believed)[:3], time.thread_time()
        self.lanes.append(self.detector.detect(picture, pose))
        self.detection_s.append([time.thread_time() - start_s])
        return as_local_path(self.path(self.lanes[-1], pose))

    def overlay(self, picture: np.ndarray, believed: Observation) -> np.ndarray:
        """Return a copy of the last picture with what was found in it."""
        detector = self.detector
        pose = pose_and_speed(believed)[:3]
        return draw_lane(picture.copy(), detector.ground, pose, self.lanes[-1], detector.found)

    def path(self, lane: TrackedLane | None, pose: tuple[float, float, float]) -> np.ndarray:
        """Return the path ahead (N, 3): x [m], y [m], speed [m/s]."""
        if lane is None or lane.confidence <= 0.0:
            return stopping_path(*pose)
        return lane_path(_as_published(lane), self.following)


def as_local_path(path: np.ndarray) -> Rows:
    """Return a path (N, 3) with the precision of the message LocalPath."""
    return path.astype(np.float32).tolist()


def _as_published(lane: TrackedLane) -> TrackedLane:
    """Return a lane with the precision of the message Lane."""
    numbers = {
        name: float(np.float32(getattr(lane, name)))
        for name in ("confidence", "visible_m", "first_m")
    }
    curvatures = lane.curvatures_1pm.astype(np.float32).astype(float)
    return lane._replace(curvatures_1pm=curvatures, **numbers)


def drive_by_picture(
    setup: DriveSetup,
    driver: LaneDriver,
    longest_s: float | None = None,
    show: Callable[[int, Callable[[], np.ndarray]], Any] | None = None,
) -> DriveResult:
    """Drive from standstill; only the referee knows the route.

    Args:
        setup: conditions of the drive
        driver: the nodes of the car
        longest_s: simulated time after which to stop, None for no limit but the referee's [s]
        show: called in each tick with its number and a function that returns the overlay picture
    """
    simulation, daylight = setup.simulation(), setup.parameters["daylight"]
    air = Weather.read(setup.parameters["weather"])
    renderer = Renderer(Road(setup.waypoints_m), weather=air)
    picture = np.empty((renderer.camera.height, renderer.camera.width, 4), np.uint8)
    limits = lab_parameters("lane_follower")
    recorder = DriveRecorder(setup, simulation, limits, {"finish_at_rest": False})

    def believe(observation: Observation) -> Observation:
        state, start_s = observation.state, time.thread_time()
        boxes = [obstacle_box(obstacle) for obstacle in observation.obstacles]
        boxes += [traffic_light_box(light) for light in observation.traffic_lights]
        pose = state.x_m, state.y_m, state.yaw_rad
        renderer.render(*pose, boxes, daylight, picture, observation.time_s)
        driver.rendering_s.append(time.thread_time() - start_s)
        return driver.move(observation)

    def plan(observation: Observation) -> Rows:
        rows = driver.answer(observation, picture)
        if show is not None:
            show(len(driver.lanes) - 1, partial(driver.overlay, picture, observation))
        return rows

    controller = CarController()
    drive_until_over(simulation, plan, controller, recorder, believe=believe, longest_s=longest_s)
    return recorder.result()


def drive_by_lane(
    route_m: np.ndarray,
    options: Mapping[str, Any] = _NO_OPTIONS,
    seed: int = 0,
    longest_s: float | None = None,
    frames: dict[int, np.ndarray | None] | None = None,
    weather: str = "day",
) -> LaneDrive:
    """Drive along a route that only the referee knows, from standstill.

    Args:
        route_m: (N, 2) waypoints [m]
        options: parameters that replace those of config/lane_detector.yaml
        seed: seed of the errors of the sensors
        longest_s: simulated time after which to stop, None for no limit but the referee's [s]
        frames: for each metre that the wheels measure, the first overlay picture there
        weather: a key of WEATHERS
    """
    sensors = node_config("sdc_sim", "sensors/standard")
    setup = drive_setup("", route_m, {**sensors, **WEATHERS[weather], "seed": seed})
    driver = LaneDriver(options)

    def show(_number: int, overlay: Callable[[], np.ndarray]) -> None:
        at = int(driver.detector.driven_m)
        if frames is not None and at in frames and frames[at] is None:
            frames[at] = overlay()

    result = drive_by_picture(setup, driver, longest_s, show)
    detection_s = [times[0] for times in driver.detection_s]
    return LaneDrive(result, driver.lanes, detection_s, driver.rendering_s)


def route_named(name: str) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the waypoints (N, 2) [m] of a seed or the town, and options of its detector."""
    if name != TOWN:
        return random_route(int(name))[0], {}
    return drive_setup().waypoints_m, lab_parameters("town_directions")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description="drive by the lane in the camera picture")
    parser.add_argument("routes", nargs="*", default=[TOWN], help=f"seeds, or {TOWN}")
    parser.add_argument("--frames", help="folder for overlay pictures, one every 20 m")
    parser.add_argument("--weather", choices=[*WEATHERS, "all"], default="day")
    given = parser.parse_args(arguments)
    weathers = list(WEATHERS) if given.weather == "all" else [given.weather]
    cv2.setNumThreads(1)
    for name, weather in itertools.product(given.routes, weathers):
        route, options = route_named(name)
        frames = dict.fromkeys(range(0, 5000, 20)) if given.frames else None
        drive = drive_by_lane(route, options, frames=frames, weather=weather)
        print(f"{name:6s} {weather:8s} {drive.summary()}", flush=True)
        for s_m, picture in (frames or {}).items():
            if picture is not None:
                path = os.path.join(given.frames, f"{name}_{weather}_{s_m:04d}.png")
                cv2.imwrite(path, picture)


if __name__ == "__main__":
    main()
