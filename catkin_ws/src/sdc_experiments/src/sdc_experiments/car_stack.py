"""The algorithms of the car's nodes, called once a tick in one process, without ROS.

Numbers are rounded as in the messages between the nodes: a drive equals that of the nodes in
lockstep, bit for bit.
"""

from __future__ import annotations

import math
import struct
from typing import Any, Callable, Mapping, Protocol, Sequence, Union

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_experiments.configuration import node_parameters
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner, PlannerSettings
from sdc_package.obstacles import DetectedObstacle
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of
from sdc_package.steering.method import Steering
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLights
from sdc_sim.physics.vehicle import VehicleCommand
from sdc_sim.ros.message_conversion import light_info_message
from sdc_sim.scenario.packaged import overridden
from sdc_sim.simulation.simulation import Observation

_NO_OPTIONS: Mapping[str, Any] = {}
# See InputPairing.
_MAX_STEP_S = 0.2
_THREE_FLOAT32 = struct.Struct("<fff")

# (x, y, target speed) of each point of the path ahead [m, m, m/s].
Rows = Sequence[Sequence[float]]
# A name of config/simple_controller.yaml, a method, or a function like Steering.wheel_angle.
SteeringSource = Union[str, Steering, Callable[..., float]]


class Planner(Protocol):
    """Plans the path ahead."""

    def __call__(self, observation: Observation) -> Rows:
        """Return two or more points of the path ahead of the car.

        Raises:
            OffRouteError: the car is too far from its route to join it
        """
        raise NotImplementedError


def pose_and_speed(observation: Observation) -> tuple[float, float, float, float]:
    """Return x [m], y [m], yaw [rad] and speed [m/s] as a node reads them from the odometry."""
    state = observation.measured
    speed = math.hypot(state.speed_mps, state.lateral_speed_mps)
    return state.x_m, state.y_m, yaw_of_quaternion(state.yaw_rad), speed


def yaw_of_quaternion(yaw_rad: float) -> float:
    """Return a yaw after its conversion to a quaternion and back."""
    z, w = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)
    return math.atan2(2.0 * (w * z + 0.0), 1.0 - 2.0 * (0.0 + z * z))


class CarPlanner:
    """The local planner of the car.

    Args:
        waypoints_m: (N, 2) waypoints of the mission [m]
        options: parameters that replace those of config/local_planner.yaml
        lights: the traffic lights of the world

    Attributes:
        parameters: parameters of the node
        reason: what limits the speed, see speed_reasons
    """

    def __init__(
        self,
        waypoints_m: np.ndarray,
        options: Mapping[str, Any] = _NO_OPTIONS,
        lights: TrafficLights | None = None,
    ):
        self.parameters = overridden(node_parameters("local_planner"), options, "planner_options")
        settings = PlannerSettings.read(self.parameters.__getitem__)
        self._planner = LocalPlanner(mission_of(waypoints_m), settings)
        self._search = WaypointSearch(self._planner.route.points)
        self._lights = TrafficLightMonitor(settings.traffic_lights)
        self._planned = np.empty((0, 3))
        self._rows: Rows = ()
        if lights is not None and lights.plans:
            self._lights.set_lines(light_info_message(lights.plans, lights.states(0.0)))

    @property
    def reason(self) -> str:
        """What limits the speed at the start of the last path."""
        return self._planner.reason

    def __call__(self, observation: Observation) -> Rows:
        """See Planner."""
        x, y, yaw, speed = pose_and_speed(observation)
        self._lights.set_states(observation.traffic_lights, stamped=True)
        first = self._search.first_ahead(x, y)
        rows = self._planner.plan(first, x, y, yaw, [*map(_detected, observation.obstacles)])
        rows = self._planner.stop_for(self._lights, rows, speed)
        if rows is not self._planned:
            self._planned = rows
            self._rows = tuple(map(tuple, rows.astype(np.float32).tolist()))
        return self._rows


def mission_of(waypoints_m: np.ndarray) -> np.ndarray:
    """Return waypoints as the nodes receive them."""
    return np.asarray(waypoints_m).astype(np.float32).astype(float)


