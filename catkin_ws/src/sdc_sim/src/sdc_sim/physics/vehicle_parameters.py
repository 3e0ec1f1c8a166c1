"""Parameters of a vehicle, and the reader of the presets in config/vehicles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sdc_common.piecewise_linear import evaluate, linear_segments
from sdc_sim.yaml_document import YamlDocument, load_document


@dataclass(frozen=True)
class VehicleParameters:
    """Parameters of one vehicle; every field is a key of the preset files in config/vehicles.

    The cornering stiffness of an axle is that of both its wheels at the axle load at rest.
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

    @property
    def wheelbase_m(self) -> float:
        """Distance from the front axle to the rear axle."""
        return self.front_axle_m + self.rear_axle_m

    def full_wheel_angle_rad(self, speed_mps: float) -> float:
        """Return the front wheel angle of the single-track model at full steer and this speed."""
        segments = linear_segments(self.steer_speeds_mps, self.steer_shares)
        share = evaluate(abs(speed_mps), segments)
        return self.max_wheel_angle_rad * self.steer_effectiveness * share


def load_vehicle(path: str) -> VehicleParameters:
    """Read a vehicle preset: a YAML mapping with the fields of VehicleParameters.

    Raises:
        DocumentError: the file cannot be read, or config/schemas/vehicle.yaml refuses it; the
            message is one line with the file, the line, the key and the fix
    """
    document = load_document(path, "vehicle", "name a file of config/vehicles")
    _check_curves(document)
    parameters: dict[str, Any] = {
        key: tuple(map(float, value)) if isinstance(value, list) else float(value)
        for key, value in document.values.items()
    }
    return VehicleParameters(**parameters)


def _check_curves(document: YamlDocument) -> None:
    """Raise DocumentError for a curve with which the vehicle cannot be computed."""
    curves = ("steer_speeds_mps", "steer_shares"), ("throttle_points", "drive_forces_n")
    for points_key, values_key in curves:
        points, values = document.values[points_key], document.values[values_key]
        if len(points) != len(values):
            raise document.error(
                [values_key],
                f"'{values_key}' must have as many entries as {points_key}: {len(points)}, "
                f"got {len(values)}",
            )
        if any(b <= a for a, b in zip(points, points[1:])):
            raise document.error([points_key], f"'{points_key}' must rise from entry to entry")
    if (points[0], points[-1]) != (0.0, 1.0):
        raise document.error([points_key], f"'{points_key}' must start at 0 and end at 1")
    if values[0] != 0.0 or values != sorted(values):
        raise document.error([values_key], f"'{values_key}' must start at 0 and never fall")
