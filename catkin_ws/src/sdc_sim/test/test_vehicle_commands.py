"""Limits of the commands, the conditions and the start of a vehicle."""

from __future__ import annotations

import dataclasses
import math
import os

import pytest

from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleState
from sdc_sim.physics.vehicle_dynamics import fastest_rate_per_s
from sdc_sim.physics.vehicle_motion import MotionConstants, integrate
from sdc_sim.physics.vehicle_parameters import load_vehicle

HERE = os.path.dirname(os.path.abspath(__file__))
CAR = load_vehicle(os.path.join(HERE, "..", "config", "vehicles", "tesla_model3.yaml"))


@pytest.mark.parametrize(
    "command",
    [VehicleCommand(0.0, -1.0, 0.0), VehicleCommand(1.0, 1.0, 1.0), VehicleCommand(0.2, 0.1, 0.3)],
)
def test_command_within_its_ranges_is_not_limited(command):
    assert command.clamped() == (command, False)


@pytest.mark.parametrize(
    ("key", "value", "limit"),
    [
        ("throttle", 1.5, 1.0),
        ("throttle", -0.5, 0.0),
        ("steer", 1.5, 1.0),
        ("steer", -1.5, -1.0),
        ("brake", 1.5, 1.0),
        ("brake", -0.5, 0.0),
    ],
)
def test_value_out_of_its_range_is_limited_and_reported(key, value, limit):
    command = VehicleCommand(0.2, 0.1, 0.3, hand_brake=True, reverse=True)
    limited, was_limited = dataclasses.replace(command, **{key: value}).clamped()
    assert was_limited
    assert limited == dataclasses.replace(command, **{key: limit})


def test_vehicle_is_on_a_dry_road_without_wind_unless_conditions_are_set():
    vehicle = Vehicle(CAR)
    assert (vehicle.friction, vehicle.side_wind_mps) == (1.0, 0.0)
    vehicle.set_conditions(0.5, -3.0)
    assert (vehicle.friction, vehicle.side_wind_mps) == (0.5, -3.0)


def test_conditions_out_of_range_are_refused_and_change_nothing():
    vehicle = Vehicle(CAR, 100.0, 75.0)
    for conditions, name in (((100.5, 0.0), "friction"), ((1.0, 75.5), "side_wind_mps")):
        with pytest.raises(ValueError, match=name):
            vehicle.set_conditions(*conditions)
    assert (vehicle.friction, vehicle.side_wind_mps) == (100.0, 75.0)


def test_longest_internal_step_depends_on_the_tyres():
    soft = dataclasses.replace(
        CAR, front_cornering_stiffness_n_per_rad=5e4, rear_cornering_stiffness_n_per_rad=5e4
    )
    for parameters, longest in ((CAR, 2.0 / fastest_rate_per_s(CAR)), (soft, 0.01)):
        assert Vehicle(parameters, internal_step_s=longest).internal_step_s == longest
        with pytest.raises(ValueError, match="^internal_step_s must be in 0"):
            Vehicle(parameters, internal_step_s=1.01 * longest)


def test_reset_places_the_vehicle_at_rest_unless_a_speed_is_given():
    vehicle = Vehicle(CAR)
    vehicle.reset(1, 2, 3)
    assert vehicle.state == VehicleState(x_m=1.0, y_m=2.0, yaw_rad=3.0)
    vehicle.reset(1, 2, 3, 4)
    assert vehicle.state == VehicleState(x_m=1.0, y_m=2.0, yaw_rad=3.0, speed_mps=4.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("key", ["x_m", "y_m", "yaw_rad", "speed_mps"])
def test_reset_to_nan_is_refused_and_changes_nothing(key, value):
    vehicle = Vehicle(CAR)
    place = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "speed_mps": 0.0, key: value}
    with pytest.raises(ValueError, match=f"^reset refused: {key} is {value}$"):
        vehicle.reset(**place)
    assert vehicle.state == VehicleState()


def test_standing_vehicle_starts_with_finer_steps():
    vehicle = Vehicle(CAR, internal_step_s=0.005)
    constants = MotionConstants.of(CAR, 1.0, 0.0)
    for steps in (50, 10):
        start = tuple(vars(vehicle.state).values())
        expected = integrate(constants, start, (1.0, 0.0, 0.0), False, False, 0.05 / steps, steps)
        vehicle.step(VehicleCommand(throttle=1.0), 0.05)
        assert vehicle.state == VehicleState(*expected)
