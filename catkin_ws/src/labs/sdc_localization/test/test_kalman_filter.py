import numpy as np
import pytest

from sdc_localization import kalman_filter as kalman


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
