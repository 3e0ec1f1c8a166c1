"""Estimate how the car moves, and how late its commands act, from noisy poses.

The estimator has the model of the steering method: the dynamic bicycle of Rajamani (section 2.5),
and the commands that were sent. Between two poses the model moves the car, and a Kalman filter
corrects it.
"""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
from scipy.linalg import expm

from sdc_common.geometry.angles import wrap_angle
from sdc_package.steering.axles import Axles
from sdc_package.steering.lqr import error_model

# Entries of the state: position [m], heading [rad], lateral speed [m/s], yaw rate [rad/s], an
# offset of the wheel angle (wind, a worn steering) [rad], speed [m/s] and an offset of the
# acceleration (a slope) [m/s^2].
X, Y, YAW, LATERAL, RATE, WHEEL_OFFSET, SPEED, PULL = range(8)
_MEASURED = [X, Y, YAW, SPEED]
# What the model does not know adds this to each entry of the state in a tick.
_MODEL_ERROR = np.array([0.003, 0.003, 0.0002, 0.03, 0.02, 0.0006, 0.01, 0.02])
_START_ERROR = np.array([0.0, 0.0, 0.0, 0.1, 0.1, 0.001, 0.0, 0.1])
# A slow car that moves this far between two poses was placed there by hand [m].
_PLACED_M = 2.0
# A gap of more ticks between two poses starts the filters again.
_MOST_TICKS = 5

# The model is computed for speeds this far apart, and interpolated between them [m/s].
_STEP_MPS = 0.5
_SPEEDS_MPS = np.arange(1.0, 60.5, _STEP_MPS)
# The delay is the one under which the poses of the last seconds were the least surprising. This is
# the factor a tick by which an older surprise counts less.
_MEMORY = 0.98
# The estimated delay changes where another one has a sum of surprises that is smaller by more;
# smaller differences are chance.
_MARGIN = 6.0
# Share of the last innovation in the estimated noise of the positions.
_LEARNS = 0.02
# Least estimated noise of the positions [m].
_LEAST_NOISE_M = 0.006


