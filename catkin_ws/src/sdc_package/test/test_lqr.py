import math

import numpy as np
import pytest

from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.lqr import (
    LqrFeedforwardSteering,
    LqrSteering,
    error_model,
    lqr_gains,
    steady_state,
)

# The car of Snider's report: 1140 kg, 1436.24 kg m^2, 155494.663 N/rad at each axle.
AXLES = Axles(1.165, 1.165, 570.0 / 155494.663, 570.0 / 155494.663)
GYRATION = math.sqrt(1436.24 / 1140.0)
PARAMETERS = {
    "cross_track_weight": 1.0,
    "cross_track_rate_weight": 0.0,
    "heading_weight": 1.0,
    "heading_rate_weight": 0.0,
    "steer_weight": 1.0,
    "gyration_m": GYRATION,
    "tick_s": 0.05,
    "preview_s": 0.0,
}


def test_error_model_equals_that_of_the_book():
    """Rajamani, equation 2.45, in mass, inertia and stiffness, for a car with different axles."""
    m, inertia, front, rear, lf, lr, v = 1200.0, 1500.0, 90000.0, 130000.0, 1.2, 1.5, 10.0
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
def test_gains_are_stable_and_optimal(speed):
    weights, steer_weight, tick = (1.0, 0.0, 1.0, 0.0), 1.0, 0.05
    gains = np.array(lqr_gains(speed, AXLES, GYRATION, weights, steer_weight, tick))
    a, b = error_model(speed, AXLES, GYRATION)
    # Many small Euler steps give the sampled system without the matrix exponential.
    small = tick / 40000
    step = np.block([[np.eye(4) + small * a, small * b], [np.zeros((1, 4)), np.eye(1)]])
    many = np.linalg.matrix_power(step, 40000)
    fine, held = many[:4, :4], many[:4, 4:]
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


def test_only_the_feed_forward_holds_a_circle_without_an_error():
    wheel, heading_error = steady_state(1.0 / 64.0, 15.0, AXLES)
    steady = (0.0, 0.0, heading_error, 0.0, 1.0 / 64.0, 15.0)
    assert LqrFeedforwardSteering(AXLES, **PARAMETERS).feedback(*steady) == pytest.approx(
        wheel, abs=1e-12
    )
    assert abs(LqrSteering(AXLES, **PARAMETERS).feedback(*steady) - wheel) > 0.01


RADIUS = 25.0


def circle():
    path = ReferencePath()
    angles = [0.2 * i / RADIUS for i in range(200)]
    path.update([(RADIUS * math.sin(a), RADIUS * (1.0 - math.cos(a)), 5.0) for a in angles])
    return path


def beside_circle(left_m, heading_error):
    """Return the pose of a car at this distance and direction from a point of the circle."""
    angle = 15.0 / RADIUS
    inside = RADIUS - left_m
    return inside * math.sin(angle), RADIUS - inside * math.cos(angle), angle + heading_error


@pytest.mark.parametrize(
    ("left_m", "heading_error", "yaw_rate"),
    [(0.0, 0.0, 0.2), (0.7, 0.0, 0.2), (0.0, 0.3, 0.2), (-0.4, -0.2, 0.8), (0.5, 0.6, -0.8)],
)
def test_wheel_angle_is_the_gains_times_the_errors(left_m, heading_error, yaw_rate):
    """The centre slips to the left at the speed that it has in a steady bend of this yaw rate."""
    speed = 10.0
    sideways = (1.165 - AXLES.rear_compliance * speed**2) * yaw_rate
    errors = [
        left_m,
        speed * math.sin(heading_error) + sideways * math.cos(heading_error),
        heading_error,
        yaw_rate - speed / RADIUS,
    ]
    gains = lqr_gains(speed, AXLES, GYRATION, (1.0, 0.2, 1.0, 0.1), 1.0, 0.05)
    parameters = {**PARAMETERS, "cross_track_rate_weight": 0.2, "heading_rate_weight": 0.1}
    pose = beside_circle(left_m, heading_error)
    wheel, with_feed_forward = (
        method(AXLES, **parameters).wheel_angle(circle(), *pose, speed, yaw_rate)
        for method in (LqrSteering, LqrFeedforwardSteering)
    )
    assert wheel == pytest.approx(-np.dot(gains, errors), abs=1e-3)
    steady_wheel, steady_error = steady_state(1.0 / RADIUS, speed, AXLES)
    forward = steady_wheel + gains[2] * steady_error
    assert with_feed_forward - wheel == pytest.approx(forward, abs=1e-3)


def test_calm_steering_turns_the_wheels_less_at_high_speed_only():
    plain = LqrSteering(AXLES, **PARAMETERS)
    calm = LqrSteering(AXLES, **PARAMETERS, calm_above_mps=0.9)
    assert abs(calm.feedback(1.0, 0.0, 0.0, 0.0, 0.0, 20.0)) < 0.1 * abs(
        plain.feedback(1.0, 0.0, 0.0, 0.0, 0.0, 20.0)
    )
