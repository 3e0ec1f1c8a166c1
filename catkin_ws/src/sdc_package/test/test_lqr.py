import math

import numpy as np
import pytest

from sdc_package.steering.axles import Axles
from sdc_package.steering.lqr import (
    GainSchedule,
    LqrFeedforwardSteering,
    LqrSteering,
    error_model,
    lqr_gains,
    steady_state,
)

# 1140 kg, 1436.24 kg m^2, 155494.663 N/rad at each axle: the car of Snider's report.
AXLES = Axles(1.165, 1.165, 570.0 / 155494.663, 570.0 / 155494.663)
GYRATION = math.sqrt(1436.24 / 1140.0)
FIGURES = {
    "cross_track_weight": 1.0,
    "cross_track_rate_weight": 0.0,
    "heading_weight": 1.0,
    "heading_rate_weight": 0.0,
    "steer_weight": 1.0,
    "gyration_m": GYRATION,
    "tick_s": 0.05,
    "preview_s": 0.0,
}


def test_model_by_hand():
    """Rajamani, equation 2.45, with mass, inertia and stiffness instead of compliances, for a car whose axles differ."""
    m, inertia, front, rear, lf, lr, v = 1200.0, 1500.0, 90000.0, 130000.0, 1.0, 1.5, 10.0
    axles = Axles(lf, lr, m * lr / (lf + lr) / front, m * lf / (lf + lr) / rear)
    a, b = error_model(v, axles, math.sqrt(inertia / m))
    turn, damping = lf * front - lr * rear, lf * lf * front + lr * lr * rear
    assert a == pytest.approx(
        np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.0, -(front + rear) / (m * v), (front + rear) / m, -turn / (m * v)],
                [0.0, 0.0, 0.0, 1.0],
                [0.0, -turn / (inertia * v), turn / inertia, -damping / (inertia * v)],
            ]
        )
    )
    assert b[:, 0] == pytest.approx([0.0, front / m, 0.0, lf * front / inertia])


@pytest.mark.parametrize("speed", [1.0, 5.0, 15.0, 40.0])
def test_gains_make_the_sampled_car_stable_and_are_optimal(speed):
    weights, steer_weight, tick = (1.0, 0.0, 1.0, 0.0), 1.0, 0.05
    gains = np.array(lqr_gains(speed, AXLES, GYRATION, weights, steer_weight, tick))
    a, b = error_model(speed, AXLES, GYRATION)
    # The held system by many small Euler steps: a way of its own to the same matrices.
    fine, small = np.eye(4), tick / 40000
    held = np.zeros((4, 1))
    for _ in range(40000):
        fine, held = fine + small * a @ fine, held + small * (a @ held + b)
    assert np.abs(np.linalg.eigvals(fine - held @ gains[np.newaxis])).max() < 0.9999

    def cost(k):
        x, total = np.array([1.0, 0.0, 0.1, 0.0]), 0.0
        for _ in range(600):
            wheel = float(-k @ x)
            total += float(np.array(weights) @ x**2) + steer_weight * wheel**2
            x = fine @ x + held[:, 0] * wheel
        return total

    best = cost(gains)
    for i in range(4):
        for factor in (0.9, 1.1):
            other = gains.copy()
            other[i] *= factor
            assert cost(other) >= best * (1.0 - 1e-4)


def test_schedule_is_linear_between_and_constant_beyond():
    schedule = GainSchedule([1.0, 2.0, 3.0], [[1.0, 0.0], [3.0, 1.0], [4.0, 1.0]])
    assert [schedule.gains(speed)[0] for speed in (0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 9.0)] == [
        1.0,
        1.0,
        2.0,
        3.0,
        3.5,
        4.0,
        4.0,
    ]


def test_steady_state_by_hand():
    understeering = Axles(1.165, 1.165, 0.005, 0.003)
    wheel, heading_error = steady_state(0.01, 10.0, understeering)
    assert wheel == pytest.approx(2.33 * 0.01 + 0.002 * 1.0, abs=2e-5)
    assert heading_error == pytest.approx(-1.165 * 0.01 + 0.003 * 1.0, abs=1e-5)


def test_feed_forward_holds_the_circle_without_an_error_and_feedback_alone_does_not():
    wheel, heading_error = steady_state(1.0 / 64.0, 15.0, AXLES)
    steady = (0.0, 0.0, heading_error, 0.0, 1.0 / 64.0, 15.0)
    assert LqrFeedforwardSteering(AXLES, **FIGURES).feedback(*steady) == pytest.approx(
        wheel, abs=1e-12
    )
    assert abs(LqrSteering(AXLES, **FIGURES).feedback(*steady) - wheel) > 0.01
