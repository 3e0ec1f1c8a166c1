"""The integration of a vehicle's motion, step by step."""

from __future__ import annotations

import numpy as np
import pytest
from presets import TESLA

from sdc_sim.physics.vehicle_dynamics import MotionConstants
from sdc_sim.physics.vehicle_motion import integrate

MOTION = MotionConstants.of(TESLA, 1.0, 0.0)


def changed(**values):
    """Return the constants with other values."""
    return MotionConstants(**{**vars(MOTION), **values})


def moving(u_mps, v_mps=0.0, yaw_rate_radps=0.0, load_mps2=0.0):
    """Return a motion with the pedals and the wheels at rest."""
    return (0.0, 0.0, 0.0, u_mps, v_mps, yaw_rate_radps, *[0.0] * 6, load_mps2)


@pytest.mark.parametrize(
    ("speed_mps", "goals", "hand_brake", "reverse"),
    [
        *((14.0, (0.6, 0.0, 0.3), False, False), (14.0, (0.0, 0.4, -0.3), False, False)),
        *((-4.0, (0.7, 0.0, 0.5), False, True), (9.0, (0.8, 0.0, 0.1), True, False)),
    ],
)
def test_error_falls_with_the_square_of_the_step(speed_mps, goals, hand_brake, reverse):
    """Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.1."""
    car = changed(pedal_travel_s=0.2, steer_travel_s=0.4, load_transfer_time_s=0.3)
    start = moving(speed_mps, load_mps2=1.0)

    def state_after(steps):
        state = integrate(car, start, goals, hand_brake, reverse, 0.4 / steps, steps)
        return np.array(state)[[0, 1, 2, 3, 4, 5, 12]]  # the others are means of a step

    exact = state_after(6400)
    ratios = (state_after(100) - exact) / (state_after(200) - exact)
    assert np.all((ratios > 3.5) & (ratios < 4.5)), ratios
