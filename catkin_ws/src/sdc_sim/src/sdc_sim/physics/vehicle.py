"""The physics of the car: a dynamic single-track model with saturating tyres, pedals, steering and drag.

Frames as ROS has them (REP 103): x forward, y left, yaw counter-clockwise. Positive steer turns right, as in CARLA.
Numbers in, numbers out: no ROS, no clock, and no files but in `load_vehicle`. The equations, their sources and what
has been measured stand in the README of this package.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from dataclasses import dataclass

import yaml

from sdc_common.validation import check_between

GRAVITY_MPS2 = 9.81
AIR_DENSITY_KGPM3 = 1.2

# Below this wheel speed the slip angle's denominator is floored (see `_dynamics`): the blend into the kinematic model.
BLEND_SPEED_MPS = 3.0

# A car whose wheels stand still sticks to the road once its sideways motion is slower than this (m/s and rad/s).
_STICTION = 0.02
_STANDING_STEPS = 5
# No axle is ever lifted beyond this share of its load at rest: the single-track model cannot roll over.
_LEAST_LOAD_SHARE = 0.05
_STRONGEST_WIND_MPS = 75.0
_LONGEST_INTERNAL_STEP_S = 0.01

_SHARES = ("drive_front_share", "brake_front_share")
_MAY_BE_ZERO = ("rolling_resistance", "drag_area_m2", "side_drag_area_m2", "wind_arm_m")


class VehicleError(ValueError):
    """A vehicle that cannot be driven. `key` names the figure at fault, where there is one."""

    def __init__(self, message: str, key: str | None = None):
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class VehicleParameters:
    """What makes one car differ from another; every field is a key of the preset files in config/vehicles.

    An axle's cornering stiffness is that of both its wheels at the load of a car at rest. Raises VehicleError (a
    ValueError that carries the key) for a figure that is missing, of the wrong kind or out of its range.
    """

    mass_kg: float
    yaw_inertia_kgm2: float
    front_axle_m: float  # centre of gravity to the front axle, lf
    rear_axle_m: float  # centre of gravity to the rear axle, lr
    cg_height_m: float
    length_m: float
    width_m: float
    front_cornering_stiffness_n_per_rad: float
    rear_cornering_stiffness_n_per_rad: float
    tyre_shape: float  # C of the Magic Formula, 1 < C < 2
    tyre_friction: float  # peak friction on a dry road
    load_transfer_time_s: float  # time constant of the pitching body
    max_wheel_angle_rad: float  # at full steer and standstill
    steer_effectiveness: float  # share of the wheel angle that arrives as path curvature
    steer_speeds_mps: tuple[float, ...]  # (N,), rising
    steer_shares: tuple[float, ...]  # (N,), share of the wheel angle that remains at these speeds
    steer_travel_s: float  # -1 to 1
    pedal_travel_s: float  # 0 to 1
    throttle_points: tuple[float, ...]  # (M,), rising from 0 to 1
    drive_forces_n: tuple[float, ...]  # (M,), at these throttles and low speed
    drive_power_w: float
    drive_front_share: float
    reverse_speed_mps: float  # the drive in reverse fades out below this speed
    brake_force_n: float
    brake_front_share: float
    hand_brake_force_n: float  # at the rear axle
    pedal_grip_share: float  # share of the grip that ABS and traction control let the pedals use
    rolling_resistance: float  # share of the weight
    drag_area_m2: float  # drag coefficient times frontal area
    side_drag_area_m2: float  # side force coefficient times side area
    wind_arm_m: float  # side force's point of attack ahead of the centre of gravity

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.type == "float":
                object.__setattr__(self, field.name, _figure(field.name, value))
            else:
                object.__setattr__(self, field.name, _table(field.name, value))
        if self.max_wheel_angle_rad >= 0.5 * math.pi:
            raise VehicleError("must be less than 90 degrees, 1.5708 rad", "max_wheel_angle_rad")
        for key in ("steer_effectiveness", "pedal_grip_share"):
            if getattr(self, key) > 1.0:
                raise VehicleError(
                    f"is a share and must not exceed 1, got {getattr(self, key):g}", key
                )
        if not 1.0 < self.tyre_shape < 2.0:
            raise VehicleError(
                f"must lie between 1 and 2 (usual: 1.3), got {self.tyre_shape:g}", "tyre_shape"
            )
        _check_tables(self)

    @property
    def wheelbase_m(self) -> float:
        """Front axle to rear axle."""
        return self.front_axle_m + self.rear_axle_m

    @property
    def understeer_gradient(self) -> float:
        """Wheel angle that a lateral acceleration needs beyond the Ackermann angle, in rad per m/s^2.

        m (lr Cr - lf Cf) / (L Cf Cr): Rajamani, Vehicle Dynamics and Control, chapter 3 (steady-state cornering).
        """
        front = (
            self.mass_kg
            * self.rear_axle_m
            / self.wheelbase_m
            / self.front_cornering_stiffness_n_per_rad
        )
        rear = (
            self.mass_kg
            * self.front_axle_m
            / self.wheelbase_m
            / self.rear_cornering_stiffness_n_per_rad
        )
        return front - rear

    def full_wheel_angle_rad(self, speed_mps: float) -> float:
        """The bicycle's front wheel angle at full steer: what remains of it at this speed, linear in the table."""
        share = _interpolated(abs(speed_mps), self.steer_speeds_mps, self.steer_shares)
        return self.max_wheel_angle_rad * self.steer_effectiveness * share