def _detected(one: ObstacleState) -> DetectedObstacle:
    yaw, speed = yaw_of_quaternion(one.yaw_rad), float(np.float32(one.speed_mps))
    return DetectedObstacle(one.x_m, one.y_m, yaw, one.length_m, one.width_m, speed)


class CarController:
    """The controller of the car.

    Args:
        steering: steering method, None for that of config/simple_controller.yaml
        options: parameters that replace those of config/simple_controller.yaml

    Raises:
        ValueError: the steering method cannot be built, or a parameter is not valid
    """

    def __init__(
        self,
        steering: SteeringSource | None = None,
        options: Mapping[str, Any] = _NO_OPTIONS,
    ):
        config = node_parameters("simple_controller")
        method = options.get("steering_method", config["steering_method"])
        method = method if steering is None else steering
        section = section_of(method) if isinstance(method, str) else ""
        if section not in config and section in options:
            # The section of a method that is not one of this project.
            config[section] = options[section]
            options = {name: value for name, value in options.items() if name != section}
        config = overridden(config, options, "controller_options")
        if isinstance(method, str):
            method = load_steering(method, config.get(section), Axles(**config["axles"]))
        self._wheel_angle: Callable[..., float] = getattr(method, "wheel_angle", method)
        if not callable(self._wheel_angle):
            raise ValueError(
                "steering: must be a name, an object with a method wheel_angle or a function, "
                f"got {method!r}"
            )
        limits = SpeedControlLimits(**config["limits"])
        self._speed_control = SpeedControl(PidGains(**config["pid"]), limits)
        self._steering_map = SteeringMap(**config["steering"])
        self._pedal_map = PedalMap(**config["pedals"])
        self._patience_s, self._stop_brake = config["patience_s"], config["stop_brake"]
        self._path = ReferencePath()
        self._steer = 0.0
        self._answered: tuple[float, float] | None = None

    def __call__(self, observation: Observation, rows: Rows) -> VehicleCommand:
        """Return the command that answers an observation with this path ahead."""
        seconds, nanoseconds = observation.stamp
        stamp_s = float(seconds) + float(nanoseconds) / 1e9
        x, y, yaw, speed = pose_and_speed(observation)
        step_s = yaw_rate = 0.0
        if self._answered is not None:
            last_s, last_yaw = self._answered
            step_s = min(max(stamp_s - last_s, 0.0), _MAX_STEP_S)
            yaw_rate = wrap_angle(yaw - last_yaw) / step_s if step_s > 0.0 else 0.0
        self._path.update(rows)
        self._answered = stamp_s, yaw
        target = self._path.nearest(x, y, self._speed_control.preview_m(speed))
        acceleration = self._speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, step_s
        )
        throttle, brake = self._pedal_map.pedals(acceleration)
        wheel_angle = self._wheel_angle(self._path, x, y, yaw, speed, yaw_rate)
        self._steer, _ = self._steering_map.command(wheel_angle, speed)
        return _command(throttle, self._steer, brake)

    def stop(self, observation: Observation) -> VehicleCommand | None:
        """Return the command while there is no path: none at first, then that of a stop."""
        seconds, nanoseconds = observation.stamp
        if self._answered is None:
            return None
        if float(seconds) + float(nanoseconds) / 1e9 - self._answered[0] <= self._patience_s:
            return None
        self._speed_control.reset()
        x, y, yaw, speed = pose_and_speed(observation)
        wheel_angle = self._wheel_angle(self._path, x, y, yaw, speed, 0.0)
        self._steer, _ = self._steering_map.command(wheel_angle, speed)
        return _command(0.0, self._steer, self._stop_brake)


def _command(throttle: float, steer: float, brake: float) -> VehicleCommand:
    """Return a command as the message CarlaVehicleControl transports it."""
    return VehicleCommand(*_THREE_FLOAT32.unpack(_THREE_FLOAT32.pack(throttle, steer, brake)))
