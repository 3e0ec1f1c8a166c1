"""Call modules of the lab's library with known arguments, for library_probe.py."""

from __future__ import annotations

import math
from random import Random

import numpy as np

STATE = (1.0, 2.0, 0.3, 0.02, 0.05)
P = np.diag([0.4, 0.3, 0.2, 0.1, 0.1])
P[0, 1] = P[1, 0] = 0.2
P[1, 2] = P[2, 1] = -0.1
F = np.eye(5)
F[0, 2], F[1, 2], F[2, 3], F[0, 4] = -0.5, 0.8, -0.1, 0.7
Q = np.diag([0.01, 0.02, 0.03, 0.04, 0.05])
H = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.5, 0.0, 0.0]])
R = np.array([[0.5, 0.1], [0.1, 0.6]])
S = np.array([[0.9, 0.3], [0.3, 0.7]])
# Not the optimal gain: with that one, several forms of the covariance give the same.
K = np.array([[0.3, 0.1], [0.1, 0.4], [0.0, 0.2], [0.1, 0.0], [0.0, 0.1]])
INNOVATION = np.array([0.5, -0.4])
# Innovations and limits, and whether they are plausible with S.
GATES = (
    ((0.5, -0.4), 2.0, True),
    ((2.0, 2.0), 9.0, True),
    ((2.0, -2.0), 9.0, False),
    ((4.0, 0.0), 13.8, False),
    ((2.5, 2.5), 12.0, True),
)
HEADINGS = (0.2, 0.7, 2.0, -0.7, -2.0)
COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 5.0, 0.6], [0.5, 0.6, 6.0]])


def motion_model(random: Random) -> dict:
    """Return states after a step, and Jacobians."""
    from sdc_localization.motion_model import motion_jacobian, moved

    def after(state: tuple, *motion: float) -> list:
        return list(map(float, moved(np.array(state), *motion)))

    other = tuple(random.uniform(-1.0, 1.0) for _ in range(5))
    motion = random.uniform(1.0, 20.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.07
    return {
        "other": [
            *after(other, *motion),
            *map(float, motion_jacobian(np.array(other), *motion).ravel()),
        ],
        "straight": after((0.0,) * 5, 10.0, 0.0, 0.0, 0.1),
        "north": after((0.0, 0.0, 0.5 * math.pi, 0.0, 0.0), 10.0, 0.0, 0.0, 0.1),
        "sideways": after((0.0,) * 5, 0.0, 1.0, 0.0, 0.1),
        "turn": after((0.0, 0.0, 0.0, 0.2, 0.0), 0.0, 0.0, 0.5, 0.1),
        "wrap": after((0.0, 0.0, 3.1, 0.0, 0.0), 0.0, 0.0, 1.0, 0.1),
        "scale": after((0.0, 0.0, 0.0, 0.0, 0.1), 10.0, 0.0, 0.0, 0.1),
        "jacobian": motion_jacobian(np.array(STATE), 8.0, 0.5, 0.4, 0.1).tolist(),
    }


def kalman_filter(random: Random) -> dict:
    """Return the results of the equations for known and for random matrices."""
    from sdc_localization import kalman_filter as kalman

    def number(value: object) -> list:
        return np.asarray(value, float).tolist()

    factor, limit = random.uniform(0.5, 2.0), random.uniform(1.0, 3.0)
    state = np.array((*STATE[:2], random.uniform(-3.0, 3.0), *STATE[3:]))
    plausible = [
        bool(kalman.is_plausible(factor * np.array(one), S, limit * end)) for one, end, _ in GATES
    ]
    return {
        "other": [
            number(kalman.predicted_covariance(factor * P, F, Q)),
            number(kalman.innovation_covariance(factor * P, H, R)),
            number(kalman.gain(factor * P, H, S)),
            [float(one) for one in plausible],
            number(kalman.corrected_state(state, K, factor * INNOVATION)),
            number(kalman.corrected_covariance(factor * P, K, H, R)),
        ],
        "predicted": number(kalman.predicted_covariance(P, F, Q)),
        "innovation": number(kalman.innovation_covariance(P, H, R)),
        "gain": number(kalman.gain(P, H, S)),
        "plausible": [
            bool(kalman.is_plausible(np.array(one), S, limit)) for one, limit, _ in GATES
        ],
        "state": number(kalman.corrected_state(np.array(STATE), K, INNOVATION)),
        "wrapped": number(
            kalman.corrected_state(np.array([0.0, 0.0, 3.1, 0.0, 0.0]), K, -INNOVATION)
        ),
        "covariance": number(kalman.corrected_covariance(P, K, H, R)),
    }


def localizer(random: Random) -> dict:
    """Return headings between two waypoints."""
    from sdc_localization.localizer import initial_heading

    def heading(direction: float, length: float = 2.0) -> float:
        start = (3.0, -1.0)
        end = start[0] + length * math.cos(direction), start[1] + length * math.sin(direction)
        return float(initial_heading(start, end))

    return {
        "other": [heading(random.uniform(-3.0, 3.0), random.uniform(0.5, 2.0)) for _ in range(4)],
        "headings": [heading(direction) for direction in HEADINGS],
    }


def odometry_message(random: Random) -> dict:
    """Return the covariance of a pose."""
    from sdc_localization.odometry_message import pose_covariance

    return {
        "other": list(map(float, pose_covariance(random.uniform(0.5, 2.0) * COVARIANCE))),
        "covariance": list(map(float, pose_covariance(COVARIANCE))),
    }


def landmarks(random: Random) -> dict:
    """Return expected measurements of landmarks, and a Jacobian."""
    from sdc_localization.landmarks import expected_measurement, measurement_jacobian

    def expected(yaw: float, x: float, y: float) -> list:
        return list(map(float, expected_measurement(np.array([1.0, 2.0, yaw, 0.0, 0.0]), x, y)))

    place = random.uniform(5.0, 20.0), random.uniform(-10.0, 10.0)
    state = np.array([1.0, 2.0, random.uniform(-1.0, 1.0), 0.0, 0.0])
    return {
        "other": [
            *expected(state[2], *place),
            *map(float, measurement_jacobian(state, *place).ravel()),
        ],
        "left": expected(0.5, 4.0, 6.0),
        "behind": expected(3.0, -2.0, 1.0),
        "jacobian": measurement_jacobian(np.array(STATE), 4.0, 6.0).tolist(),
    }


LOCALIZATION_PROBES = {
    probe.__name__: probe
    for probe in (motion_model, kalman_filter, localizer, odometry_message, landmarks)
}
