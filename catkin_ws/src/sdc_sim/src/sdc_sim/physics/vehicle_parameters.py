"""Parameters of a vehicle, and the reader of the presets in config/vehicles."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from sdc_common.piecewise_linear import evaluate, linear_segments
from sdc_sim.yaml_document import DocumentError, file_version, load_yaml, validate

_SHARES = ("drive_front_share", "brake_front_share")
# Other numbers are mistakes, with which the equations of motion overflow.
_SMALLEST, _LARGEST = 1e-9, 1e9
_MAY_BE_ZERO = (
    "rolling_resistance",
    "drag_area_m2",
    "side_drag_area_m2",
    "wind_arm_m",
    "creep_force_n",
    "creep_damping_n_per_mps",
)


class VehicleError(ValueError):
    """An invalid vehicle; `key` is the name of the invalid parameter, if there is one."""

    def __init__(self, message: str, key: str | None = None):
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class VehicleParameters:
    """Parameters of one vehicle; every field is a key of the preset files in config/vehicles.

    The cornering stiffness of an axle is that of both its wheels at the axle load at rest.

    Raises:
        VehicleError: a parameter has the wrong type or is out of range
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
    reverse_speed_mps: float  # the drive force in reverse falls to zero at this speed
    brake_force_n: float
    brake_front_share: float
    hand_brake_force_n: float  # at the rear axle
    pedal_grip_share: float  # share of the grip that ABS and traction control let the pedals use
    rolling_resistance: float  # share of the weight
    drag_area_m2: float  # drag coefficient times frontal area
    side_drag_area_m2: float  # side force coefficient times side area
    wind_arm_m: float  # distance from the centre of gravity forward to the side force
    creep_force_n: float = 0.0  # least drive force at standstill, per unit of throttle
    creep_damping_n_per_mps: float = 0.0  # decrease of this force with the speed

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            check = _checked_number if field.type == "float" else _checked_list
            object.__setattr__(self, field.name, check(field.name, getattr(self, field.name)))
        if self.max_wheel_angle_rad >= 0.5 * math.pi:
            raise VehicleError("must be less than 90 degrees, 1.5708 rad", "max_wheel_angle_rad")
        for key in ("steer_effectiveness", "pedal_grip_share"):
            if getattr(self, key) > 1.0:
                raise VehicleError(
                    f"is a share and must not exceed 1, got {getattr(self, key):g}", key
                )
        if not 1.0 < self.tyre_shape < 2.0:
            raise VehicleError(
                f"must be between 1 and 2 (usual: 1.3), got {self.tyre_shape:g}", "tyre_shape"
            )
        _check_tables(self)

    @property
    def wheelbase_m(self) -> float:
        """Distance from the front axle to the rear axle."""
        return self.front_axle_m + self.rear_axle_m

    @property
    def understeer_gradient(self) -> float:
        """Wheel angle per lateral acceleration, in addition to the Ackermann angle [rad/(m/s^2)].

        m (lr Cr - lf Cf) / (L Cf Cr): Rajamani, Vehicle Dynamics and Control, chapter 3
        (steady-state cornering).
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
        """Return the front wheel angle of the single-track model at full steer and this speed."""
        segments = linear_segments(self.steer_speeds_mps, self.steer_shares)
        share = evaluate(abs(speed_mps), segments)
        return self.max_wheel_angle_rad * self.steer_effectiveness * share


def load_vehicle(path: str) -> VehicleParameters:
    """Read a vehicle preset: a YAML mapping with the fields of VehicleParameters.

    Raises:
        VehicleError: the file cannot be read, is not such a mapping, or holds an invalid value;
            the message is one line with the file, the line, the key and the fix
    """
    return _read(path, file_version(path))


@lru_cache(maxsize=64)
def _read(path: str, _version: tuple[int, ...]) -> VehicleParameters:
    """Read a preset once: to parse it takes longer than a second of a drive in process."""
    fields = dataclasses.fields(VehicleParameters)
    schema = {
        "type": "object",
        "properties": {field.name: {} for field in fields},
        "required": [field.name for field in fields if field.default is dataclasses.MISSING],
        "additionalProperties": False,
        "description": "a mapping with lines of 'key: number'",
    }
    try:
        document = load_yaml(path, "name a file of config/vehicles")
        validate(document, schema)
    except DocumentError as error:
        raise VehicleError(str(error)) from None
    try:
        return VehicleParameters(**document.values)
    except VehicleError as error:
        located = document.error([error.key], f"'{error.key}' {error}")
        raise VehicleError(str(located), error.key) from None


def _number(key: str, value: Any) -> float:
    """Return a finite float, also for a number in quotes."""
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
    if number and not _SMALLEST <= abs(number) <= _LARGEST:
        raise VehicleError(f"is {number:g}: give 0, or {_SMALLEST:g} to {_LARGEST:g}", key)
    return number


def _checked_number(key: str, value: Any) -> float:
    number = _number(key, value)
    if key in _SHARES:
        if not 0.0 <= number <= 1.0:
            raise VehicleError(f"is a share and must be in 0..1, got {number:g}", key)
    elif key in _MAY_BE_ZERO:
        if number < 0.0:
            raise VehicleError(f"must not be negative, got {number:g}", key)
    elif number <= 0.0:
        raise VehicleError(f"must be positive, got {number:g}", key)
    return number


def _checked_list(key: str, value: Any) -> tuple[float, ...]:
    if not isinstance(value, (list, tuple)) or len(value) < 2:
        raise VehicleError("must be a list of two numbers or more, such as [0.0, 1.0]", key)
    numbers = tuple(_number(key, entry) for entry in value)
    if min(numbers) < 0.0:
        raise VehicleError(f"must not contain a negative number, got {min(numbers):g}", key)
    return numbers


def _check_tables(p: VehicleParameters) -> None:
    for points, values in (
        ("steer_speeds_mps", "steer_shares"),
        ("throttle_points", "drive_forces_n"),
    ):
        numbers, entries = getattr(p, points), len(getattr(p, values))
        if len(numbers) != entries:
            raise VehicleError(
                f"must have as many entries as {points}: {len(numbers)}, got {entries}", values
            )
        if any(b <= a for a, b in zip(numbers, numbers[1:])):
            raise VehicleError("must rise from entry to entry", points)
    if min(p.steer_shares) <= 0.0 or max(p.steer_shares) > 1.0:
        raise VehicleError("must be above 0 and at most 1", "steer_shares")
    if p.throttle_points[0] != 0.0 or p.throttle_points[-1] != 1.0:
        raise VehicleError("must start at 0 and end at 1", "throttle_points")
    if p.drive_forces_n[0] != 0.0 or any(
        b < a for a, b in zip(p.drive_forces_n, p.drive_forces_n[1:])
    ):
        raise VehicleError("must start at 0 and never fall", "drive_forces_n")
