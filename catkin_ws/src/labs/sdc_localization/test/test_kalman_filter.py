import math

import numpy as np
import pytest

from sdc_localization import kalman_filter as kalman
from sdc_localization.landmarks import expected_measurement, measurement_jacobian
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
def test_jacobians_equal_the_numerical_derivatives(seed):
    random = np.random.default_rng(seed)
    state = np.array([*random.uniform(-5.0, 5.0, 2), *random.uniform(-1.0, 1.0, 3)])
    motion = random.uniform(0.0, 20.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
    for function, jacobian, arguments in (
        (moved, motion_jacobian, (*motion, STEP_S)),
        (expected_measurement, measurement_jacobian, random.uniform(8.0, 20.0, 2)),
    ):
        columns = [
            (function(state + change, *arguments) - function(state - change, *arguments)) / 2e-6
            for change in 1e-6 * np.eye(5)
        ]
        numerical = np.transpose(columns)
        assert jacobian(state, *arguments) == pytest.approx(numerical, abs=1e-7)


def test_centre_of_the_car_moves_inwards_when_slow_and_outwards_when_fast():
    assert sideways_speed(1.0, 0.2, 1.4, 0.006) > 0.0
    assert sideways_speed(20.0, 0.2, 1.4, 0.006) < 0.0


def test_two_measurements_of_one_number_give_their_mean():
    P, H, R = np.diag([2.0, 1.0, 1.0, 1.0, 1.0]), np.eye(1, 5), np.array([[2.0]])
    S = kalman.innovation_covariance(P, H, R)
    K = kalman.gain(P, H, S)
    assert kalman.corrected_state(np.zeros(5), K, np.array([3.0]))[0] == pytest.approx(1.5)
    assert kalman.corrected_covariance(P, K, H, R)[0, 0] == pytest.approx(1.0)


def test_gate_lets_as_many_measurements_pass_as_its_quantile_says():
    random = np.random.default_rng(0)
    root = random.normal(size=(2, 2))
    S = root @ root.T + 0.1 * np.eye(2)
    draws = random.multivariate_normal(np.zeros(2), S, 4000)
    share = np.mean([kalman.is_plausible(draw, S, 4.605) for draw in draws])
    assert share == pytest.approx(0.9, abs=0.015)
