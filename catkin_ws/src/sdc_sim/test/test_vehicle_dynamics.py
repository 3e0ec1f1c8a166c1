"""The forces of tyres and air at known states of a vehicle."""

from __future__ import annotations

import dataclasses
import math
import os

import pytest

from sdc_sim.physics.vehicle_dynamics import (
    DynamicsConstants,
    derivatives,
    fastest_rate_per_s,
    tyre_forces,
)
from sdc_sim.physics.vehicle_parameters import load_vehicle

HERE = os.path.dirname(os.path.abspath(__file__))
CAR = dataclasses.replace(
    load_vehicle(os.path.join(HERE, "..", "config", "vehicles", "tesla_model3.yaml")),
    front_axle_m=1.2,
    rear_axle_m=1.8,
)
WEIGHT_N = 1845.0 * 9.81
# Straight wheels, no forces of the driver.
COASTING = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("speed_mps", [20.0, 0.5, -0.5, -20.0])
def test_drag_is_against_the_motion(speed_mps):
    car = DynamicsConstants.of(CAR, 1.0, 0.0)
    drag_n = 0.5 * 1.2 * CAR.drag_area_m2 * speed_mps**2
    rate, _, _ = derivatives(car, speed_mps, 0.0, 0.0, 0.0, COASTING)
    assert rate == pytest.approx(-math.copysign(drag_n / 1845.0, speed_mps))


@pytest.mark.parametrize("wind_mps", [20.0, 0.5, -0.5, -20.0])
def test_side_wind_pushes_and_turns_a_vehicle_at_rest(wind_mps):
    car = DynamicsConstants.of(CAR, 1.0, wind_mps)
    force_n = math.copysign(0.5 * 1.2 * CAR.side_drag_area_m2 * wind_mps**2, wind_mps)
    _, left, turn = derivatives(car, 0.0, 0.0, 0.0, 0.0, COASTING)
    assert left == pytest.approx(force_n / 1845.0)
    assert turn == pytest.approx(CAR.wind_arm_m * force_n / CAR.yaw_inertia_kgm2)


@pytest.mark.parametrize(("lateral_mps", "yaw_rate_radps"), [(2.0, 0.0), (0.0, 3.0)])
def test_air_resists_a_motion_to_the_side(lateral_mps, yaw_rate_radps):
    no_air = dataclasses.replace(CAR, side_drag_area_m2=0.0)
    (_, left, _), (_, left_no_air, _) = (
        derivatives(
            DynamicsConstants.of(car, 1.0, 0.0), 20.0, lateral_mps, yaw_rate_radps, 0.0, COASTING
        )
        for car in (CAR, no_air)
    )
    air_mps = lateral_mps + CAR.wind_arm_m * yaw_rate_radps
    force_n = 0.5 * 1.2 * CAR.side_drag_area_m2 * air_mps**2
    assert left - left_no_air == pytest.approx(-force_n / 1845.0)


@pytest.mark.parametrize(
    ("load_transfer_mps2", "front_load_n"),
    [(100.0, 0.05 * 0.6 * WEIGHT_N), (-100.0, WEIGHT_N - 0.05 * 0.4 * WEIGHT_N)],
)
def test_each_axle_keeps_a_twentieth_of_its_load(load_transfer_mps2, front_load_n):
    car = DynamicsConstants.of(CAR, 1.0, 0.0)
    full_brake = (0.0, 1.0, 0.0, 0.0, 1e6, 0.0, 1.0)
    rate, _, _ = derivatives(car, 1e-6, 0.0, 0.0, load_transfer_mps2, full_brake)
    grip_n = CAR.tyre_friction * front_load_n * CAR.pedal_grip_share
    assert rate == pytest.approx(-grip_n / 1845.0)


@pytest.mark.parametrize("sliding_mps", [0.75, -0.75])
def test_sliding_takes_its_share_of_the_grip_from_the_pedals(sliding_mps):
    ahead_n, left_n = tyre_forces(1.4, 10.0, 1.0, sliding_mps, 5000.0, 1000.0, 900.0)
    assert ahead_n == pytest.approx(900.0 * 0.8)
    assert left_n * sliding_mps < 0.0
    assert math.hypot(ahead_n, left_n) <= 1000.0


def test_locked_wheel_has_no_grip_to_the_side():
    # The share of the grip in use is rounded to more than 1.
    usable_n = 1000.0 * (1.0 + 1e-15)
    assert tyre_forces(1.4, 10.0, 5.0, 0.0, -5000.0, 1000.0, usable_n) == (-usable_n, 0.0)
    ahead_n, left_n = tyre_forces(1.4, 10.0, 5.0, 1e-10, -5000.0, 1000.0, usable_n)
    assert (ahead_n, left_n) == (-usable_n, 0.0)


def test_fastest_rate_is_the_trace_of_the_jacobian():
    mass, inertia = 1845.0, 2900.0
    front = 130e3 * (1.0 / mass + 1.2**2 / inertia)
    rear = 150e3 * (1.0 / mass + 1.8**2 / inertia)
    assert fastest_rate_per_s(CAR) == pytest.approx((front + rear) / 1.5)
