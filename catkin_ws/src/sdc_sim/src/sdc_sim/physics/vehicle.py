"""A vehicle on a flat road: its commands, its state, and the integration of its motion.

docs/physics.md describes the model and its validation.

Frames follow REP 103: x forward, y left, yaw counter-clockwise. Positive steer turns right, as in
CARLA.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import cos, sin

from sdc_common.validation import check_between
from sdc_sim.physics.piecewise_linear import evaluate, linear_segments
from sdc_sim.physics.vehicle_dynamics import (
    AIR_DENSITY_KGPM3,
    GRAVITY_MPS2,
    DynamicsConstants,
    derivatives_function,
    fastest_rate_per_s,
)
from sdc_sim.physics.vehicle_parameters import VehicleParameters

# With locked wheels, a sideways motion below this (m/s and rad/s) is static friction: it ends.
STICTION = 0.02
STANDSTILL_SUBSTEPS = 5
_MAX_WIND_MPS = 75.0
# Longest integration step unless a vehicle is given another one.
INTERNAL_STEP_S = 0.005
_MAX_INTERNAL_STEP_S = 0.01


@dataclass
class VehicleCommand:
    """Demands of a driver: throttle and brake 0..1, steer -1..1 with positive to the RIGHT."""

    throttle: float = 0.0
    steer: float = 0.0
    brake: float = 0.0
    hand_brake: bool = False
    reverse: bool = False

    def clamped(self) -> tuple[VehicleCommand, bool]:
        """Return the command within its ranges, and whether it was outside them.

        Raises:
            ValueError: a value is NaN or infinite
        """
        if 0.0 <= self.throttle <= 1.0 and -1.0 <= self.steer <= 1.0 and 0.0 <= self.brake <= 1.0:
            return self, False
        for name in ("throttle", "steer", "brake"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"command refused: {name} is {getattr(self, name)}")
        limited = VehicleCommand(
            min(max(self.throttle, 0.0), 1.0),
            min(max(self.steer, -1.0), 1.0),
            min(max(self.brake, 0.0), 1.0),
            self.hand_brake,
            self.reverse,
        )
        return limited, True


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
        internal_step_s: longest integration step (Heun's method); `step` divides its duration

    Raises:
        ValueError: a value is not a number or out of range, or the internal step is too long for
            the stiffness of the tyres
    """

    def __init__(
        self,
        parameters: VehicleParameters,
        friction: float = 1.0,
        side_wind_mps: float = 0.0,
        internal_step_s: float = INTERNAL_STEP_S,
    ):
        longest = min(_MAX_INTERNAL_STEP_S, 2.0 / fastest_rate_per_s(parameters))
        if not 0.0 < internal_step_s <= longest:
            raise ValueError(
                f"internal_step_s must be in 0..{longest:.4g} s for this vehicle, "
                f"got {internal_step_s}"
            )
        self.parameters = parameters
        self.internal_step_s = internal_step_s
        self.state = VehicleState()
        self.set_conditions(friction, side_wind_mps)

    def set_conditions(self, friction: float, side_wind_mps: float) -> None:
        """Set the factor of the tyres' grip and the side wind from now on.

        Raises:
            ValueError: a value is not a number or out of range; nothing changes
        """
        check_between(1e-3, 100.0, friction=friction)
        check_between(-_MAX_WIND_MPS, _MAX_WIND_MPS, side_wind_mps=side_wind_mps)
        self.friction = friction
        self.side_wind_mps = side_wind_mps
        self._integrator = _Integrator(self.parameters, friction, side_wind_mps)

    def reset(self, x_m: float, y_m: float, yaw_rad: float, speed_mps: float = 0.0) -> None:
        """Place the vehicle with straight wheels and released pedals, moving at this speed.

        Raises:
            ValueError: a value is NaN or infinite
        """
        for name, value in (
            ("x_m", x_m),
            ("y_m", y_m),
            ("yaw_rad", yaw_rad),
            ("speed_mps", speed_mps),
        ):
            if not math.isfinite(value):
                raise ValueError(f"reset refused: {name} is {value}")
        self.state = VehicleState(
            x_m=float(x_m), y_m=float(y_m), yaw_rad=float(yaw_rad), speed_mps=float(speed_mps)
        )

    def step(self, command: VehicleCommand, duration_s: float) -> None:
        """Drive under one command, clamped to its range; `state` becomes a new VehicleState.

        Raises:
            ValueError: the command holds NaN or infinity, or the duration is negative or not
                finite; the state does not change
        """
        if not 0.0 <= duration_s < math.inf:
            raise ValueError(
                f"duration_s must be a finite number of seconds that is not negative, "
                f"got {duration_s}"
            )
        command, _ = command.clamped()
        # A duration below 5 ps is rounding error and adds no step.
        steps = math.ceil(duration_s / self.internal_step_s - 1e-9)
        if self.state.speed_mps == 0.0:
            # A standing vehicle starts to move on a whole step: finer steps keep the error small.
            steps *= STANDSTILL_SUBSTEPS
        if steps:
            self.state = self._integrator.integrate(self.state, command, duration_s / steps, steps)


