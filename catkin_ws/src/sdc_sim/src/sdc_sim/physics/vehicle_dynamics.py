"""Equations of motion of a dynamic single-track model with saturating tyres.

Model: Rajamani, Vehicle Dynamics and Control, chapter 2.3, without small-angle approximations.
Tyre: Pacejka, Tyre and Vehicle Dynamics, chapter 4.3 (Magic Formula with E = 0), scaled by the
friction ellipse. Load transfer: Althoff and Wuersching, CommonRoad: Vehicle Models, section on the
single-track model.
"""

from __future__ import annotations

from math import atan, sin, sqrt
from types import SimpleNamespace
from typing import Tuple

from sdc_common.piecewise_linear import linear_segments
from sdc_sim.physics.vehicle_parameters import VehicleParameters

GRAVITY_MPS2 = 9.81
AIR_DENSITY_KGPM3 = 1.2

# Below this wheel speed the denominator of the slip angle is limited: blend into kinematic model.
BLEND_SPEED_MPS = 3.0
HALF_BLEND = 0.5 * BLEND_SPEED_MPS
BLEND_GAIN = 0.5 / BLEND_SPEED_MPS
# Sine and cosine of the front wheels' angle, forces of the motor at front and rear axle [N], forces
# of brakes and rolling resistance there, with the sign of the motion [N], and the share of the rear
# axle's grip that motor and brakes may use.
Demand = Tuple[float, float, float, float, float, float, float]

# Each axle keeps this share of its load at rest: the single-track model cannot roll over.
_MIN_LOAD_SHARE = 0.05


class MotionConstants(SimpleNamespace):
    """The parameters of a vehicle, and what follows from them on one road, as attributes."""

    @classmethod
    def of(cls, p: VehicleParameters, friction: float, side_wind_mps: float) -> MotionConstants:
        """Return the constants.

        Args:
            p: the vehicle
            friction: factor of the tyres' grip, 1 is a dry road
            side_wind_mps: side wind, positive towards the left of the vehicle
        """
        weight_n = p.mass_kg * GRAVITY_MPS2
        load_front_n = weight_n * p.rear_axle_m / p.wheelbase_m
        load_rear_n = weight_n - load_front_n
        mu = friction * p.tyre_friction
        stiffness_n = p.tyre_shape * mu
        wind_n = 0.5 * AIR_DENSITY_KGPM3 * p.side_drag_area_m2 * side_wind_mps**2
        full_rad = p.max_wheel_angle_rad * p.steer_effectiveness
        rolling_n = p.rolling_resistance * p.mass_kg * GRAVITY_MPS2
        brake_front_n = p.brake_force_n * p.brake_front_share
        return cls(
            **vars(p),
            load_front_n=load_front_n,
            load_per_acceleration=p.mass_kg * p.cg_height_m / p.wheelbase_m,
            min_load_n=_MIN_LOAD_SHARE * load_front_n,
            max_load_n=weight_n - _MIN_LOAD_SHARE * load_rear_n,
            friction=mu,
            grip_n=mu * weight_n,
            front_stiffness=p.front_cornering_stiffness_n_per_rad / (stiffness_n * load_front_n),
            rear_stiffness=p.rear_cornering_stiffness_n_per_rad / (stiffness_n * load_rear_n),
            drag=0.5 * AIR_DENSITY_KGPM3 * p.drag_area_m2,
            side_drag=0.5 * AIR_DENSITY_KGPM3 * p.side_drag_area_m2,
            side_wind_mps=side_wind_mps,
            drive_segments=linear_segments(p.throttle_points, p.drive_forces_n),
            steer_segments=linear_segments(
                p.steer_speeds_mps, [full_rad * share for share in p.steer_shares]
            ),
            tyres_hold_wind=wind_n < mu * weight_n,
            rolling_front_n=rolling_n * p.rear_axle_m / p.wheelbase_m,
            rolling_rear_n=rolling_n * p.front_axle_m / p.wheelbase_m,
            brake_front_n=brake_front_n,
            brake_rear_n=p.brake_force_n - brake_front_n,
        )


