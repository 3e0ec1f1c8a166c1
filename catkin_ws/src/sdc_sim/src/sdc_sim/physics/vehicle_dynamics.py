"""Equations of motion of a dynamic single-track model with saturating tyres.

Model: Rajamani, Vehicle Dynamics and Control, chapter 2.3, without small-angle approximations.
Tyre: Pacejka, Tyre and Vehicle Dynamics, chapter 4.3 (Magic Formula with E = 0), scaled by the
friction ellipse. Load transfer: Althoff and Wuersching, CommonRoad: Vehicle Models, section on the
single-track model.
"""

from __future__ import annotations

from math import atan, sin, sqrt

from sdc_sim.physics.vehicle_parameters import VehicleParameters

GRAVITY_MPS2 = 9.81
AIR_DENSITY_KGPM3 = 1.2

# Below this wheel speed the denominator of the slip angle is limited: blend into kinematic model.
BLEND_SPEED_MPS = 3.0
_HALF_BLEND = 0.5 * BLEND_SPEED_MPS
_BLEND_GAIN = 0.5 / BLEND_SPEED_MPS
# Each axle keeps this share of its load at rest: the single-track model cannot roll over.
_MIN_LOAD_SHARE = 0.05


class BodyMotion:
    """Motion of the centre of gravity in the body frame (x forward, y left).

    The integration reuses the objects of this class and of WheelDemand in each step: to create
    them there takes a tenth of its time.
    """

    __slots__ = ("speed_mps", "lateral_speed_mps", "yaw_rate_radps", "load_transfer_mps2")

    speed_mps: float
    lateral_speed_mps: float
    yaw_rate_radps: float
    load_transfer_mps2: float  # longitudinal acceleration that the pitching body follows


class WheelDemand:
    """What pedals, steering and hand brake demand of the wheels.

    Resistance is that of brakes and rolling, never negative, opposite to `direction`, which is the
    sign of the motion that it resists (-1, 0 or 1).
    """

    __slots__ = (
        "sin_angle",
        "cos_angle",
        "drive_front_n",
        "drive_rear_n",
        "resist_front_n",
        "resist_rear_n",
        "rear_grip_share",
        "direction",
    )

    sin_angle: float
    cos_angle: float
    drive_front_n: float
    drive_rear_n: float
    resist_front_n: float
    resist_rear_n: float
    rear_grip_share: float
    direction: float


class _AxleTyres:
    """Both tyres of one axle."""

    __slots__ = ("_shape", "_stiffness")

    def __init__(self, shape: float, stiffness: float):
        self._shape = shape
        self._stiffness = stiffness

    def forces(
        self, rolling: float, sliding: float, demand: float, grip: float, usable_grip: float
    ) -> tuple[float, float]:
        """Return longitudinal and lateral force in the wheel frame [N].

        The slip angle is atan(sliding / rolling); its denominator has a smooth lower limit below
        BLEND_SPEED_MPS. Towards standstill the tyre becomes a stiff viscous force against the
        sliding, which is the rolling constraint of the kinematic model and adds no energy.

        Args:
            rolling: wheel speed along the wheel [m/s]
            sliding: wheel speed to its left [m/s]
            demand: longitudinal force of drive and brakes [N]
            grip: maximum force of the axle [N]
            usable_grip: the part of it that the demand may use [N]
        """
        speed = abs(rolling)
        reference = speed
        if speed < BLEND_SPEED_MPS:
            reference = _HALF_BLEND + _BLEND_GAIN * speed * speed
        slip = sliding / reference
        limit = usable_grip
        if abs(sliding) > 1e-9:
            limit *= speed / sqrt(rolling * rolling + sliding * sliding)
        if demand > limit:
            demand = limit
        elif demand < -limit:
            demand = -limit
        used = demand / grip
        # A locked wheel uses all the grip: rounding may take the remainder below zero.
        left = 1.0 - used * used
        if left < 0.0:
            left = 0.0
        return demand, -grip * sqrt(left) * sin(self._shape * atan(self._stiffness * atan(slip)))


