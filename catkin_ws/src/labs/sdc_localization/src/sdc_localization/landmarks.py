"""Landmarks of a known map correct the state where there is no GNSS.

Reference: Thrun, Burgard, Fox, Probabilistic Robotics, section 7.4 and table 7.2.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.geometry.angles import wrap_angle
from sdc_localization import kalman_filter as kalman
from sdc_localization.localizer import Localizer
from sdc_localization.motion_model import SIZE, YAW, X, Y

# The map is searched so far around a detection; the gate is much narrower.
_SEARCH_M = 4.0


def expected_measurement(state: np.ndarray, x_m: float, y_m: float) -> np.ndarray:
    """Return range [m] and bearing [rad] of a landmark, as the car should measure them.

    Args:
        state: (5,) see motion_model
        x_m: position of the landmark in the map
        y_m: position of the landmark in the map

    Returns:
        range, and bearing from straight ahead to the left, in -pi..pi
    """
    dx, dy = x_m - state[X], y_m - state[Y]
    # TODO 11: the distance, and the direction as seen from the car (until then: return np.zeros(2))
    return np.array([math.hypot(dx, dy), wrap_angle(math.atan2(dy, dx) - state[YAW])])
    # ----------------------------------------------------------------------------


def measurement_jacobian(state: np.ndarray, x_m: float, y_m: float) -> np.ndarray:
    """Return the derivatives of range and bearing by the state (2, 5).

    The arguments are those of `expected_measurement`.
    """
    dx, dy = x_m - state[X], y_m - state[Y]
    square = dx * dx + dy * dy
    root = math.sqrt(square)
    jacobian = np.zeros((2, SIZE))
    # TODO 12: the derivatives by x, y and heading (until then: pass)
    jacobian[0, X], jacobian[0, Y] = -dx / root, -dy / root
    jacobian[1, X], jacobian[1, Y], jacobian[1, YAW] = dy / square, -dx / square, -1.0
    # ----------------------------------------------------------------------------
    return jacobian


class LandmarkMap:
    """Positions of landmarks, and the correction of a localizer by detected ones.

    Args:
        positions_m: (N, 2) positions in the map frame
        range_m: standard deviation of a measured range
        bearing_rad: standard deviation of a measured bearing
        gate_2: limit of the squared Mahalanobis distance with 2 degrees of freedom
    """

    def __init__(self, positions_m: np.ndarray, range_m: float, bearing_rad: float, gate_2: float):
        self._positions_m = np.asarray(positions_m, float)
        self._tree = cKDTree(self._positions_m)
        self._noise = np.diag(np.square([range_m, bearing_rad]))
        self._gate_2 = gate_2

    def correct(self, localizer: Localizer, detections_m: np.ndarray) -> int:
        """Correct a localizer by detections; return how many were landmarks of the map.

        Args:
            localizer: the localizer, which has started
            detections_m: (M, 2) positions relative to the car, forward and left
        """
        used = 0
        for ahead, left in detections_m.tolist():
            measured = np.array([math.hypot(ahead, left), math.atan2(left, ahead)])
            used += self._correct(localizer, measured)
        return used

    def _correct(self, localizer: Localizer, measured: np.ndarray) -> bool:
        """Correct by one measurement, whose landmark is the most plausible one."""
        state = localizer.state
        direction = state[YAW] + measured[1]
        place = (
            state[X] + measured[0] * math.cos(direction),
            state[Y] + measured[0] * math.sin(direction),
        )
        best = (self._gate_2, None, None)
        for index in self._tree.query_ball_point(place, _SEARCH_M):
            landmark = self._positions_m[index].tolist()
            innovation = measured - expected_measurement(state, *landmark)
            innovation[1] = wrap_angle(innovation[1])
            H = measurement_jacobian(state, *landmark)
            S = kalman.innovation_covariance(localizer.covariance, H, self._noise)
            distance = float(innovation @ np.linalg.solve(S, innovation))
            if distance <= best[0]:
                best = (distance, innovation, H)
        _, innovation, H = best
        if innovation is None:
            return False
        return localizer.correct(innovation, H, self._noise, self._gate_2)
