"""The motion of a vehicle from tick to tick, in functions of numbers.

A Vehicle calls them as they are; the module `fleet` has them in machine code, for the same numbers.
"""

from __future__ import annotations

import math
from math import cos, sin
from typing import Tuple

from sdc_common.piecewise_linear import evaluate
from sdc_sim.physics.vehicle_dynamics import Demand, MotionConstants, derivatives

# The values of a VehicleState, in its order.
Motion = Tuple[float, ...]

STANDSTILL_SUBSTEPS = 5
# With locked wheels, a sideways motion below this (m/s and rad/s) is static friction: it ends.
STICTION = 0.02


def step_count(speed_mps: float, duration_s: float, internal_step_s: float) -> int:
    """Return in how many integration steps a duration is divided."""
    # A duration below 5 ps is rounding error and adds no step.
    steps = math.ceil(duration_s / internal_step_s - 1e-9)
    # A standing vehicle starts to move on a whole step: finer steps keep the error small.
    return steps * STANDSTILL_SUBSTEPS if speed_mps == 0.0 else steps


def integrate(
    c: MotionConstants,
    state: Motion,
    goals: tuple[float, float, float],
    hand_brake: bool,
    reverse: bool,
    h: float,
    steps: int,
) -> Motion:
    """Return the state after so many steps of Heun's method under one command.

    Args:
        c: the vehicle
        state: the state at the start
        goals: demanded throttle, brake and steer
        hand_brake: whether the hand brake is on
        reverse: whether the reverse gear is in
        h: duration of a step [s]
        steps: number of steps
    """
    x, y, yaw, u, v, r, _, throttle, brake, ahead, left, steer, load = state
    rear_share = 1.0 if hand_brake else c.pedal_grip_share
    rolling_rear_n = c.rolling_rear_n + (c.hand_brake_force_n if hand_brake else 0.0)
    changes = h / c.pedal_travel_s, 2.0 * h / c.steer_travel_s
    load_gain = 1.0 - math.exp(-h / c.load_transfer_time_s)
    speed_rate = ahead + v * r
    moving = True
    for _ in range(steps):
        if moving:
            throttle, mid_throttle = approach(throttle, goals[0], changes[0])
            brake, mid_brake = approach(brake, goals[1], changes[0])
            steer, mid_steer = approach(steer, goals[2], changes[1])
            moving = (mid_throttle, mid_brake, mid_steer) != goals  # which arrive last
            pull_n = evaluate(mid_throttle, c.drive_segments)
            resist_front_n = c.rolling_front_n + mid_brake * c.brake_front_n
            resist_rear_n = rolling_rear_n + mid_brake * c.brake_rear_n
        middle = u + 0.5 * h * speed_rate
        drive_n = 0.0 if hand_brake else drive_force(c, pull_n, mid_throttle, middle, reverse)
        resist_n = resist_front_n + resist_rear_n
        if u == 0.0 and v == 0.0 and r == 0.0 and c.tyres_hold_wind and abs(drive_n) <= resist_n:
            speed_rate = ahead = left = 0.0
            load -= load_gain * load
            continue
        direction = share = 1.0
        if not u > 0.0:
            direction, share = resistance(c.mass_kg, u, v * r, drive_n, resist_n)
        drive_front = drive_n * c.drive_front_share
        angle = -mid_steer * evaluate(abs(middle), c.steer_segments)
        # fmt: off
        demand = (
            sin(angle), cos(angle), drive_front, drive_n - drive_front,
            resist_front_n * share * direction, resist_rear_n * share * direction, rear_share,
        )
        # fmt: on
        x, y, yaw, u, v, r, load, speed_rate, left = heun_step(
            c, (x, y, yaw, u, v, r, load), demand, direction, h, load_gain
        )
        ahead = speed_rate - v * r
    wheel_angle = -steer * evaluate(abs(u), c.steer_segments)
    return x, y, yaw, u, v, r, wheel_angle, throttle, brake, ahead, left, steer, load