class TickModel:
    """What one tick does to cross-track error, heading error, lateral speed and yaw rate.

    Args:
        axles: geometry and tyres of the car
        gyration_m: radius of gyration about the vertical axis [m]
        tick_s: time for which a command holds [s]
    """

    def __init__(self, axles: Axles, gyration_m: float, tick_s: float):
        held = []
        for v in _SPEEDS_MPS.tolist():
            a, b = error_model(v, axles, gyration_m)
            # Rajamani's second state is the rate of the first: v * heading error + lateral speed.
            rates = np.array([[1.0, 0, 0, 0], [0, v, 1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
            rows = np.linalg.solve(rates, np.hstack([a @ rates, b]))
            held.append(expm(tick_s * np.vstack([rows, np.zeros((1, 5))]))[:4])
        self._held = np.array(held)

    def at(self, speed_mps: Any) -> np.ndarray:
        """Return (..., 4, 5): the four after a tick from the four before and the wheel angle."""
        place = (np.asarray(speed_mps) - _SPEEDS_MPS[0]) / _STEP_MPS
        place = np.minimum(np.maximum(place, 0.0), len(_SPEEDS_MPS) - 1.001)
        i = place.astype(int)
        share = (place - i)[..., None, None]
        return self._held[i] + share * (self._held[i + 1] - self._held[i])


class MotionFilter:
    """An extended Kalman filter of the car's motion.

    Args:
        model: how the car moves in a tick
        tick_s: time between two poses [s]
        noises: standard deviations of the odometry: the greatest of a position, those of the
            heading and of the speed [m, rad, m/s]

    Attributes:
        state: the estimate, see X, Y, ... (8,)
        surprise: squared error of the last prediction in standard deviations

    Reference: S. Thrun, W. Burgard and D. Fox, Probabilistic Robotics, table 3.3; the noise of the
    positions from the innovations by R. K. Mehra, IEEE Trans. Automatic Control 15, 1970.
    """

    def __init__(self, model: TickModel, tick_s: float, noises: Sequence[float]):
        self._model, self._tick_s = model, tick_s
        position, heading, speed = noises
        self._noise = np.diag(np.square([position, position, heading, speed]))
        self._position_variance = self._most_variance = position**2
        self._measures = np.eye(8)[_MEASURED]
        self.state: np.ndarray = np.zeros(8)
        self.surprise = 0.0

    def start(self, pose: Sequence[float], speed_mps: float, motion: Sequence[float]) -> None:
        """Start at a pose with this lateral speed and yaw rate."""
        self.state = np.array([*pose, *motion, 0.0, speed_mps, 0.0])
        errors = self._measures.T @ np.diag(self._noise)
        self._covariance = np.diag(errors + _START_ERROR**2)

    def after_tick(self, state: np.ndarray, command: tuple[float, float]) -> Any:
        """Return the state after a tick of wheel angle [rad] and acceleration, and its matrix."""
        t = self._tick_s
        wheel, acceleration = command
        x, y, yaw, lateral, rate, offset, speed, pull = state.tolist()
        m = self._model.at(speed)[:, 2:]
        left, turned, lateral, rate = (m @ (lateral, rate, wheel + offset)).tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        later = max(0.0, speed + (acceleration + pull) * t)
        ahead = 0.5 * (speed + later) * t
        x, y = x + c * ahead - s * left, y + s * ahead + c * left
        f = np.eye(8)
        f[X, YAW], f[Y, YAW] = -s * ahead - c * left, c * ahead - s * left
        f[X, SPEED], f[Y, SPEED], f[SPEED, PULL] = c * t, s * t, t
        f[[X, Y], LATERAL:SPEED] = np.outer((-s, c), m[0])
        f[YAW : SPEED - 1, LATERAL:SPEED] = m[1:]
        return np.array([x, y, yaw + turned, lateral, rate, offset, later, pull]), f

    def update(
        self, command: tuple[float, float], pose: Sequence[float], speed_mps: float
    ) -> np.ndarray:
        """Move by a tick under a command, and correct by a pose; return the pose's innovation."""
        state, f = self.after_tick(self.state, command)
        p = f @ self._covariance @ f.T + np.diag(_MODEL_ERROR**2)
        x, y, yaw = pose
        expected_mps = math.hypot(state[SPEED], state[LATERAL])
        innovation = np.array(
            [x - state[X], y - state[Y], wrap_angle(yaw - state[YAW]), speed_mps - expected_mps]
        )
        # How much the positions scatter beyond the model's own error is their noise.
        scatter = 0.5 * (innovation[:2] @ innovation[:2] - p[X, X] - p[Y, Y])
        self._position_variance += _LEARNS * (scatter - self._position_variance)
        least, most = _LEAST_NOISE_M**2, self._most_variance
        self._noise[[0, 1], [0, 1]] = min(max(self._position_variance, least), most)
        innovation_covariance = p[np.ix_(_MEASURED, _MEASURED)] + self._noise
        gain = np.linalg.solve(innovation_covariance, p[_MEASURED]).T
        self.state = state + gain @ innovation
        # Joseph's form: the shorter one loses its symmetry within minutes.
        kept = np.eye(8) - gain @ self._measures
        self._covariance = kept @ p @ kept.T + gain @ self._noise @ gain.T
        self.surprise = float(innovation[2] ** 2 / innovation_covariance[2, 2])
        return innovation


class MotionEstimator:
    """One filter for each delay, in whole ticks: the one that predicts best knows the delay.

    It does not matter whether the commands are late or the poses.

    Args:
        model: how the car moves in a tick
        tick_s: time between two poses [s]
        noises: standard deviations of the odometry, see MotionFilter
        delay_s: the delay that is assumed at the start [s]
        longest_delay_s: the longest delay that is tried [s]

    Attributes:
        delay: the delay [ticks]
    """

    def __init__(
        self,
        model: TickModel,
        tick_s: float,
        noises: Sequence[float],
        delay_s: float,
        longest_delay_s: float,
    ):
        self._tick_s = tick_s
        self.delay = round(delay_s / tick_s)
        count = max(self.delay, round(longest_delay_s / tick_s)) + 1
        self._filters = [MotionFilter(model, tick_s, noises) for _ in range(count)]
        self._surprises = np.zeros(count)
        self._sent: list[tuple[float, float]] = []
        self._last_xy: tuple[float, float] | None = None

    @property
    def last_sent(self) -> tuple[float, float]:
        """Return the last command: wheel angle [rad] and acceleration [m/s^2]."""
        return self._sent[-1]

    def sent(self, wheel_rad: float, acceleration_mps2: float) -> None:
        """Add the command that answers the last pose."""
        self._sent = [*self._sent[1:], (wheel_rad, acceleration_mps2)]

    def update(
        self, pose: Sequence[float], speed_mps: float, wheel_rad: float, motion: Sequence[float]
    ) -> None:
        """Add a pose.

        Args:
            pose: x, y, yaw [m, m, rad]
            speed_mps: speed
            wheel_rad: wheel angle of a car in a steady bend with the measured yaw rate, used at the
                start alone [rad]
            motion: lateral speed and yaw rate of that car [m/s, rad/s]
        """
        moved_m = 0.0 if self._last_xy is None else math.dist(pose[:2], self._last_xy)
        ticks = round(moved_m / max(speed_mps * self._tick_s, _PLACED_M / _MOST_TICKS))
        if self._last_xy is None or ticks > _MOST_TICKS:
            self._sent = [(wheel_rad, 0.0)] * len(self._filters)
            self._surprises[:] = 0.0
            for motion_filter in self._filters:
                motion_filter.start(pose, speed_mps, motion)
        else:
            for delay, motion_filter in enumerate(self._filters):
                command = self._sent[-1 - delay]
                for _ in range(ticks - 1):  # the poses of these ticks were lost
                    motion_filter.state, _ = motion_filter.after_tick(motion_filter.state, command)
                motion_filter.update(command, pose, speed_mps)
            surprises = [motion_filter.surprise for motion_filter in self._filters]
            self._surprises = _MEMORY * self._surprises + surprises
            best = int(np.argmin(self._surprises))
            if self._surprises[best] < self._surprises[self.delay] - _MARGIN:
                self.delay = best
        self._last_xy = pose[0], pose[1]

    def when_command_acts(self) -> np.ndarray:
        """Return the state at the time at which the next command acts."""
        chosen = self._filters[self.delay]
        state = chosen.state
        for command in self._sent[len(self._sent) - self.delay :]:
            state, _ = chosen.after_tick(state, command)
        return state
