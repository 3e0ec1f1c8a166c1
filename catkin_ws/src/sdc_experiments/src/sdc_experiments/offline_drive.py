"""Drive the algorithms of the car's nodes in this project's physics, in one process without ROS.

A drive equals that of the nodes in lockstep, tick by tick.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.road_line import road_route
from sdc_experiments.configuration import node_parameters, vehicle_preset
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner, PlannerSettings
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.evaluation.route_progress import RouteProgress, TerminationLimits
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleState

TICK_S = 0.05
LIMITS = TerminationLimits(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, timeout_s=600.0
)


@dataclass
class OfflineDrive:
    """The record of a drive.

    Attributes:
        progress: the drive as the referee measures it
        ideal_duration_s: shortest time in which the route can be driven [s]
        steers: steer command of each tick, -1..1
    """

    progress: RouteProgress
    ideal_duration_s: float
    steers: list[float] = field(default_factory=list)


class OfflineStack:
    """The algorithms of local planner and controller, with the configuration of their nodes."""

    def __init__(
        self, route_m: np.ndarray, steering_method: str, planned_speed_mps: float | None = None
    ):
        """Build the stack.

        Args:
            route_m: (N, 2) waypoints of the mission [m]
            steering_method: name of a method in config/simple_controller.yaml
            planned_speed_mps: speed on a free straight, None for that of the configuration [m/s]
        """
        parameters = node_parameters("local_planner")
        if planned_speed_mps is not None:
            parameters["planned_speed_mps"] = planned_speed_mps
        settings = PlannerSettings.read(parameters.__getitem__)
        config = node_parameters("simple_controller")
        self.limits = settings.limits
        self._planner = LocalPlanner(route_m, settings)
        self._search = WaypointSearch(self._planner.route.points)
        axles = Axles(**config["axles"])
        self._steering = load_steering(steering_method, config[steering_method], axles)
        limits = SpeedControlLimits(**config["limits"])
        self._speed_control = SpeedControl(PidGains(**config["pid"]), limits)
        self._steering_map = SteeringMap(**config["steering"])
        self._pedal_map = PedalMap(**config["pedals"])
        self._path = ReferencePath()
        self._last_yaw_rad: float | None = None

    def plan(self, state: VehicleState) -> list[list[float]]:
        """Return the rows (x, y, target speed) of the path ahead, as the local planner does."""
        first = self._search.first_ahead(state.x_m, state.y_m)
        rows = self._planner.plan(first, state.x_m, state.y_m, wrap_angle(state.yaw_rad))
        return rows.tolist()

    def command(self, rows: list[list[float]], state: VehicleState) -> VehicleCommand:
        """Return the command of the controller, one tick after the last call."""
        yaw = wrap_angle(state.yaw_rad)
        speed = math.hypot(state.speed_mps, state.lateral_speed_mps)
        step_s = 0.0 if self._last_yaw_rad is None else TICK_S
        yaw_rate = 0.0
        if self._last_yaw_rad is not None:
            yaw_rate = wrap_angle(yaw - self._last_yaw_rad) / TICK_S
        self._last_yaw_rad = yaw
        self._path.update(rows)
        preview_m = self._speed_control.preview_m(speed)
        target = self._path.nearest(state.x_m, state.y_m, preview_m)
        acceleration = self._speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, step_s
        )
        throttle, brake = self._pedal_map.pedals(acceleration)
        wheel_angle = self._steering.wheel_angle(
            self._path, state.x_m, state.y_m, yaw, speed, yaw_rate
        )
        steer, _ = self._steering_map.command(wheel_angle, speed)
        return VehicleCommand(throttle, steer, brake)


def drive_offline(
    route_m: np.ndarray,
    offset_m: float = 0.0,
    turned_rad: float = 0.0,
    steering_method: str = "stanley_compensated",
    vehicle: str = "tesla_model3",
    longest_s: float = LIMITS.timeout_s,
    planned_speed_mps: float | None = None,
) -> OfflineDrive:
    """Drive along a route from standstill, until the drive ends.

    Args:
        route_m: (N, 2) waypoints [m]
        offset_m: distance of the start from the route, positive left [m]
        turned_rad: heading at the start, relative to the route [rad]
        steering_method: name of a method in config/simple_controller.yaml
        vehicle: name of a file in sdc_sim/config/vehicles
        longest_s: simulated time after which to stop [s]
        planned_speed_mps: speed on a free straight, None for that of the configuration [m/s]
    """
    stack = OfflineStack(route_m, steering_method, planned_speed_mps)
    car = Vehicle(vehicle_preset(vehicle))
    route = road_route(route_m)
    (x, y), (next_x, next_y) = route.points[:2].tolist()
    heading = math.atan2(next_y - y, next_x - x)
    car.reset(
        x - offset_m * math.sin(heading), y + offset_m * math.cos(heading), heading + turned_rad
    )

    ideal = IdealDrive(route, stack.limits)
    drive = OfflineDrive(RouteProgress(route, LIMITS), ideal.duration_s)
    tick = 0
    while drive.progress.status is None and tick * TICK_S < longest_s:
        state = car.state
        speed = math.hypot(state.speed_mps, state.lateral_speed_mps)
        yaw = wrap_angle(state.yaw_rad)
        drive.progress.update(tick * TICK_S, state.x_m, state.y_m, yaw, speed)
        command = stack.command(stack.plan(state), state)
        drive.steers.append(command.steer)
        car.step(command, TICK_S)
        tick += 1
    drive.ideal_duration_s = ideal.least_time_s(
        drive.progress.column("s_m"), drive.progress.column("cross_track_m")
    )
    return drive
