"""A vehicle on a flat road: its commands, its state, and the integration of its motion.

docs/physics.md describes the model and its validation.

Frames follow REP 103: x forward, y left, yaw counter-clockwise. Positive steer turns right, as in
CARLA.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

from sdc_common.driving import Command
from sdc_sim.physics.vehicle_dynamics import MotionConstants, fastest_rate_per_s
from sdc_sim.physics.vehicle_motion import integrate, step_count
from sdc_sim.physics.vehicle_parameters import VehicleParameters

# Longest step of the integration (Heun's method); `Vehicle.step` divides its duration.
INTERNAL_STEP_S = 0.005


@dataclass
class VehicleState:
    """Pose and motion of a vehicle. The reference point is the centre of gravity, on the ground.

    yaw_rad is not wrapped. Speeds are in the body frame (forward, left). wheel_angle_rad is the
    front wheel angle of the single-track model, positive LEFT. throttle, brake and steer are the
    present positions of pedals and steering. The accelerations are what an accelerometer at the
    centre of gravity measures (forward, left). load_transfer_mps2 is the longitudinal acceleration
    that the pitching body follows.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    speed_mps: float = 0.0
    lateral_speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    wheel_angle_rad: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0
    longitudinal_acceleration_mps2: float = 0.0
    lateral_acceleration_mps2: float = 0.0
    steer: float = 0.0
    load_transfer_mps2: float = 0.0


class Vehicle:
    """A vehicle on a flat road. Equal calls give equal numbers, bit for bit.

    Args:
        parameters: the vehicle
        friction: factor of the tyres' grip (1 dry, about 0.6 wet, 0.2 ice)
        side_wind_mps: side wind, positive towards the left of the vehicle

    Raises:
        ValueError: the tyres are too stiff for the integration
    """

    def __init__(
        self, parameters: VehicleParameters, friction: float = 1.0, side_wind_mps: float = 0.0
    ):
        if not INTERNAL_STEP_S * fastest_rate_per_s(parameters) <= 2.0:
            raise ValueError(
                "the cornering stiffness is too high for the mass and the yaw inertia; reduce it"
            )
        self.parameters = parameters
        self.state = VehicleState()
        self._integrate: Callable[..., Any] = integrate
        self.set_conditions(friction, side_wind_mps)

    def set_conditions(self, friction: float, side_wind_mps: float) -> None:
        """Set the factor of the tyres' grip and the side wind from now on."""
        self.friction = friction
        self.side_wind_mps = side_wind_mps
        self._constants: Any = MotionConstants.of(self.parameters, friction, side_wind_mps)

    def reset(self, x_m: float, y_m: float, yaw_rad: float, speed_mps: float = 0.0) -> None:
        """Place the vehicle with straight wheels and released pedals, moving at this speed."""
        self.state = VehicleState(
            x_m=float(x_m), y_m=float(y_m), yaw_rad=float(yaw_rad), speed_mps=float(speed_mps)
        )

    def step(self, command: Command, duration_s: float) -> None:
        """Drive under one command, clamped to its range; `state` becomes a new VehicleState.

        Raises:
            ValueError: the command holds NaN or infinity; the state does not change
        """
        command, _ = command.clamped()
        steps = step_count(self.state.speed_mps, duration_s, INTERNAL_STEP_S)
        if steps:
            goals = float(command.throttle), float(command.brake), float(command.steer)
            self.state = VehicleState(
                *self._integrate(
                    self._constants,
                    tuple(vars(self.state).values()),
                    goals,
                    command.hand_brake,
                    command.reverse,
                    duration_s / steps,
                    steps,
                )
            )
