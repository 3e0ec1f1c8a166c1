"""Correct a prediction with measurements, of which some are wrong.

The parameters of the prediction have a covariance P. Each measurement has a residual, the measured
minus the predicted value, and a row of the Jacobian J: how the parameters change the prediction.
"""

from __future__ import annotations

import numpy as np


def robust_weights(residuals: np.ndarray, deviations: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """Return the weights (M,) of measurements: less for those that are far from the prediction.

    Args:
        residuals: measured minus predicted values (M,)
        deviations: standard deviations (M,) of the measurements
        scales: residuals (M,) at which half of the weight remains

    Reference: P. J. Huber, Robust Statistics, 1981, section 7.8: iterated weights. These are
    Cauchy's.
    """
    # TODO 8: 1 / variance, and less with the residual (until then: return 1.0 / deviations**2)
    return 1.0 / np.square(deviations) / (1.0 + np.square(residuals / scales))
    # ----------------------------------------------------------------------------


def correction(
    P_inverse: np.ndarray, J: np.ndarray, w: np.ndarray, r: np.ndarray, moved: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of the parameters (S,), and their covariance (S, S) after it.

    This is the update of a Kalman filter in its information form: the inverses of covariances are
    weights, and weights add.

    Args:
        P_inverse: inverse (S, S) of the covariance of the prediction
        J: Jacobian (M, S)
        w: weights (M,) of the measurements
        r: residuals (M,)
        moved: how far (S,) earlier corrections have moved the parameters from the prediction

    Reference: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation,
    section 7.2.
    """
    # TODO 9: weigh both (until then: return 0.0 * moved, np.linalg.inv(P_inverse))
    weighted = (J * w[:, None]).T
    covariance = np.linalg.inv(P_inverse + weighted @ J)
    return covariance @ (weighted @ r - P_inverse @ moved), covariance
    # ----------------------------------------------------------------------------
