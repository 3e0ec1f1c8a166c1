"""Benchmarks of single parts in this process, with one thread."""

from __future__ import annotations

import argparse
import io
import itertools
import math
import os
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import rospy
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_common.configuration import package_folder
from sdc_common.geometry.route import Route
from sdc_common.ros.conversion import command_message
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_experiments.benchmarks.bare_loop import perspective_warp
from sdc_experiments.closed_loop import controller_with
from sdc_experiments.configuration import node_parameters, vehicle_preset
from sdc_package.car import MissionDriver
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import PlannerSettings
from sdc_sim.camera.boxes import Box
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.vehicle import Vehicle, VehicleState
from sdc_sim.road.random_routes import long_route
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import odometry_message
from sdc_sim.ros.picture_messages import image_message
from sdc_sim.sensors.lidar import PlanarLidar, RoofLidar
from sdc_sim.sensors.model import Moment, SensorContext, sensor_settings
from sdc_sim.simulation.snapshot import Snapshot

TICK_S, STEP_M = 0.05, 0.5  # 10 m/s at 20 Hz
_TICKS, _WARPS, _FRAMES, _PLACES = 400, 300, 600, 300
# Distance ahead of the car and to the left of its route [m], and kind of each body; sizes [m].
_BODIES = (
    *((14.0, 0.0, "car"), (27.0, 0.2, "car"), (18.0, 3.5, "car"), (40.0, 3.5, "car")),
    *((60.0, 0.0, "car"), (11.0, -3.4, "pedestrian"), (22.0, 7.0, "pedestrian")),
    *((32.0, -3.2, "pedestrian"), (35.0, 1.8, "obstacle"), (24.0, -3.0, "light")),
)
_SIZES = {
    "car": (4.7, 2.0, 1.45),
    "pedestrian": (0.45, 0.6, 1.78),
    "obstacle": (1.0, 1.0, 1.0),
    "light": (0.5, 0.5, 4.2),
}


def packaged_route() -> np.ndarray:
    """Return the waypoints (N, 2) of the town [m]."""
    folder = package_folder("sdc_common")
    return load_waypoints(os.path.join(folder, "data", "waypoints.csv"))


def duration_ms(function: Callable[..., Any], *arguments: Any) -> float:
    """Return the duration of a call [ms]."""
    start_s = time.perf_counter()
    function(*arguments)
    return 1e3 * (time.perf_counter() - start_s)


def parts(_options: argparse.Namespace) -> Iterator[dict[str, float]]:
    """Yield the median time of each part of a tick in the town [ms]."""
    route = packaged_route()
    settings = PlannerSettings.read(node_parameters("local_planner").__getitem__)
    planner = MissionDriver(route, settings)
    (controller, _), reference = controller_with(), ReferencePath()
    vehicle, renderer = Vehicle(vehicle_preset("tesla_model3")), Renderer(Road(route))
    (x, y), (next_x, next_y) = route[:2].tolist()
    vehicle.reset(x, y, math.atan2(next_y - y, next_x - x))
    for first in itertools.count(1, _TICKS):
        times: dict[str, list[float]] = {}
        for tick in range(first, first + _TICKS):
            marks = [("", time.perf_counter())]
            state, stamp = vehicle.state, rospy.Time.from_sec(tick * TICK_S)
            observation = Snapshot(stamp.to_nsec(), state, state).observation()
            path = planner.plan(observation)
            marks.append(("planner", time.perf_counter()))
            reference.update(path.points)
            command = controller.command(observation, reference)
            assert command is not None
            marks.append(("controller", time.perf_counter()))
            vehicle.step(command, TICK_S)
            marks.append(("physics", time.perf_counter()))
            for message in (
                Clock(stamp),
                odometry_message(state, stamp),
                LocalPath([Waypoint(*point) for point in path.points]),
                command_message(command, CarlaVehicleControl),
            ):
                buffer = io.BytesIO()
                message.serialize(buffer)
                type(message)().deserialize(buffer.getvalue())
            marks.append(("serialize the messages", time.perf_counter()))
            picture = renderer.render(state.x_m, state.y_m, state.yaw_rad)
            marks.append(("render", time.perf_counter()))
            image_message(picture, stamp).serialize(io.BytesIO())
            marks.append(("serialize the picture", time.perf_counter()))
            for (_, start_s), (name, end_s) in zip(marks, marks[1:]):
                times.setdefault(name, []).append(1e3 * (end_s - start_s))
        yield {name: float(np.median(values)) for name, values in times.items()}


def camera(_options: argparse.Namespace) -> Iterator[dict[str, float]]:
    """Yield the pictures of 640 x 480 per second, with the rasterization of the ground."""
    road, warp = Road(long_route(0, 300.0)), perspective_warp()

    def pose(s_m: float, left_m: float = 0.0) -> tuple[float, float, float]:
        (point,), (left,) = road.at(np.array([s_m]))
        x_m, y_m = (point + left_m * left).tolist()
        return x_m, y_m, math.atan2(-left[0], left[1])

    def rate(bodies: tuple) -> float:
        renderer, spent_ms = Renderer(road), 0.0
        renderer.render(*pose(0.0))
        for s_m in np.arange(_FRAMES) * STEP_M:
            boxes = [
                Box(*pose(s_m + ahead_m, left_m), *_SIZES[kind], kind=kind)
                for ahead_m, left_m, kind in bodies
            ]
            spent_ms += duration_ms(renderer.render, *pose(s_m), boxes)
        return 1e3 * _FRAMES / spent_ms

    while True:
        yield {
            "one perspective warp": 1e3 / np.mean([duration_ms(warp) for _ in range(_WARPS)]),
            "road and scenery": rate(()),
            "and 10 boxes": rate(_BODIES),
        }


def lidar(_options: argparse.Namespace) -> Iterator[dict[str, float]]:
    """Yield the median time of a scan of each lidar along the town [ms]."""
    route_m = packaged_route()
    scenery, route = Road(route_m).scenery(), Route(route_m)
    vehicle = vehicle_preset("tesla_model3")
    context = SensorContext(0, 0, TICK_S, vehicle, None, lambda: scenery)
    planar = PlanarLidar(sensor_settings("planar_lidar", {"period_s": TICK_S}), context)
    rings = RoofLidar(sensor_settings("lidar", {"period_s": TICK_S}), context)
    numbers = np.linspace(0.0, 1.0, 16_384)
    names = ("sine of 16,384 numbers", "planar lidar, 1,080 beams", "16 rings of 1,024 columns")
    while True:
        times = []
        for s_m in np.linspace(0.0, route.length_m, _PLACES):
            x_m, y_m = route.line.point_at(s_m)
            state = VehicleState(x_m=x_m, y_m=y_m, yaw_rad=route.line.heading_at(s_m))
            moment = Moment(0.0, state)
            scans = (planar.read, moment, 0), (rings.read, moment, 0)
            times.append([duration_ms(*work) for work in ((np.sin, numbers), *scans)])
        yield dict(zip(names, np.median(times, axis=0).tolist()))
