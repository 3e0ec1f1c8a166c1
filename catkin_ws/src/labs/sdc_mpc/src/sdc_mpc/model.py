"""The model: how the errors of the car change, as numbers and as matrices."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

WHEELBASE_M = 2.87


def rates(
    state: np.ndarray, wheel_rad: float, acceleration_mps2: float, curvature: float
) -> np.ndarray:
    """Return how fast the state changes.

    Args:
        state: (3,) cross-track error [m], heading error [rad], positive left, and speed [m/s]
        wheel_rad: angle of the front wheels, positive left [rad]
        acceleration_mps2: acceleration
        curvature: curvature of the path, positive left [1/m]

    Returns:
        (3,) rates [m/s, rad/s, m/s^2]
    """
    cross_track_m, heading_rad, speed_mps = state
    # TODO 1: the three rates (until then: return np.zeros(3))
    along_mps = speed_mps * np.cos(heading_rad) / (1.0 - curvature * cross_track_m)
    turning_radps = speed_mps * np.tan(wheel_rad) / WHEELBASE_M - curvature * along_mps
    return np.array([speed_mps * np.sin(heading_rad), turning_radps, acceleration_mps2])
    # ----------------------------------------------------------------------------


def linearized(speed_mps: float, curvature: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of `rates` for a car that follows the path exactly.

    Returns:
        A (3, 3) by the state, and B (3, 2) by wheel angle and acceleration
    """
    a, b = np.zeros((3, 3)), np.zeros((3, 2))
    # TODO 2: the entries that are not zero (until then: pass)
    a[0, 1] = speed_mps
    a[1, 0] = -(curvature**2) * speed_mps
    b[1, 0] = speed_mps / WHEELBASE_M * (1.0 + (WHEELBASE_M * curvature) ** 2)
    b[2, 1] = 1.0
    # ----------------------------------------------------------------------------
    return a, b


def discretized(a: np.ndarray, b: np.ndarray, tick_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices of one tick, in which the inputs hold: z after = ad z + bd u.

    Args:
        a: (3, 3)
        b: (3, 2)
        tick_s: duration of the tick [s]
    """
    # TODO 3: the exponential of both matrices together (until then: return a, b)
    held = expm(tick_s * np.block([[a, b], [np.zeros((2, 5))]]))
    return held[:3, :3], held[:3, 3:]
    # ----------------------------------------------------------------------------
