"""The forces of tyres and air at known states of a vehicle, and their integration."""

import math

import numpy as np
import pytest
from presets import TESLA, preset

from sdc_sim.physics.vehicle_dynamics import MotionConstants, derivatives, tyre_forces
from sdc_sim.physics.vehicle_motion import integrate

CAR = preset(front_axle_m=1.2, rear_axle_m=1.8)
# Straight wheels, no forces of the driver.
COASTING = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize("speed_mps", [20.0, 0.5, -0.5, -20.0])
def test_drag_is_against_the_motion(speed_mps):
    car = MotionConstants.of(CAR, 1.0, 0.0)
    drag_n = 0.5 * 1.2 * CAR.drag_area_m2 * speed_mps**2
    rate, _, _ = derivatives(car, speed_mps, 0.0, 0.0, 0.0, COASTING)
    assert rate == pytest.approx(-math.copysign(drag_n / 1845.0, speed_mps))


@pytest.mark.parametrize("wind_mps", [20.0, 0.5, -0.5, -20.0])
def test_side_wind_pushes_and_turns_a_vehicle_at_rest(wind_mps):
    car = MotionConstants.of(CAR, 1.0, wind_mps)
    force_n = math.copysign(0.5 * 1.2 * CAR.side_drag_area_m2 * wind_mps**2, wind_mps)
    _, left, turn = derivatives(car, 0.0, 0.0, 0.0, 0.0, COASTING)
    assert left == pytest.approx(force_n / 1845.0)
    assert turn == pytest.approx(CAR.wind_arm_m * force_n / CAR.yaw_inertia_kgm2)


def test_braking_takes_lateral_grip_by_the_friction_ellipse():
    (_, free_n), (along_n, across_n) = (
        tyre_forces(1.3, 10.0, 10.0, 2.0, demand_n, 5000.0, 5000.0) for demand_n in (0.0, -3000.0)
    )
    assert along_n == -3000.0
    assert across_n == pytest.approx(0.8 * free_n)
    assert free_n < -2000.0


@pytest.mark.parametrize(
    ("speed_mps", "goals", "hand_brake", "reverse"),
    [
        *((14.0, (0.6, 0.0, 0.3), False, False), (14.0, (0.0, 0.4, -0.3), False, False)),
        *((-4.0, (0.7, 0.0, 0.5), False, True), (9.0, (0.8, 0.0, 0.1), True, False)),
    ],
)
def test_error_falls_with_the_square_of_the_step(speed_mps, goals, hand_brake, reverse):
    """Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.1."""
    travel = {"pedal_travel_s": 0.2, "steer_travel_s": 0.4, "load_transfer_time_s": 0.3}
    car = MotionConstants(**{**vars(MotionConstants.of(TESLA, 1.0, 0.0)), **travel})
    # The speed, and a load transfer of 1 m/s^2; the pedals and the wheels are at rest.
    start = (0.0, 0.0, 0.0, speed_mps, *[0.0] * 8, 1.0)

    def state_after(steps):
        state = integrate(car, start, goals, hand_brake, reverse, 0.4 / steps, steps)
        return np.array(state)[[0, 1, 2, 3, 4, 5, 12]]  # the others are means of a step

    exact = state_after(6400)
    ratios = (state_after(100) - exact) / (state_after(200) - exact)
    assert np.all((ratios > 3.5) & (ratios < 4.5)), ratios