@dataclass
class VehicleCommand:
    """What a driver asks for: throttle and brake in 0..1, steer in -1..1 and positive to the RIGHT."""

    throttle: float = 0.0
    steer: float = 0.0
    brake: float = 0.0
    hand_brake: bool = False
    reverse: bool = False

    def clamped(self) -> tuple[VehicleCommand, bool]:
        """The command within its ranges, and whether it had to be limited. Raises ValueError for NaN and infinities."""
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
    """Where the car is and how it moves. Its point is the centre of gravity, on the ground.

    yaw_rad counts on beyond pi; speed_mps and lateral_speed_mps are in the body frame (forward, left); wheel_angle_rad
    is that of the bicycle's front wheel, positive LEFT; throttle, brake and steer are the positions that pedals and
    steering have reached; the accelerations are those an accelerometer in the centre of gravity feels (forward, left);
    load_transfer_mps2 is the acceleration that the pitching body has followed.
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
    """A car on a flat road. Nothing but the arguments decides: the same calls give the same numbers, bit for bit.

    friction scales the tyres' grip (1 dry, about 0.6 wet, 0.2 ice); side_wind_mps blows at the car's side, positive
    towards its left; each `step` is cut into equal internal steps of at most internal_step_s, integrated by Heun's
    method. Raises ValueError for figures that are no numbers or out of range, and for an internal step too long for
    the stiffness of this car's tyres.
    """

    def __init__(
        self,
        parameters: VehicleParameters,
        friction: float = 1.0,
        side_wind_mps: float = 0.0,
        internal_step_s: float = 0.005,
    ):
        check_between(1e-3, 100.0, friction=friction)
        check_between(-_STRONGEST_WIND_MPS, _STRONGEST_WIND_MPS, side_wind_mps=side_wind_mps)
        longest = min(_LONGEST_INTERNAL_STEP_S, 2.0 / _stiffest_rate(parameters))
        if not 0.0 < internal_step_s <= longest:
            raise ValueError(
                f"internal_step_s must lie in 0..{longest:.4g} s for this car, got {internal_step_s}"
            )
        self.parameters = parameters
        self.friction = friction
        self.side_wind_mps = side_wind_mps
        self.internal_step_s = internal_step_s
        self.state = VehicleState()
        self._derivatives = _dynamics(parameters, friction, side_wind_mps)
        weight_n = parameters.mass_kg * GRAVITY_MPS2
        wind_n = 0.5 * AIR_DENSITY_KGPM3 * parameters.side_drag_area_m2 * side_wind_mps**2
        self._wind_is_held = wind_n < friction * parameters.tyre_friction * weight_n
        self._drive_segments = _segments(parameters.throttle_points, parameters.drive_forces_n)
        full_rad = parameters.max_wheel_angle_rad * parameters.steer_effectiveness
        self._steer_segments = _segments(
            parameters.steer_speeds_mps, [full_rad * share for share in parameters.steer_shares]
        )

    def reset(self, x_m: float, y_m: float, yaw_rad: float, speed_mps: float = 0.0) -> None:
        """Put the car down, wheels straight and pedals released, rolling at this speed. Raises ValueError for NaN."""
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
        """Drive on for duration_s under one command; `state` is then a new VehicleState. Less than 5 ps is no time.

        A command out of range is clamped. Raises ValueError, and leaves the state as it was, for a command with NaN or
        an infinity and for a duration that is negative or not finite.
        """
        if not 0.0 <= duration_s < math.inf:
            raise ValueError(f"duration_s must be a number of seconds from 0, got {duration_s}")
        command, _ = command.clamped()
        steps = math.ceil(duration_s / self.internal_step_s - 1e-9)
        if self.state.speed_mps == 0.0:
            # When a standing car breaks away is rounded to internal steps: finer ones keep that out of where it ends.
            steps *= _STANDING_STEPS
        if steps:
            self._advance(command, duration_s / steps, steps)

    def _advance(self, command: VehicleCommand, h: float, steps: int) -> None:
        p = self.parameters
        state = self.state
        derivatives = self._derivatives
        sin, cos = math.sin, math.cos

        x, y, yaw = state.x_m, state.y_m, state.yaw_rad
        u, v, r = state.speed_mps, state.lateral_speed_mps, state.yaw_rate_radps
        throttle, brake, steer = state.throttle, state.brake, state.steer
        ax, ay, load = (
            state.longitudinal_acceleration_mps2,
            state.lateral_acceleration_mps2,
            state.load_transfer_mps2,
        )
        u_dot = ax + v * r

        throttle_goal, brake_goal, steer_goal = (
            float(command.throttle),
            float(command.brake),
            float(command.steer),
        )
        hand_brake, reverse = bool(command.hand_brake), bool(command.reverse)
        pedal_slew = h / p.pedal_travel_s
        steer_slew = 2.0 * h / p.steer_travel_s
        load_gain = 1.0 - math.exp(-h / p.load_transfer_time_s)
        mass = p.mass_kg
        power = p.drive_power_w
        drive_front = p.drive_front_share
        rolling_front = p.rolling_resistance * mass * GRAVITY_MPS2 * p.rear_axle_m / p.wheelbase_m
        rolling_rear = p.rolling_resistance * mass * GRAVITY_MPS2 * p.front_axle_m / p.wheelbase_m
        if hand_brake:
            rolling_rear += p.hand_brake_force_n
        brake_front = p.brake_force_n * p.brake_front_share
        brake_rear = p.brake_force_n - brake_front
        rear_share = 1.0 if hand_brake else p.pedal_grip_share
        drive_segments, steer_segments = self._drive_segments, self._steer_segments

        for _ in range(steps):
            # An actuator moves at its rate until it arrives. What acts over the step is its mean, an arrival in between
            # included: with the step's two ends averaged instead, the integration would be of first order only.
            moved = min(max(throttle_goal - throttle, -pedal_slew), pedal_slew)
            throttle += moved
            accelerating = throttle - 0.5 * moved * abs(moved) / pedal_slew
            moved = min(max(brake_goal - brake, -pedal_slew), pedal_slew)
            brake += moved
            braking = brake - 0.5 * moved * abs(moved) / pedal_slew
            moved = min(max(steer_goal - steer, -steer_slew), steer_slew)
            steer += moved
            steering = steer - 0.5 * moved * abs(moved) / steer_slew

            u_mid = u + 0.5 * h * u_dot
            speed = abs(u_mid)
            drive = 0.0
            if not hand_brake:
                drive = _on_segments(accelerating, drive_segments)
                if drive * speed > power:
                    drive = power / speed
                if reverse:
                    drive *= -min(max(p.reverse_speed_mps + u_mid, 0.0), 1.0)
            resist_front = rolling_front + braking * brake_front
            resist_rear = rolling_rear + braking * brake_rear

            if (
                u == 0.0
                and v == 0.0
                and r == 0.0
                and self._wind_is_held
                and abs(drive) <= resist_front + resist_rear
            ):
                u_dot = ax = ay = 0.0
                load -= load_gain * load
                continue

            # Rolling resistance and brakes act against the motion, or against what is about to cause one.
            push = u
            if u == 0.0:
                push = drive + mass * v * r
                resistance = resist_front + resist_rear
                if abs(push) < resistance:
                    resist_front *= abs(push) / resistance
                    resist_rear *= abs(push) / resistance
            direction = 1.0 if push > 0.0 else -1.0 if push < 0.0 else 0.0
            drive_f = drive * drive_front
            drive_r = drive - drive_f
            angle = -steering * _on_segments(speed, steer_segments)
            sin_angle, cos_angle = sin(angle), cos(angle)
            u_dot_0, v_dot_0, r_dot_0 = derivatives(
                u,
                v,
                r,
                sin_angle,
                cos_angle,
                load,
                drive_f,
                drive_r,
                resist_front,
                resist_rear,
                rear_share,
                direction,
            )
            u_dot_1, v_dot_1, r_dot_1 = derivatives(
                u + h * u_dot_0,
                v + h * v_dot_0,
                r + h * r_dot_0,
                sin_angle,
                cos_angle,
                load + load_gain * (u_dot_0 - v * r - load),
                drive_f,
                drive_r,
                resist_front,
                resist_rear,
                rear_share,
                direction,
            )
            u_new = u + 0.5 * h * (u_dot_0 + u_dot_1)
            v_new = v + 0.5 * h * (v_dot_0 + v_dot_1)
            r_new = r + 0.5 * h * (r_dot_0 + r_dot_1)
            if u_new * direction <= 0.0:
                # Resistance stops a motion and never turns it round; what does turn it round does so in the next step.
                u_new = 0.0
                if abs(v_new) < _STICTION and abs(r_new) < _STICTION and self._wind_is_held:
                    v_new = r_new = 0.0

            u_mean, v_mean, r_mean = 0.5 * (u + u_new), 0.5 * (v + v_new), 0.5 * (r + r_new)
            heading = yaw + 0.5 * h * r_mean
            x += h * (u_mean * cos(heading) - v_mean * sin(heading))
            y += h * (u_mean * sin(heading) + v_mean * cos(heading))
            yaw += h * r_mean
            u_dot = (u_new - u) / h
            load += load_gain * (u_dot - v_mean * r_mean - load)
            ax = u_dot - v_new * r_new
            ay = (v_new - v) / h + u_new * r_new
            u, v, r = u_new, v_new, r_new

        wheel_angle = -steer * _on_segments(abs(u), steer_segments)
        self.state = VehicleState(
            x, y, yaw, u, v, r, wheel_angle, throttle, brake, ax, ay, steer, load
        )


def _dynamics(p: VehicleParameters, friction: float, side_wind_mps: float):
    """The equations of motion of one car on one road, as a function of state and controls.

    The function takes: speed, lateral speed and yaw rate; sine and cosine of the wheel angle; the acceleration that
    the load transfer follows (m/s^2); drive force and resistance (brake and rolling, N, never negative) of the front
    and of the rear axle; the share of the grip the rear wheels may brake with; the sign of the resisted motion. It
    returns the time derivatives of speed, lateral speed and yaw rate.

    Model: Rajamani, Vehicle Dynamics and Control, chapter 2.3, without small-angle approximations; tyre: Pacejka, Tyre
    and Vehicle Dynamics, chapter 4.3 (Magic Formula with E = 0), scaled by the friction ellipse; load transfer:
    Althoff and Wuersching, CommonRoad: Vehicle Models, section on the single-track model.

    The slip angle is atan(lateral / longitudinal wheel speed), the denominator floored smoothly below BLEND_SPEED_MPS.
    Towards standstill the tyre so becomes a stiff viscous hold on the wheel's sideways motion, which is the rolling
    constraint of the kinematic model. As all of it are forces against the sliding, the blend makes no energy.
    """
    sqrt, sin, atan = math.sqrt, math.sin, math.atan
    mass, inertia = p.mass_kg, p.yaw_inertia_kgm2
    lf, lr, wheelbase = p.front_axle_m, p.rear_axle_m, p.wheelbase_m
    weight = mass * GRAVITY_MPS2
    load_front = weight * lr / wheelbase
    load_rear = weight - load_front
    load_per_acceleration = mass * p.cg_height_m / wheelbase
    least_front, least_rear = _LEAST_LOAD_SHARE * load_front, _LEAST_LOAD_SHARE * load_rear
    mu = friction * p.tyre_friction
    shape = p.tyre_shape
    stiffness_front = p.front_cornering_stiffness_n_per_rad / (shape * mu * load_front)
    stiffness_rear = p.rear_cornering_stiffness_n_per_rad / (shape * mu * load_rear)
    front_share = p.pedal_grip_share
    drag = 0.5 * AIR_DENSITY_KGPM3 * p.drag_area_m2
    side_drag = 0.5 * AIR_DENSITY_KGPM3 * p.side_drag_area_m2
    wind_arm = p.wind_arm_m
    blend = BLEND_SPEED_MPS
    half_blend = 0.5 * blend
    blend_gain = 0.5 / blend

    def derivatives(
        u,
        v,
        r,
        sin_angle,
        cos_angle,
        load,
        drive_f,
        drive_r,
        resist_f,
        resist_r,
        rear_share,
        direction,
    ):
        grip_f = load_front - load_per_acceleration * load
        grip_f = mu * min(max(grip_f, least_front), weight - least_rear)
        grip_r = mu * weight - grip_f

        axle = v + lf * r
        rolling = u * cos_angle + axle * sin_angle
        sliding = axle * cos_angle - u * sin_angle
        reference = abs(rolling)
        if reference < blend:
            reference = half_blend + blend_gain * reference * reference
        slip = sliding / reference
        # In a spin the steered wheel may roll against the car's own motion, where this resistance would drive it on.
        force = drive_f
        if rolling * direction >= 0.0:
            force -= resist_f * direction
        limit = front_share * grip_f
        if abs(sliding) > 1e-9:
            limit *= abs(rolling) / sqrt(rolling * rolling + sliding * sliding)
        fx_f = min(max(force, -limit), limit)
        # A locked wheel uses all grip there is: rounding may take the rest below zero.
        used = fx_f / grip_f
        fy_f = (
            -grip_f
            * sqrt(max(1.0 - used * used, 0.0))
            * sin(shape * atan(stiffness_front * atan(slip)))
        )

        reference = abs(u)
        if reference < blend:
            reference = half_blend + blend_gain * reference * reference
        sliding = v - lr * r
        slip = sliding / reference
        limit = rear_share * grip_r
        if abs(sliding) > 1e-9:
            limit *= abs(u) / sqrt(u * u + sliding * sliding)
        fx_r = min(max(drive_r - resist_r * direction, -limit), limit)
        used = fx_r / grip_r
        fy_r = (
            -grip_r
            * sqrt(max(1.0 - used * used, 0.0))
            * sin(shape * atan(stiffness_rear * atan(slip)))
        )

        air = side_wind_mps - v - wind_arm * r
        fy_air = side_drag * air * abs(air)
        fy_front = fx_f * sin_angle + fy_f * cos_angle
        return (
            (fx_f * cos_angle - fy_f * sin_angle + fx_r - drag * u * abs(u)) / mass + v * r,
            (fy_front + fy_r + fy_air) / mass - u * r,
            (lf * fy_front - lr * fy_r + wind_arm * fy_air) / inertia,
        )

    return derivatives


def _stiffest_rate(p: VehicleParameters) -> float:
    """An upper bound of the fastest decay in the equations of motion (1/s): the trace at the floor of the slip."""
    front = p.front_cornering_stiffness_n_per_rad * (
        1.0 / p.mass_kg + p.front_axle_m**2 / p.yaw_inertia_kgm2
    )
    rear = p.rear_cornering_stiffness_n_per_rad * (
        1.0 / p.mass_kg + p.rear_axle_m**2 / p.yaw_inertia_kgm2
    )
    return (front + rear) / (0.5 * BLEND_SPEED_MPS)


def _segments(points, values):
    """A polyline as (start, value, slope) pieces, last piece first; flat beyond both of its ends."""
    pieces = [(points[-1], values[-1], 0.0)]
    for i in range(len(points) - 2, -1, -1):
        pieces.append(
            (points[i], values[i], (values[i + 1] - values[i]) / (points[i + 1] - points[i]))
        )
    pieces.append((-math.inf, values[0], 0.0))
    return tuple(pieces)


def _on_segments(x, segments):
    for start, value, slope in segments:
        if x >= start:
            return value + slope * (x - start) if slope else value
    raise ValueError(f"no place on the curve for {x}")


def _interpolated(x, points, values):
    return _on_segments(x, _segments(points, values))


def load_vehicle(path) -> VehicleParameters:
    """Read a vehicle preset: a YAML mapping of the fields of VehicleParameters.

    Raises VehicleError, in one line with the file, the line, the key and the mend, for a file that is missing or no
    such mapping, a key that is missing, unknown or given twice, and a figure of the wrong kind or out of its range.
    """
    try:
        with open(path, encoding="utf-8") as file:
            values, lines = _read_mapping(file.read())
    except OSError as error:
        raise VehicleError(
            f"{path}: cannot be read ({error.strerror}): name a file of config/vehicles"
        ) from None
    except UnicodeDecodeError:
        raise VehicleError(f"{path}: is no text file: name a file of config/vehicles") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"{path}, line {mark.line + 1}" if mark else f"{path}"
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        raise VehicleError(
            f"{place}: is no YAML ({problem}): write lines of 'key: figure'"
        ) from None
    except VehicleError as error:
        raise VehicleError(f"{path}{_line(error.key, None)}: {error}", error.key) from None

    known = [field.name for field in dataclasses.fields(VehicleParameters)]
    for key in values:
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1)
            mend = f"did you mean '{close[0]}'?" if close else "remove the line"
            raise VehicleError(f"{path}{_line(key, lines)}: unknown key '{key}': {mend}", key)
    for key in known:
        if key not in values:
            raise VehicleError(
                f"{path}: key '{key}' is missing: add the line '{key}: <figure>'", key
            )
    try:
        return VehicleParameters(**values)
    except VehicleError as error:
        raise VehicleError(
            f"{path}{_line(error.key, lines)}: '{error.key}' {error}", error.key
        ) from None


def _line(key, lines):
    return f", line {lines[key]}" if lines and key in lines else ""


def _read_mapping(text):
    """The mapping in a YAML text, and the line that each of its keys stands in."""
    loader = yaml.SafeLoader(text)
    try:
        root = loader.get_single_node()
        if not isinstance(root, yaml.MappingNode):
            raise VehicleError("holds no figures: write lines of 'key: figure'")
        values, lines = {}, {}
        for key_node, value_node in root.value:
            key = str(key_node.value)
            line = key_node.start_mark.line + 1
            if key in values:
                raise VehicleError(
                    f"key '{key}' stands in lines {lines[key]} and {line}: remove one of them"
                )
            values[key] = loader.construct_object(value_node, deep=True)
            lines[key] = line
        return values, lines
    finally:
        loader.dispose()


def _number(key, value):
    """A finite float, or VehicleError. YAML 1.1 reads 13e3 as a word: it is taken as the number it is."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        kinds = {type(None): "empty", bool: "a truth value", list: "a list", dict: "a mapping"}
        raise VehicleError(f"is {kinds.get(type(value), repr(value))}: give a number", key)
    try:
        number = float(value)
    except ValueError:
        raise VehicleError(f"is the word '{value}': give a number", key) from None
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise VehicleError(f"is {number}: give a finite number", key)
    return number


