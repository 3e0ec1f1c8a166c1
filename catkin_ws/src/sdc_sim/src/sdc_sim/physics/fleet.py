"""Many equal vehicles at once: the physics of `Vehicle`, with NumPy arrays in place of numbers.

The equations are those of vehicle_dynamics and vehicle; a test holds both equal. Arrays cost about
a microsecond an operation, so that a fleet is faster from about a hundred vehicles on.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Callable, NamedTuple

import numpy as np

from sdc_sim.physics.vehicle import (
    INTERNAL_STEP_S,
    STANDSTILL_SUBSTEPS,
    STICTION,
    VehicleState,
)
from sdc_sim.physics.vehicle_dynamics import (
    BLEND_GAIN,
    BLEND_SPEED_MPS,
    GRAVITY_MPS2,
    HALF_BLEND,
    DynamicsConstants,
)
from sdc_sim.physics.vehicle_parameters import VehicleParameters

FIELDS = tuple(VehicleState.__dataclass_fields__)
# Vehicles that are computed together: their arrays fit into the cache of a core.
_BLOCK = 4096
_LEAST_BLOCK = 1024


class _Motion(NamedTuple):
    """Speed, lateral speed, yaw rate and load transfer of all vehicles, (N,) each."""

    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    load: np.ndarray


class _Demand(NamedTuple):
    """Arguments of the derivatives that do not change in a step, (N,) each."""

    sin_angle: np.ndarray
    cos_angle: np.ndarray
    drive_front: np.ndarray
    drive_rear: np.ndarray
    resist_front: np.ndarray
    resist_rear: np.ndarray


class VehicleFleet:
    """N equal vehicles on a flat road without wind, in the forward gear.

    Args:
        parameters: the vehicle
        count: number of vehicles, N
        friction: factor of the tyres' grip
        threads: number of threads that share the vehicles

    Attributes:
        state: (N,) array of each field of VehicleState, by name
    """

    def __init__(
        self, parameters: VehicleParameters, count: int, friction: float = 1.0, threads: int = 1
    ):
        self.parameters = parameters
        self.state = {name: np.zeros(count) for name in FIELDS}
        self._integrator = _FleetIntegrator(parameters, friction)
        # With small arrays, threads only wait for each other.
        threads = max(1, min(threads, count // _LEAST_BLOCK))
        blocks = max(threads, math.ceil(count / _BLOCK))
        bounds = np.linspace(0, count, blocks + 1).astype(int).tolist()
        self._blocks = [slice(*pair) for pair in zip(bounds, bounds[1:])]
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def reset(
        self, rows: np.ndarray, x_m: np.ndarray, y_m: np.ndarray, yaw_rad: np.ndarray
    ) -> None:
        """Place some vehicles at rest; `rows` are their indices or a mask."""
        for values in self.state.values():
            values[rows] = 0.0
        self.state["x_m"][rows] = x_m
        self.state["y_m"][rows] = y_m
        self.state["yaw_rad"][rows] = yaw_rad

    def step(
        self, throttle: np.ndarray, brake: np.ndarray, steer: np.ndarray, duration_s: float
    ) -> None:
        """Drive all vehicles under one command each; see VehicleCommand for the ranges."""

        def drive(block: slice) -> None:
            state = {name: values[block] for name, values in self.state.items()}
            goals = throttle[block], brake[block], steer[block]
            self._integrator.integrate(state, goals, duration_s)

        if self._pool is None:
            for block in self._blocks:
                drive(block)
        else:
            list(self._pool.map(drive, self._blocks))


class _FleetIntegrator:
    """Integrates the states of equal vehicles with Heun's method."""

    def __init__(self, p: VehicleParameters, friction: float):
        self._p = p
        self._derivatives = _derivatives_function(
            DynamicsConstants.of(p, friction, 0.0), p.pedal_grip_share
        )
        self._brake_front_n = p.brake_force_n * p.brake_front_share
        self._brake_rear_n = p.brake_force_n - self._brake_front_n
        rolling_n = p.rolling_resistance * p.mass_kg * GRAVITY_MPS2
        self._rolling_front_n = rolling_n * p.rear_axle_m / p.wheelbase_m
        self._rolling_rear_n = rolling_n * p.front_axle_m / p.wheelbase_m
        self._full_rad = p.max_wheel_angle_rad * p.steer_effectiveness

    def integrate(
        self, state: dict[str, np.ndarray], goals: tuple[np.ndarray, ...], duration_s: float
    ) -> None:
        """Advance all vehicles of a block in place."""
        steps = math.ceil(duration_s / INTERNAL_STEP_S - 1e-9)
        standing = state["speed_mps"] == 0.0
        if not standing.any():
            self._integrate(state, goals, duration_s / steps, steps)
            return
        for mask, factor in ((standing, STANDSTILL_SUBSTEPS), (~standing, 1)):
            if mask.any():
                part = {name: values[mask] for name, values in state.items()}
                count = steps * factor
                self._integrate(
                    part, tuple(goal[mask] for goal in goals), duration_s / count, count
                )
                for name, values in part.items():
                    state[name][mask] = values

    def _integrate(
        self, state: dict[str, np.ndarray], goals: tuple[np.ndarray, ...], h: float, steps: int
    ) -> None:
        p = self._p
        load_gain = 1.0 - math.exp(-h / p.load_transfer_time_s)
        changes = h / p.pedal_travel_s, h / p.pedal_travel_s, 2.0 * h / p.steer_travel_s
        speed_rate = (
            state["longitudinal_acceleration_mps2"]
            + state["lateral_speed_mps"] * state["yaw_rate_radps"]
        )
        moving = True
        for _ in range(steps):
            if moving:
                throttle, brake, steer = (
                    _approach(state[name], goal, change)
                    for name, goal, change in zip(("throttle", "brake", "steer"), goals, changes)
                )
                means = throttle, brake, steer
                moving = not all(map(np.array_equal, means, goals))
                pull_n = np.interp(throttle, p.throttle_points, p.drive_forces_n)
                resist_front = self._rolling_front_n + brake * self._brake_front_n
                resist_rear = self._rolling_rear_n + brake * self._brake_rear_n
            speed_rate = self._step(
                state, pull_n, throttle, steer, resist_front, resist_rear, speed_rate, h, load_gain
            )
        shares = np.interp(np.abs(state["speed_mps"]), p.steer_speeds_mps, p.steer_shares)
        state["wheel_angle_rad"][:] = -state["steer"] * self._full_rad * shares

    def _step(
        self,
        state: dict[str, np.ndarray],
        pull_n: np.ndarray,
        throttle: np.ndarray,
        steer: np.ndarray,
        resist_front: np.ndarray,
        resist_rear: np.ndarray,
        speed_rate: np.ndarray,
        h: float,
        load_gain: float,
    ) -> np.ndarray:
        """Advance by one step; return the mean rates of the speeds in it [m/s^2]."""
        p = self._p
        speed = state["speed_mps"]
        middle = np.abs(speed + 0.5 * h * speed_rate)
        creep_n = p.creep_force_n * throttle - p.creep_damping_n_per_mps * middle
        drive_n = np.maximum(pull_n, creep_n)
        if (drive_n * middle).max() > p.drive_power_w:
            drive_n = np.minimum(drive_n, p.drive_power_w / np.maximum(middle, 1e-9))
        direction = np.sign(speed)
        still = None
        if not direction.all():
            resist = resist_front + resist_rear
            halted = direction == 0.0
            side = state["lateral_speed_mps"] * state["yaw_rate_radps"]
            still = halted & (state["lateral_speed_mps"] == 0.0)
            still &= (state["yaw_rate_radps"] == 0.0) & (np.abs(drive_n) <= resist)
            push = drive_n + p.mass_kg * side
            share = np.where(halted, np.minimum(np.abs(push) / resist, 1.0), 1.0)
            direction = np.where(halted, np.sign(push), direction)
            resist_front, resist_rear = resist_front * share, resist_rear * share
        drive_front = drive_n * p.drive_front_share
        shares = np.interp(middle, p.steer_speeds_mps, p.steer_shares)
        angle = -steer * (self._full_rad * shares)
        demand = _Demand(
            np.sin(angle),
            np.cos(angle),
            drive_front,
            drive_n - drive_front,
            resist_front * direction,
            resist_rear * direction,
        )
        return self._heun_step(state, demand, direction, still, h, load_gain)

    def _heun_step(
        self,
        state: dict[str, np.ndarray],
        demand: _Demand,
        direction: np.ndarray,
        still: np.ndarray | None,
        h: float,
        load_gain: float,
    ) -> np.ndarray:
        u, v, r, load = start = _Motion(
            state["speed_mps"].copy(),
            state["lateral_speed_mps"].copy(),
            state["yaw_rate_radps"].copy(),
            state["load_transfer_mps2"].copy(),
        )
        u_0, v_0, r_0 = self._derivatives(start, demand)
        later = _Motion(
            u + h * u_0, v + h * v_0, r + h * r_0, load + load_gain * (u_0 - v * r - load)
        )
        u_1, v_1, r_1 = self._derivatives(later, demand)
        half = 0.5 * h
        u_new, v_new, r_new = u + half * (u_0 + u_1), v + half * (v_0 + v_1), r + half * (r_0 + r_1)
        stops = u_new * direction <= 0.0
        if stops.any():
            u_new[stops] = 0.0
            calm = stops & (np.abs(v_new) < STICTION) & (np.abs(r_new) < STICTION)
            v_new[calm] = r_new[calm] = 0.0
        if still is not None and still.any():
            for new in (u_new, v_new, r_new):
                new[still] = 0.0
        u_mean, v_mean, r_mean = 0.5 * (u + u_new), 0.5 * (v + v_new), 0.5 * (r + r_new)
        heading = state["yaw_rad"] + half * r_mean
        c, s = np.cos(heading), np.sin(heading)
        state["x_m"] += h * (u_mean * c - v_mean * s)
        state["y_m"] += h * (u_mean * s + v_mean * c)
        state["yaw_rad"] += h * r_mean
        rate = (u_new - u) / h
        state["load_transfer_mps2"][:] = load + load_gain * (rate - v_mean * r_mean - load)
        state["longitudinal_acceleration_mps2"][:] = rate - v_new * r_new
        state["lateral_acceleration_mps2"][:] = (v_new - v) / h + u_new * r_new
        state["speed_mps"][:] = u_new
        state["lateral_speed_mps"][:] = v_new
        state["yaw_rate_radps"][:] = r_new
        return rate


