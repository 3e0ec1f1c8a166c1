"""Drives the car's thinking in this project's physics, in one process and without ROS: as the nodes do in lockstep, tick by tick."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field

import rospkg
import yaml

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, ideal_duration, speed_profile
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner
from sdc_package.obstacles import ObstacleMargins
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import load_steering
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.evaluation.route_progress import RouteProgress, TerminationLimits
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleState, load_vehicle

TICK_S = 0.05
_LIMITS = TerminationLimits(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, timeout_s=600.0
)


def node_config(node: str) -> dict:
    """The parameters of one of sdc_package's nodes, from its configuration."""
    with open(
        os.path.join(rospkg.RosPack().get_path("sdc_package"), "config", node + ".yaml"),
        encoding="utf-8",
    ) as file:
        return yaml.safe_load(file)


@dataclass
class OfflineDrive:
    """A drive, the steer command of each of its ticks, and the least time that its route could take, seconds."""

    drive: RouteProgress
    ideal_duration_s: float
    steers: list = field(default_factory=list)


class OfflineStack:
    """What the stack's nodes think, from the car's state to its command, with the nodes' own configuration."""

    def __init__(self, route_m, steering_method: str):
        planner_config, config = node_config("local_planner"), node_config("simple_controller")
        self.limits = SpeedLimits(
            planner_config["planned_speed_mps"],
            planner_config["lateral_acceleration_mps2"],
            planner_config["acceleration_mps2"],
            planner_config["braking_mps2"],
            planner_config["lateral_jerk_mps3"],
        )
        self._planner = LocalPlanner(
            route_m,
            self.limits,
            planner_config["lookahead_m"],
            planner_config["join_within_m"],
            ObstacleMargins(**planner_config["caution"]),
        )
        self._search = WaypointSearch(self._planner.route.points)
        self._steering = load_steering(
            steering_method, config[steering_method], Axles(**config["axles"])
        )
        self._speed_control = SpeedControl(
            PidGains(**config["pid"]), SpeedControlLimits(**config["limits"])
        )
        self._steering_map, self._pedal_map = (
            SteeringMap(**config["steering"]),
            PedalMap(**config["pedals"]),
        )
        self._path = ReferencePath()
        self._last_yaw = None

    def plan(self, state: VehicleState) -> list:
        """The local planner: the rows (x, y, v) of the road ahead."""
        first = self._search.first_ahead(state.x_m, state.y_m)
        return self._planner.plan(first, state.x_m, state.y_m, wrap_angle(state.yaw_rad)).tolist()

    def command(self, rows: list, state: VehicleState) -> VehicleCommand:
        """The controller: what answers these rows in this state, one tick after the state before."""
        yaw, speed = wrap_angle(state.yaw_rad), math.hypot(state.speed_mps, state.lateral_speed_mps)
        step_s = 0.0 if self._last_yaw is None else TICK_S
        yaw_rate = wrap_angle(yaw - self._last_yaw) / step_s if step_s else 0.0
        self._last_yaw = yaw
        self._path.update(rows)
        target = self._path.nearest(state.x_m, state.y_m, self._speed_control.preview_m(speed))
        acceleration = self._speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, step_s
        )
        throttle, brake = self._pedal_map.pedals(acceleration)
        wheel_angle = self._steering.wheel_angle(
            self._path, state.x_m, state.y_m, yaw, speed, yaw_rate
        )
        return VehicleCommand(throttle, self._steering_map.command(wheel_angle, speed)[0], brake)


def load_preset(vehicle: str) -> Vehicle:
    """A car of config/vehicles."""
    presets = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "config", "vehicles")
    return Vehicle(load_vehicle(os.path.join(presets, vehicle + ".yaml")))


def drive_offline(
    route_m,
    offset_m: float = 0.0,
    turned_rad: float = 0.0,
    steering_method: str = "stanley",
    vehicle: str = "tesla_model3",
    longest_s: float = _LIMITS.timeout_s,
) -> OfflineDrive:
    """Drive along the (N, 2) route from a start at rest, `offset_m` to its left and `turned_rad` across it, until the drive ends
    or `longest_s` of simulated time have passed."""
    thinking = OfflineStack(route_m, steering_method)
    car = load_preset(vehicle)
    route = Route(route_m)
    heading = math.atan2(
        route.points[1, 1] - route.points[0, 1], route.points[1, 0] - route.points[0, 0]
    )
    car.reset(
        route.points[0, 0] - offset_m * math.sin(heading),
        route.points[0, 1] + offset_m * math.cos(heading),
        heading + turned_rad,
    )

    rehearsal = OfflineDrive(
        RouteProgress(route, _LIMITS), ideal_duration(route, speed_profile(route, thinking.limits))
    )
    tick = 0
    while rehearsal.drive.status is None and tick * TICK_S < longest_s:
        state = car.state
        rehearsal.drive.update(
            tick * TICK_S,
            state.x_m,
            state.y_m,
            wrap_angle(state.yaw_rad),
            math.hypot(state.speed_mps, state.lateral_speed_mps),
        )
        command = thinking.command(thinking.plan(state), state)
        rehearsal.steers.append(command.steer)
        car.step(command, TICK_S)
        tick += 1
    return rehearsal