def tyre_forces(
    shape: float,
    stiffness: float,
    rolling: float,
    sliding: float,
    demand: float,
    grip: float,
    usable_grip: float,
) -> tuple[float, float]:
    """Return longitudinal and lateral force of both tyres of one axle in the wheel frame [N].

    The slip angle is atan(sliding / rolling); its denominator has a smooth lower limit below
    BLEND_SPEED_MPS. Towards standstill the tyre becomes a stiff viscous force against the
    sliding, which is the rolling constraint of the kinematic model and adds no energy.

    Args:
        shape: C of the Magic Formula
        stiffness: B of the Magic Formula
        rolling: wheel speed along the wheel [m/s]
        sliding: wheel speed to its left [m/s]
        demand: longitudinal force of drive and brakes [N]
        grip: maximum force of the axle [N]
        usable_grip: the part of it that the demand may use [N]
    """
    reference = speed = rolling if rolling >= 0.0 else -rolling
    if speed < BLEND_SPEED_MPS:
        reference = HALF_BLEND + BLEND_GAIN * speed * speed
    if sliding > 1e-9 or sliding < -1e-9:
        usable_grip *= speed / sqrt(rolling * rolling + sliding * sliding)
    if demand > usable_grip:
        demand = usable_grip
    elif demand < -usable_grip:
        demand = -usable_grip
    used = demand / grip
    # A locked wheel uses all the grip: rounding may take the remainder below zero.
    left = 1.0 - used * used
    if left < 0.0:
        left = 0.0
    return demand, -grip * sqrt(left) * sin(shape * atan(stiffness * atan(sliding / reference)))


def derivatives(
    c: MotionConstants, u: float, v: float, r: float, load_transfer: float, demand: Demand
) -> tuple[float, float, float]:
    """Return the time derivatives of speed u, lateral speed v and yaw rate r.

    The load transfer is the longitudinal acceleration that the pitching body follows.
    """
    mass, shape = c.mass_kg, c.tyre_shape
    lf, lr, wind_arm = c.front_axle_m, c.rear_axle_m, c.wind_arm_m
    sin_angle, cos_angle, drive_front, drive_rear, resist_front, resist_rear, rear_share = demand
    load = c.load_front_n - c.load_per_acceleration * load_transfer
    load = c.min_load_n if load < c.min_load_n else c.max_load_n if load > c.max_load_n else load
    grip_front = c.friction * load
    grip_rear = c.grip_n - grip_front
    axle = v + lf * r
    rolling = u * cos_angle + axle * sin_angle
    # In a spin the front wheel may roll against the motion of the body: do not accelerate it.
    if rolling * resist_front >= 0.0:
        drive_front -= resist_front
    fx_front, fy_front = tyre_forces(
        shape,
        c.front_stiffness,
        rolling,
        axle * cos_angle - u * sin_angle,
        drive_front,
        grip_front,
        c.pedal_grip_share * grip_front,
    )
    fx_rear, fy_rear = tyre_forces(
        shape,
        c.rear_stiffness,
        u,
        v - lr * r,
        drive_rear - resist_rear,
        grip_rear,
        rear_share * grip_rear,
    )
    air = c.side_wind_mps - v - wind_arm * r
    fy_air = c.side_drag * air * (air if air >= 0.0 else -air)
    fx_body = fx_front * cos_angle - fy_front * sin_angle + fx_rear
    fx_body -= c.drag * u * (u if u >= 0.0 else -u)
    fy_body = fx_front * sin_angle + fy_front * cos_angle
    return (
        fx_body / mass + v * r,
        (fy_body + fy_rear + fy_air) / mass - u * r,
        (lf * fy_body - lr * fy_rear + wind_arm * fy_air) / c.yaw_inertia_kgm2,
    )


def fastest_rate_per_s(p: VehicleParameters) -> float:
    """Return an upper bound of the fastest decay in the equations of motion [1/s].

    It is the trace of the Jacobian at the lower limit of the slip angle's denominator.
    """
    front = p.front_cornering_stiffness_n_per_rad * (
        1.0 / p.mass_kg + p.front_axle_m**2 / p.yaw_inertia_kgm2
    )
    rear = p.rear_cornering_stiffness_n_per_rad * (
        1.0 / p.mass_kg + p.rear_axle_m**2 / p.yaw_inertia_kgm2
    )
    return (front + rear) / HALF_BLEND