def _approach(position: np.ndarray, goal: np.ndarray, max_change: float) -> np.ndarray:
    """Move positions in place at a constant rate towards their goals; return their means."""
    change = np.minimum(np.maximum(goal - position, -max_change), max_change)
    position += change
    return position - 0.5 * change * np.abs(change) / max_change


def _tyre_force_function(shape: float, stiffness: float) -> Callable[..., tuple[np.ndarray, ...]]:
    """Return the function of the forces of an axle; see tyre_force_function."""

    def forces(
        rolling: np.ndarray,
        sliding: np.ndarray,
        demand: np.ndarray,
        grip: np.ndarray,
        usable_grip: np.ndarray,
    ) -> tuple[np.ndarray, ...]:
        speed = np.abs(rolling)
        slow = speed < BLEND_SPEED_MPS
        reference = speed
        if slow.any():
            reference = np.where(slow, HALF_BLEND + BLEND_GAIN * speed * speed, speed)
        total = np.sqrt(rolling * rolling + sliding * sliding)
        straight = np.abs(sliding) <= 1e-9
        if straight.any():
            speed = np.where(straight, 1.0, speed)
            total[straight] = 1.0
        limit = usable_grip * (speed / total)
        demand = np.minimum(np.maximum(demand, -limit), limit)
        used = demand / grip
        left = np.sqrt(np.maximum(1.0 - used * used, 0.0))
        lateral = np.arctan(sliding / reference)
        lateral *= stiffness
        np.arctan(lateral, out=lateral)
        lateral *= shape
        np.sin(lateral, out=lateral)
        lateral *= left
        lateral *= grip
        return demand, np.negative(lateral, out=lateral)

    return forces


