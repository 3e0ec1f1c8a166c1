"""The integration of a vehicle's motion, step by step."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest

from sdc_sim.physics import vehicle_motion
from sdc_sim.physics.vehicle_dynamics import AIR_DENSITY_KGPM3, GRAVITY_MPS2
from sdc_sim.physics.vehicle_motion import (
    MotionConstants,
    approach,
    drive_force,
    heun_step,
    integrate,
    integrate_fleet,
    resistance,
    step_count,
)
from sdc_sim.physics.vehicle_parameters import load_vehicle

HERE = os.path.dirname(os.path.abspath(__file__))
CAR = load_vehicle(os.path.join(HERE, "..", "config", "vehicles", "tesla_model3.yaml"))
MOTION = MotionConstants.of(CAR, 1.0, 0.0)
# Straight wheels, no forces of the driver.
COASTING = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@pytest.fixture
def demands(monkeypatch):
    """Return a list that gets the demand of each step, after which the motion stays as it was."""
    recorded = []

    def record(c, start, demand, *_):
        recorded.append(demand)
        return (*start, 0.0, 0.0)

    monkeypatch.setattr(vehicle_motion, "heun_step", record)
    return recorded


def moving(u_mps, v_mps=0.0, yaw_rate_radps=0.0, load_mps2=0.0):
    """Return a motion with the pedals and the wheels at rest."""
    return (0.0, 0.0, 0.0, u_mps, v_mps, yaw_rate_radps, *[0.0] * 6, load_mps2)


@pytest.mark.parametrize(
    ("goal", "position", "mean"),
    [
        (0.9, 0.3, 0.25),
        (-0.9, 0.1, 0.15),
        # It arrives after a quarter of the step.
        (0.225, 0.225, 0.221875),
        (0.175, 0.175, 0.178125),
        (0.2, 0.2, 0.2),
    ],
)
def test_pedal_moves_at_a_constant_rate_until_it_arrives(goal, position, mean):
    assert approach(0.2, goal, 0.1) == pytest.approx((position, mean))


@pytest.mark.parametrize(
    ("throttle", "pull_n", "speed_mps", "reverse", "force_n"),
    [
        (0.5, 3000.0, 5.0, False, 3000.0),
        (0.5, 3000.0, -5.0, False, 3000.0),
        (0.5, 3000.0, 20.0, False, 1000.0),
        (0.5, 100.0, 2.0, False, 400.0),
        (0.5, 100.0, -2.0, False, 400.0),
        (0.5, 3000.0, 0.0, True, -3000.0),
        (0.5, 3000.0, -5.0, True, -3000.0),
        (0.5, 3000.0, -5.5, True, -1500.0),
        (0.5, 3000.0, -6.5, True, 0.0),
    ],
)
def test_force_of_the_motor(throttle, pull_n, speed_mps, reverse, force_n):
    car = MOTION._replace(
        creep_force_n=1000.0,
        creep_damping_n_per_mps=50.0,
        drive_power_w=20_000.0,
        reverse_speed_mps=6.0,
    )
    assert drive_force(car, pull_n, throttle, speed_mps, reverse) == pytest.approx(force_n)


@pytest.mark.parametrize(
    ("speed_mps", "centripetal_mps2", "drive_n", "direction", "share"),
    [
        (3.0, 0.5, -100.0, 1.0, 1.0),
        (-3.0, 0.5, 100.0, -1.0, 1.0),
        (0.0, 0.0, 250.0, 1.0, 0.5),
        (0.0, 0.0, -125.0, -1.0, 0.25),
        (0.0, 0.0, 0.4, 1.0, 0.0008),
        (0.0, 0.0, 2000.0, 1.0, 1.0),
        (0.0, 0.5, -400.0, 1.0, 0.2),
        (0.0, 0.0, 0.0, 0.0, 0.0),
    ],
)
def test_resistance_is_against_the_motion_or_what_starts_it(
    speed_mps, centripetal_mps2, drive_n, direction, share
):
    found = resistance(1000.0, speed_mps, centripetal_mps2, drive_n, 500.0)
    assert found == pytest.approx((direction, share))


@pytest.mark.parametrize("friction", [1.0, 0.4])
def test_tyres_hold_a_wind_up_to_their_grip(friction):
    grip_n = friction * CAR.tyre_friction * CAR.mass_kg * GRAVITY_MPS2
    limit_mps = math.sqrt(grip_n / (0.5 * AIR_DENSITY_KGPM3 * CAR.side_drag_area_m2))
    assert MotionConstants.of(CAR, friction, 0.99 * limit_mps).tyres_hold_wind
    assert not MotionConstants.of(CAR, friction, 1.01 * limit_mps).tyres_hold_wind


@pytest.mark.parametrize(
    ("speed_mps", "goals", "hand_brake", "reverse"),
    [
        (14.0, (0.6, 0.0, 0.3), False, False),
        (14.0, (0.0, 0.4, -0.3), False, False),
        (-4.0, (0.7, 0.0, 0.5), False, True),
        (9.0, (0.8, 0.0, 0.1), True, False),
    ],
)
def test_error_falls_with_the_square_of_the_step(speed_mps, goals, hand_brake, reverse):
    """Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.1."""
    car = MOTION._replace(pedal_travel_s=0.2, steer_travel_s=0.4, load_transfer_time_s=0.3)
    start = moving(speed_mps, load_mps2=1.0)

    def state_after(steps):
        state = integrate(car, start, goals, hand_brake, reverse, 0.4 / steps, steps)
        return np.array(state)[[0, 1, 2, 3, 4, 5, 12]]  # the others are means of a step

    exact = state_after(6400)
    ratios = (state_after(100) - exact) / (state_after(200) - exact)
    assert np.all((ratios > 3.5) & (ratios < 4.5)), ratios


def test_load_moves_to_the_longitudinal_acceleration():
    start = (1.0, 2.0, 0.5, 15.0, 0.4, 0.6, 0.0)
    demand = (0.05, 0.99875, 900.0, 900.0, 50.0, 50.0, 1.0)
    after = heun_step(MOTION, start, demand, 1.0, 0.001, 1.0)
    v_mps, yaw_rate_radps, load_mps2, speed_rate_mps2 = after[4:8]
    side_mps2 = 0.25 * (0.4 + v_mps) * (0.6 + yaw_rate_radps)
    assert speed_rate_mps2 == pytest.approx((after[3] - 15.0) / 0.001)
    assert load_mps2 == pytest.approx(speed_rate_mps2 - side_mps2)


@pytest.mark.parametrize(
    ("v_mps", "yaw_rate_radps", "holds", "ends"),
    [
        (0.01, 0.01, True, True),
        (0.01, 0.5, True, False),
        (0.5, 0.01, True, False),
        (0.01, 0.01, False, False),
        (-0.5, -0.5, True, False),
    ],
)
def test_a_vehicle_that_resistance_stops_holds_still_if_it_slides_slowly(
    v_mps, yaw_rate_radps, holds, ends
):
    car = MOTION._replace(tyres_hold_wind=holds)
    backwards = (0.0, 0.0, 0.0, -0.001, v_mps, yaw_rate_radps, 0.0)
    after = heun_step(car, backwards, COASTING, 1.0, 1e-5, 0.1)
    assert after[3] == 0.0
    assert (after[4] == after[5] == 0.0) == ends
    assert ends or after[4:6] == pytest.approx((v_mps, yaw_rate_radps), rel=0.1)


def test_vehicle_that_slides_at_an_angle_of_90_degrees_gets_no_push_along():
    after = integrate(MOTION, moving(0.0, 0.5), (0.0, 0.0, 0.0), False, False, 0.001, 1)
    assert after[3] == pytest.approx(0.0, abs=1e-6)


def test_load_of_a_vehicle_at_rest_fades():
    after = integrate(MOTION, moving(0.0, load_mps2=2.0), (0.0, 0.0, 0.0), False, False, 0.01, 7)
    assert after[12] == pytest.approx(2.0 * math.exp(-0.07 / MOTION.load_transfer_time_s))
    assert after[:12] == moving(0.0)[:12]


@pytest.mark.parametrize("hand_brake", [False, True])
def test_nothing_but_resistance_changes_the_speed_of_a_coasting_vehicle(hand_brake):
    without = MOTION._replace(
        rolling_front_n=0.0,
        rolling_rear_n=0.0,
        hand_brake_n=0.0,
        dynamics=MOTION.dynamics._replace(drag_kgpm=0.0),
    )
    throttle = 1.0 if hand_brake else 0.0  # the hand brake takes the motor off
    after = integrate(without, moving(9.0), (throttle, 0.0, 0.0), hand_brake, False, 0.01, 5)
    assert after[3] == 9.0


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("hand_brake", [False, True])
def test_demand_on_the_axles(direction, hand_brake, demands):
    car = MOTION._replace(pedal_travel_s=0.001, drive_front_share=0.3, creep_force_n=0.0)
    integrate(car, moving(8.0 * direction), (0.4, 0.5, 0.0), hand_brake, False, 0.1, 2)
    front_n = car.rolling_front_n + 0.5 * car.brake_front_n
    rear_n = car.rolling_rear_n + 0.5 * car.brake_rear_n + hand_brake * car.hand_brake_n
    drive_front_n, drive_rear_n, *others = demands[-1][2:]
    expected = (
        direction * front_n,
        direction * rear_n,
        1.0 if hand_brake else car.pedal_grip_share,
    )
    assert others == pytest.approx(expected)
    if hand_brake:
        assert drive_front_n == drive_rear_n == 0.0
    else:
        assert drive_front_n / (drive_front_n + drive_rear_n) == pytest.approx(0.3)
        assert drive_rear_n > 0.0


def test_brakes_of_a_standing_vehicle_take_as_much_as_pushes_it(demands):
    car = MOTION._replace(rolling_front_n=300.0, rolling_rear_n=100.0)
    # It turns on the spot and slides: 0.1 m/s^2 backwards.
    integrate(car, moving(0.0, -0.2, 0.5), (0.0, 0.0, 0.0), False, False, 0.01, 1)
    push_n = 0.1 * car.mass_kg
    assert demands[0][4:6] == pytest.approx((-0.75 * push_n, -0.25 * push_n))


def test_fleet_moves_as_each_of_its_vehicles_does():
    start = np.array([moving(speed, 0.1, 0.02, 0.5) for speed in (3.0, 8.0, 14.0, 20.0)]).T
    start[:, 2] = 0.0  # this one starts from rest
    start[0], start[2] = (1.0, 2.0, 3.0, 4.0), 0.3
    goals = np.array([[0.3, 0.4, 0.9, 0.6], [0.0, 0.2, 0.0, 0.1], [0.1, -0.2, 0.3, 0.4]])
    states = start.copy()
    integrate_fleet(MOTION, states, goals, 0.05, 0.02, 1, 3)
    for one in (1, 2):
        steps = step_count(start[3, one], 0.05, 0.02)
        expected = integrate(
            MOTION, tuple(start[:, one]), tuple(goals[:, one]), False, False, 0.05 / steps, steps
        )
        assert tuple(states[:, one]) == expected
    np.testing.assert_array_equal(states[:, [0, 3]], start[:, [0, 3]])
