import math

import numpy as np
import pytest

from sdc_localization.motion_model import YAW, motion_jacobian, moved, sideways_speed

STEP_S = 0.05


def test_constant_turn_is_a_circle():
    state, speed, rate = np.zeros(5), 8.0, 0.4
    steps = round(2.0 * math.pi / rate / STEP_S)
    for _ in range(steps):
        state = moved(state, speed, 0.0, 2.0 * math.pi / steps / STEP_S, STEP_S)
    assert np.hypot(*state[:2]) < 1e-6
    assert abs(state[YAW]) < 1e-9


def test_heading_stays_between_minus_pi_and_pi():
    state = moved(np.array([0.0, 0.0, 3.1, 0.0, 0.0]), 5.0, 0.0, 2.0, STEP_S)
    assert state[YAW] == pytest.approx(3.2 - 2.0 * math.pi)


@pytest.mark.parametrize("seed", range(5))
def test_jacobian_equals_the_numerical_derivatives(seed):
    random = np.random.default_rng(seed)
    state = np.array([*random.uniform(-50.0, 50.0, 2), *random.uniform(-1.0, 1.0, 3)])
    motion = random.uniform(0.0, 20.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
    numerical = np.empty((5, 5))
    for column in range(5):
        change = 1e-6 * np.eye(5)[column]
        ends = [moved(state + sign * change, *motion, STEP_S) for sign in (1.0, -1.0)]
        numerical[:, column] = (ends[0] - ends[1]) / 2e-6
    assert motion_jacobian(state, *motion, STEP_S) == pytest.approx(numerical, abs=1e-7)


def test_centre_of_the_car_moves_inwards_when_slow_and_outwards_when_fast():
    assert sideways_speed(1.0, 0.2, 1.4, 0.006) > 0.0
    assert sideways_speed(20.0, 0.2, 1.4, 0.006) < 0.0
