"""The equations of the extended Kalman filter, one function each.

The letters are those of Thrun, Burgard, Fox, Probabilistic Robotics, table 3.3, with two changes
that are common: F and H are the Jacobians of motion and measurement, P is the covariance.
"""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_localization.motion_model import YAW


def predicted_covariance(P: np.ndarray, F: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Return the covariance after a motion.

    Args:
        P: (n, n) covariance before it
        F: (n, n) Jacobian of the motion
        Q: (n, n) covariance of what the motion model does not know

    Reference: Probabilistic Robotics, table 3.3, line 3.
    """
    # TODO 3: the covariance after the motion (until then: return P)
    return F @ P @ F.T + Q
    # ----------------------------------------------------------------------------


def innovation_covariance(P: np.ndarray, H: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Return S, the covariance of the difference between measurement and expectation.

    Args:
        P: (n, n) covariance of the state
        H: (m, n) Jacobian of the measurement
        R: (m, m) covariance of the noise of the measurement
    """
    # TODO 4: how uncertain the expected measurement and the measured one are (until then: return R)
    return H @ P @ H.T + R
    # ----------------------------------------------------------------------------


def gain(P: np.ndarray, H: np.ndarray, S: np.ndarray) -> np.ndarray:
    """Return the Kalman gain: how much of an innovation corrects each state, (n, m).

    Args:
        P: (n, n) covariance of the state
        H: (m, n) Jacobian of the measurement
        S: (m, m) covariance of the innovation

    Reference: Probabilistic Robotics, table 3.3, line 4.
    """
    # TODO 5: the gain (until then: return np.zeros(H.T.shape))
    return P @ H.T @ np.linalg.inv(S)
    # ----------------------------------------------------------------------------


def is_plausible(innovation: np.ndarray, S: np.ndarray, limit: float) -> bool:
    """Return whether a measurement is as close to its expectation as the filter believes.

    Args:
        innovation: (m,) measurement minus expectation
        S: (m, m) covariance of the innovation
        limit: quantile of the chi-square distribution with m degrees of freedom

    Reference: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation,
    section 5.4.
    """
    # TODO 6: the squared Mahalanobis distance is at most the limit (until then: return True)
    return bool(innovation @ np.linalg.solve(S, innovation) <= limit)
    # ----------------------------------------------------------------------------


def corrected_state(state: np.ndarray, K: np.ndarray, innovation: np.ndarray) -> np.ndarray:
    """Return the state after a measurement.

    Args:
        state: (n,) state before it
        K: (n, m) gain
        innovation: (m,) measurement minus expectation

    Reference: Probabilistic Robotics, table 3.3, line 5.
    """
    # TODO 7: the corrected state, with its heading in -pi..pi (until then: return state)
    corrected = state + K @ innovation
    corrected[YAW] = wrap_angle(corrected[YAW])
    return corrected
    # ----------------------------------------------------------------------------


def corrected_covariance(P: np.ndarray, K: np.ndarray, H: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Return the covariance after a measurement.

    The form of Joseph: with any gain the result is symmetric and has no negative variance. The
    short form (I - K H) P has these properties only without rounding.

    Args:
        P: (n, n) covariance before it
        K: (n, m) gain
        H: (m, n) Jacobian of the measurement
        R: (m, m) covariance of the noise of the measurement

    Reference: Bar-Shalom, Li, Kirubarajan, section 5.2.3.
    """
    A = np.eye(len(P)) - K @ H
    # TODO 8: the form of Joseph (until then: return P)
    return A @ P @ A.T + K @ R @ K.T
    # ----------------------------------------------------------------------------