class _Inputs:
    """Quantities that are constant during one call of `integrate`."""

    __slots__ = (
        "throttle",
        "brake",
        "steer",
        "goals",
        "pedal_change",
        "steer_change",
        "load_gain",
        "rolling_front_n",
        "rolling_rear_n",
    )

    def __init__(self, p: VehicleParameters, command: VehicleCommand, step_s: float):
        self.throttle = float(command.throttle)
        self.brake = float(command.brake)
        self.steer = float(command.steer)
        self.goals = self.throttle, self.brake, self.steer
        self.pedal_change = step_s / p.pedal_travel_s
        self.steer_change = 2.0 * step_s / p.steer_travel_s
        self.load_gain = 1.0 - math.exp(-step_s / p.load_transfer_time_s)
        rolling = p.rolling_resistance * p.mass_kg * GRAVITY_MPS2
        self.rolling_front_n = rolling * p.rear_axle_m / p.wheelbase_m
        self.rolling_rear_n = rolling * p.front_axle_m / p.wheelbase_m
        if command.hand_brake:
            self.rolling_rear_n += p.hand_brake_force_n

    def reached(self, state: VehicleState) -> bool:
        """Return whether pedals and steering are where the command wants them."""
        return (state.throttle, state.brake, state.steer) == self.goals