def approach(position: float, goal: float, max_change: float) -> tuple[float, float]:
    """Return the position after a step at constant rate towards the goal, and its mean.

    The mean, with an arrival inside the step, keeps the integration of second order.
    """
    change = goal - position
    if change < -max_change:
        change = -max_change
    elif change > max_change:
        change = max_change
    position += change
    return position, position - 0.5 * change * abs(change) / max_change


def drive_force(
    c: MotionConstants, pull_n: float, throttle: float, speed: float, reverse: bool
) -> float:
    """Return the force of the motor at a speed; backwards, it falls to zero at a speed limit."""
    amount = abs(speed)
    creep_n = c.creep_force_n * throttle - c.creep_damping_n_per_mps * amount
    force_n = creep_n if creep_n > pull_n else pull_n
    if force_n * amount > c.drive_power_w:
        force_n = c.drive_power_w / amount
    if reverse:
        force_n *= -min(max(c.reverse_speed_mps + speed, 0.0), 1.0)
    return force_n


def resistance(
    mass_kg: float, speed: float, centripetal_mps2: float, drive_n: float, resist_n: float
) -> tuple[float, float]:
    """Return the direction that rolling resistance and brakes act against, and their share.

    They act against the motion, or against the force that starts it, and then not beyond it.
    """
    push, share = speed, 1.0
    if push == 0.0:
        push = drive_n + mass_kg * centripetal_mps2
        if abs(push) < resist_n:
            share = abs(push) / resist_n
    return 1.0 if push > 0.0 else -1.0 if push < 0.0 else 0.0, share


def heun_step(
    c: MotionConstants,
    start: tuple[float, ...],
    demand: Demand,
    direction: float,
    h: float,
    load_gain: float,
) -> tuple[float, ...]:
    """Advance the motion by one step.

    Args:
        c: the vehicle
        start: x, y, yaw, speed, lateral speed, yaw rate and load transfer
        demand: what the driver demands in this step
        direction: direction of the motion that the resistance acts against
        h: duration [s]
        load_gain: share of its way to the longitudinal acceleration that the load moves

    Returns:
        the same seven, the mean rate of the speed [m/s^2] and the lateral acceleration [m/s^2]
    """
    x, y, yaw, u, v, r, load = start
    u_dot_0, v_dot_0, r_dot_0 = derivatives(c, u, v, r, load, demand)
    later_load = load + load_gain * (u_dot_0 - v * r - load)
    u_dot_1, v_dot_1, r_dot_1 = derivatives(
        c, u + h * u_dot_0, v + h * v_dot_0, r + h * r_dot_0, later_load, demand
    )
    half = 0.5 * h
    u_new = u + half * (u_dot_0 + u_dot_1)
    v_new = v + half * (v_dot_0 + v_dot_1)
    r_new = r + half * (r_dot_0 + r_dot_1)
    if u_new * direction <= 0.0:
        # Resistance stops a motion and never reverses it. A drive force reverses it in the
        # next step.
        u_new = 0.0
        if abs(v_new) < STICTION and abs(r_new) < STICTION and c.tyres_hold_wind:
            v_new = r_new = 0.0
    u_mean, v_mean, r_mean = 0.5 * (u + u_new), 0.5 * (v + v_new), 0.5 * (r + r_new)
    heading = yaw + half * r_mean
    cos_heading, sin_heading = cos(heading), sin(heading)
    u_dot = (u_new - u) / h
    return (
        x + h * (u_mean * cos_heading - v_mean * sin_heading),
        y + h * (u_mean * sin_heading + v_mean * cos_heading),
        yaw + h * r_mean,
        u_new,
        v_new,
        r_new,
        load + load_gain * (u_dot - v_mean * r_mean - load),
        u_dot,
        (v_new - v) / h + u_new * r_new,
    )