def _derivatives_function(
    c: DynamicsConstants, rear_share: float
) -> Callable[[_Motion, _Demand], tuple[np.ndarray, ...]]:
    """Return the function of the time derivatives of the motions; see derivatives_function."""
    front_forces = _tyre_force_function(c.shape, c.stiffness_front)
    rear_forces = _tyre_force_function(c.shape, c.stiffness_rear)

    def derivatives(motion: _Motion, demand: _Demand) -> tuple[np.ndarray, ...]:
        u, v, r, load_transfer = motion
        sin_angle, cos_angle, drive_front, drive_rear, resist_front, resist_rear = demand
        load = c.load_front_n - c.load_per_acceleration_kg * load_transfer
        load = np.minimum(np.maximum(load, c.min_load_front_n), c.max_load_front_n)
        grip_front = c.mu * load
        grip_rear = c.total_grip_n - grip_front
        axle = v + c.front_m * r
        rolling = u * cos_angle + axle * sin_angle
        against = rolling * resist_front < 0.0
        force = drive_front - resist_front
        if against.any():
            force = np.where(against, drive_front, force)
        fx_front, fy_front = front_forces(
            rolling,
            axle * cos_angle - u * sin_angle,
            force,
            grip_front,
            c.front_grip_share * grip_front,
        )
        fx_rear, fy_rear = rear_forces(
            u, v - c.rear_m * r, drive_rear - resist_rear, grip_rear, rear_share * grip_rear
        )
        air = -v - c.wind_arm_m * r
        fy_air = c.side_drag_kgpm * air * np.abs(air)
        fx_body = fx_front * cos_angle - fy_front * sin_angle + fx_rear
        fx_body -= c.drag_kgpm * u * np.abs(u)
        fy_body = fx_front * sin_angle + fy_front * cos_angle
        return (
            fx_body / c.mass_kg + v * r,
            (fy_body + fy_rear + fy_air) / c.mass_kg - u * r,
            (c.front_m * fy_body - c.rear_m * fy_rear + c.wind_arm_m * fy_air) / c.inertia_kgm2,
        )

    return derivatives