class _Integrator:
    """Integrates the state of one vehicle with Heun's method."""

    def __init__(self, p: VehicleParameters, friction: float, side_wind_mps: float):
        self._p = p
        self._derivatives = derivatives_function(DynamicsConstants.of(p, friction, side_wind_mps))
        self._brake_front_n = p.brake_force_n * p.brake_front_share
        self._brake_rear_n = p.brake_force_n - self._brake_front_n
        weight_n = p.mass_kg * GRAVITY_MPS2
        wind_n = 0.5 * AIR_DENSITY_KGPM3 * p.side_drag_area_m2 * side_wind_mps**2
        self._tyres_hold_wind = wind_n < friction * p.tyre_friction * weight_n
        self._drive_segments = linear_segments(p.throttle_points, p.drive_forces_n)
        full_rad = p.max_wheel_angle_rad * p.steer_effectiveness
        self._steer_segments = linear_segments(
            p.steer_speeds_mps, [full_rad * share for share in p.steer_shares]
        )

    def integrate(
        self, start: VehicleState, command: VehicleCommand, step_s: float, steps: int
    ) -> VehicleState:
        """Return the state after so many steps under one command."""
        state = VehicleState(**vars(start))
        inputs = _Inputs(self._p, command, step_s)
        rear_share = 1.0 if command.hand_brake else self._p.pedal_grip_share
        drive_front_share, steer_segments = self._p.drive_front_share, self._steer_segments
        speed_rate = (
            state.longitudinal_acceleration_mps2 + state.lateral_speed_mps * state.yaw_rate_radps
        )
        moving, pull_n = True, 0.0
        for _ in range(steps):
            if moving:
                throttle, brake, steer = _move_actuators(state, inputs)
                moving = (throttle, brake, steer) != inputs.goals or not inputs.reached(state)
                pull_n = evaluate(throttle, self._drive_segments)
                resist_front_n = inputs.rolling_front_n + brake * self._brake_front_n
                resist_rear_n = inputs.rolling_rear_n + brake * self._brake_rear_n
            middle_speed = abs(state.speed_mps + 0.5 * step_s * speed_rate)
            drive_n = 0.0
            if not command.hand_brake:
                drive_n = self._drive_force(pull_n, throttle, middle_speed)
                if command.reverse:
                    signed_mps = state.speed_mps + 0.5 * step_s * speed_rate
                    drive_n *= -min(max(self._p.reverse_speed_mps + signed_mps, 0.0), 1.0)
            resist_n = resist_front_n + resist_rear_n
            if state.speed_mps == 0.0 and self._stands_still(state, drive_n, resist_n):
                speed_rate = 0.0
                state.longitudinal_acceleration_mps2 = state.lateral_acceleration_mps2 = 0.0
                state.load_transfer_mps2 -= inputs.load_gain * state.load_transfer_mps2
                continue
            direction = share = 1.0
            if not state.speed_mps > 0.0:
                direction, share = self._direction(state, drive_n, resist_n)
            drive_front_n = drive_n * drive_front_share
            angle = -steer * evaluate(middle_speed, steer_segments)
            speed_rate = self._heun_step(
                state,
                (
                    sin(angle),
                    cos(angle),
                    drive_front_n,
                    drive_n - drive_front_n,
                    resist_front_n * share * direction,
                    resist_rear_n * share * direction,
                    rear_share,
                ),
                direction,
                step_s,
                inputs.load_gain,
            )
        state.wheel_angle_rad = -state.steer * evaluate(abs(state.speed_mps), steer_segments)
        return state

    def _drive_force(self, pull_n: float, throttle: float, speed: float) -> float:
        """Return the force of the motor in the forward gear at a speed that is not negative."""
        p = self._p
        creep_n = p.creep_force_n * throttle - p.creep_damping_n_per_mps * speed
        force_n = creep_n if creep_n > pull_n else pull_n
        return p.drive_power_w / speed if force_n * speed > p.drive_power_w else force_n

    def _stands_still(self, state: VehicleState, drive_n: float, resist_n: float) -> bool:
        return (
            state.lateral_speed_mps == 0.0
            and state.yaw_rate_radps == 0.0
            and self._tyres_hold_wind
            and abs(drive_n) <= resist_n
        )

    def _direction(
        self, state: VehicleState, drive_n: float, resist_n: float
    ) -> tuple[float, float]:
        """Return the direction that rolling resistance and brakes act against, and their share.

        They act against the motion, or against the force that starts it, and then not beyond it.
        """
        push, share = state.speed_mps, 1.0
        if push == 0.0:
            push = drive_n + self._p.mass_kg * state.lateral_speed_mps * state.yaw_rate_radps
            if abs(push) < resist_n:
                share = abs(push) / resist_n
        return 1.0 if push > 0.0 else -1.0 if push < 0.0 else 0.0, share

    def _heun_step(
        self,
        state: VehicleState,
        demand: tuple[float, ...],
        direction: float,
        h: float,
        load_gain: float,
    ) -> float:
        """Advance the motion by one step; return the mean rate of the speed in it [m/s^2].

        Args:
            state: the state
            demand: the arguments of `derivatives` from sin_angle on
            direction: direction of the motion that the resistance acts against
            h: duration [s]
            load_gain: share of its way to the longitudinal acceleration that the load moves
        """
        derivatives = self._derivatives
        u, v, r = state.speed_mps, state.lateral_speed_mps, state.yaw_rate_radps
        load = state.load_transfer_mps2
        u_dot_0, v_dot_0, r_dot_0 = derivatives(u, v, r, load, *demand)
        later_load = load + load_gain * (u_dot_0 - v * r - load)
        u_dot_1, v_dot_1, r_dot_1 = derivatives(
            u + h * u_dot_0, v + h * v_dot_0, r + h * r_dot_0, later_load, *demand
        )
        half = 0.5 * h
        u_new = u + half * (u_dot_0 + u_dot_1)
        v_new = v + half * (v_dot_0 + v_dot_1)
        r_new = r + half * (r_dot_0 + r_dot_1)
        if u_new * direction <= 0.0:
            # Resistance stops a motion and never reverses it. A drive force reverses it in the
            # next step.
            u_new = 0.0
            if abs(v_new) < STICTION and abs(r_new) < STICTION and self._tyres_hold_wind:
                v_new = r_new = 0.0

        u_mean, v_mean, r_mean = 0.5 * (u + u_new), 0.5 * (v + v_new), 0.5 * (r + r_new)
        heading = state.yaw_rad + half * r_mean
        cos_heading, sin_heading = cos(heading), sin(heading)
        state.x_m += h * (u_mean * cos_heading - v_mean * sin_heading)
        state.y_m += h * (u_mean * sin_heading + v_mean * cos_heading)
        state.yaw_rad += h * r_mean
        u_dot = (u_new - u) / h
        state.load_transfer_mps2 = load + load_gain * (u_dot - v_mean * r_mean - load)
        state.longitudinal_acceleration_mps2 = u_dot - v_new * r_new
        state.lateral_acceleration_mps2 = (v_new - v) / h + u_new * r_new
        state.speed_mps, state.lateral_speed_mps, state.yaw_rate_radps = u_new, v_new, r_new
        return u_dot


def _move_actuators(state: VehicleState, inputs: _Inputs) -> tuple[float, float, float]:
    """Move throttle, brake and steering for one step; return their mean positions in it.

    The mean, with an arrival inside the step, keeps the integration of second order.
    """
    state.throttle, throttle = _approach(state.throttle, inputs.throttle, inputs.pedal_change)
    state.brake, brake = _approach(state.brake, inputs.brake, inputs.pedal_change)
    state.steer, steer = _approach(state.steer, inputs.steer, inputs.steer_change)
    return throttle, brake, steer


def _approach(position: float, goal: float, max_change: float) -> tuple[float, float]:
    """Return the position after a step at constant rate towards the goal, and its mean."""
    change = goal - position
    if change < -max_change:
        change = -max_change
    elif change > max_change:
        change = max_change
    position += change
    return position, position - 0.5 * change * abs(change) / max_change
