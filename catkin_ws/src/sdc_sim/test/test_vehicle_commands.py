"""Limits of the commands, the conditions and the start of a vehicle."""

from __future__ import annotations

import dataclasses
import os

import pytest

from sdc_common.driving import Command
from sdc_sim.physics.vehicle import Vehicle, VehicleState
from sdc_sim.physics.vehicle_parameters import load_vehicle

HERE = os.path.dirname(os.path.abspath(__file__))
CAR = load_vehicle(os.path.join(HERE, "..", "config", "vehicles", "tesla_model3.yaml"))


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
    command = Command(0.2, 0.1, 0.3, hand_brake=True, reverse=True)
    limited, was_limited = dataclasses.replace(command, **{key: value}).clamped()
    assert was_limited
    assert limited == dataclasses.replace(command, **{key: limit})


def test_reset_places_the_vehicle_at_rest_unless_a_speed_is_given():
    vehicle = Vehicle(CAR)
    vehicle.reset(1, 2, 3)
    assert vehicle.state == VehicleState(x_m=1.0, y_m=2.0, yaw_rad=3.0)
    vehicle.reset(1, 2, 3, 4)
    assert vehicle.state == VehicleState(x_m=1.0, y_m=2.0, yaw_rad=3.0, speed_mps=4.0)