class VehicleDynamics:
    """Time derivatives of the motion of one vehicle on one road.

    Args:
        p: the vehicle
        friction: factor of the tyres' grip, 1 is a dry road
        side_wind_mps: side wind, positive towards the left of the vehicle
    """

    def __init__(self, p: VehicleParameters, friction: float, side_wind_mps: float):
        weight = p.mass_kg * GRAVITY_MPS2
        load_front = weight * p.rear_axle_m / p.wheelbase_m
        load_rear = weight - load_front
        mu = friction * p.tyre_friction
        self._mass, self._inertia = p.mass_kg, p.yaw_inertia_kgm2
        self._lf, self._lr = p.front_axle_m, p.rear_axle_m
        self._load_front = load_front
        self._load_per_acceleration = p.mass_kg * p.cg_height_m / p.wheelbase_m
        self._min_load_front = _MIN_LOAD_SHARE * load_front
        self._max_load_front = weight - _MIN_LOAD_SHARE * load_rear
        self._mu, self._total_grip = mu, mu * weight
        shape = p.tyre_shape
        self._front = _AxleTyres(
            shape, p.front_cornering_stiffness_n_per_rad / (shape * mu * load_front)
        )
        self._rear = _AxleTyres(
            shape, p.rear_cornering_stiffness_n_per_rad / (shape * mu * load_rear)
        )
        self._front_grip_share = p.pedal_grip_share
        self._drag = 0.5 * AIR_DENSITY_KGPM3 * p.drag_area_m2
        self._side_drag = 0.5 * AIR_DENSITY_KGPM3 * p.side_drag_area_m2
        self._wind_arm, self._side_wind = p.wind_arm_m, side_wind_mps

    def derivatives(self, motion: BodyMotion, demand: WheelDemand) -> tuple[float, float, float]:
        """Return the time derivatives of speed, lateral speed and yaw rate."""
        u, v, r = motion.speed_mps, motion.lateral_speed_mps, motion.yaw_rate_radps
        sin_angle, cos_angle = demand.sin_angle, demand.cos_angle
        direction = demand.direction
        lf, lr = self._lf, self._lr

        load_front = self._load_front - self._load_per_acceleration * motion.load_transfer_mps2
        if load_front < self._min_load_front:
            load_front = self._min_load_front
        if load_front > self._max_load_front:
            load_front = self._max_load_front
        grip_front = self._mu * load_front
        grip_rear = self._total_grip - grip_front

        axle = v + lf * r
        rolling = u * cos_angle + axle * sin_angle
        force = demand.drive_front_n
        # In a spin the front wheel may roll against the motion of the body: do not accelerate it.
        if rolling * direction >= 0.0:
            force -= demand.resist_front_n * direction
        fx_front, fy_front = self._front.forces(
            rolling,
            axle * cos_angle - u * sin_angle,
            force,
            grip_front,
            self._front_grip_share * grip_front,
        )
        fx_rear, fy_rear = self._rear.forces(
            u,
            v - lr * r,
            demand.drive_rear_n - demand.resist_rear_n * direction,
            grip_rear,
            demand.rear_grip_share * grip_rear,
        )

        wind_arm = self._wind_arm
        air = self._side_wind - v - wind_arm * r
        fy_air = self._side_drag * air * abs(air)
        fx_body = fx_front * cos_angle - fy_front * sin_angle + fx_rear - self._drag * u * abs(u)
        fy_body = fx_front * sin_angle + fy_front * cos_angle
        return (
            fx_body / self._mass + v * r,
            (fy_body + fy_rear + fy_air) / self._mass - u * r,
            (lf * fy_body - lr * fy_rear + wind_arm * fy_air) / self._inertia,
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
    return (front + rear) / _HALF_BLEND