def _figure(key, value):
    number = _number(key, value)
    if key in _SHARES:
        if not 0.0 <= number <= 1.0:
            raise VehicleError(f"is a share and must lie in 0..1, got {number:g}", key)
    elif key in _MAY_BE_ZERO:
        if number < 0.0:
            raise VehicleError(f"must not be negative, got {number:g}", key)
    elif number <= 0.0:
        raise VehicleError(f"must be positive, got {number:g}", key)
    return number


def _table(key, value):
    if not isinstance(value, (list, tuple)) or len(value) < 2:
        raise VehicleError("must be a list of two numbers or more, such as [0.0, 1.0]", key)
    numbers = tuple(_number(key, entry) for entry in value)
    if min(numbers) < 0.0:
        raise VehicleError(f"must not hold a negative figure, got {min(numbers):g}", key)
    return numbers


def _check_tables(p):
    for points, values in (
        ("steer_speeds_mps", "steer_shares"),
        ("throttle_points", "drive_forces_n"),
    ):
        figures, entries = getattr(p, points), len(getattr(p, values))
        if len(figures) != entries:
            raise VehicleError(
                f"must have as many entries as {points}: {len(figures)}, got {entries}", values
            )
        if any(b <= a for a, b in zip(figures, figures[1:])):
            raise VehicleError("must rise from entry to entry", points)
    if min(p.steer_shares) <= 0.0 or max(p.steer_shares) > 1.0:
        raise VehicleError("must lie above 0 and not exceed 1", "steer_shares")
    if p.throttle_points[0] != 0.0 or p.throttle_points[-1] != 1.0:
        raise VehicleError("must start at 0 and end at 1", "throttle_points")
    if p.drive_forces_n[0] != 0.0 or any(
        b < a for a, b in zip(p.drive_forces_n, p.drive_forces_n[1:])
    ):
        raise VehicleError("must start at 0 and never fall", "drive_forces_n")
