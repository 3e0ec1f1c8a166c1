"""The localizer: an extended Kalman filter of wheel speeds, gyroscope, GNSS and landmarks."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Callable, NamedTuple, Sequence

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.validation import check_non_negative, check_positive
from sdc_localization import kalman_filter as kalman
from sdc_localization.motion_model import (
    BIAS,
    SCALE,
    SIZE,
    YAW,
    X,
    Y,
    motion_jacobian,
    moved,
    sideways_speed,
)

_POSITION = np.eye(2, SIZE)
# A longer gap between two steps is no motion but a restart of the sensors.
_LONGEST_STEP_S = 1.0


@dataclass(frozen=True)
class LocalizerSettings:
    """Parameters of the localizer; every field is a key of config/localizer.yaml.

    Raises:
        ValueError: a value is not a number or out of range
    """

    rear_axle_m: float
    rear_slip_s2pm: float
    initial_across_m: float
    initial_yaw_rad: float
    initial_bias_radps: float
    initial_scale: float
    along_m_per_sqrt_m: float
    across_m_per_sqrt_m: float
    yaw_rad_per_sqrt_s: float
    yaw_rad_per_sqrt_rad: float
    bias_radps_per_sqrt_s: float
    scale_per_sqrt_s: float
    gate_2: float
    reset_after_s: float

    def __post_init__(self) -> None:
        may_be_zero = {"rear_axle_m", "rear_slip_s2pm"}
        values = dataclasses.asdict(self)
        check_non_negative(**{name: values.pop(name) for name in sorted(may_be_zero)})
        check_positive(**values)

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> LocalizerSettings:
        """Read all fields with a function that returns the value of a parameter."""
        return cls(**{field.name: parameter(field.name) for field in dataclasses.fields(cls)})


class Estimate(NamedTuple):
    """Where the localizer believes that the car is, and how sure it is."""

    x_m: float  # position in the map frame [m]
    y_m: float  # position in the map frame [m]
    yaw_rad: float  # heading, counter-clockwise from the x axis [rad]
    speed_mps: float  # speed along the car [m/s]
    sideways_mps: float  # speed of the car's centre to its left [m/s]
    yaw_rate_radps: float  # yaw rate [rad/s]
    covariance: np.ndarray  # (3, 3) covariance of x, y and yaw


def initial_heading(waypoint_m: Sequence[float], next_waypoint_m: Sequence[float]) -> float:
    """Return the direction of a lane between two waypoints, (x, y) each [rad].

    A GNSS receiver at rest does not measure a heading, but a car that starts in its lane points
    along it.
    """
    # TODO 9: the direction from the waypoint to the next one (until then: return 0.0)
    return math.atan2(next_waypoint_m[1] - waypoint_m[1], next_waypoint_m[0] - waypoint_m[0])
    # ----------------------------------------------------------------------------


def along_and_across(yaw_rad: float, along_m2: float, across_m2: float) -> np.ndarray:
    """Return the covariance of x and y of a car with these variances along it and to its side."""
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = np.array([[cos, -sin], [sin, cos]])
    return turn @ np.diag([along_m2, across_m2]) @ turn.T


class Localizer:
    """Estimates the pose of the car from one step to the next.

    Attributes:
        state: (5,) see motion_model; None before `start`
        covariance: (5, 5) covariance of the state
    """

    def __init__(self, settings: LocalizerSettings):
        self.settings = settings
        self.state: np.ndarray = None  # type: ignore[assignment]
        self.covariance = np.zeros((SIZE, SIZE))
        self._refused_since_s: float | None = None
        self._motion: tuple[float, float, float] | None = None

    @property
    def started(self) -> bool:
        """Whether there is an estimate."""
        return self.state is not None

    def start(self, x_m: float, y_m: float, variance_m2: float, waypoints_m: np.ndarray) -> None:
        """Begin in the lane of the mission, at the place nearest to a GNSS position.

        Args:
            x_m: measured position in the map frame
            y_m: measured position in the map frame
            variance_m2: variance of each axis [m^2]
            waypoints_m: (N, 2) waypoints of the mission, N > 1
        """
        s = self.settings
        points = waypoints_m.tolist()
        place = Polyline(points).nearest(x_m, y_m)
        yaw = initial_heading(points[place.segment], points[place.segment + 1])
        x = x_m + place.cross_track_m * math.sin(yaw)
        y = y_m - place.cross_track_m * math.cos(yaw)
        self.state = np.array([x, y, yaw, 0.0, 0.0])
        deviations = (s.initial_yaw_rad, s.initial_bias_radps, s.initial_scale)
        self.covariance = np.diag([0.0, 0.0, *np.square(deviations)])
        self.covariance[:2, :2] = along_and_across(yaw, variance_m2, s.initial_across_m**2)
        self._refused_since_s = None

    def move(self, time_s: float, wheel_mps: float, gyro_radps: float) -> None:
        """Predict the state at a time, from the measured wheel speed and yaw rate.

        The motion since the last call is the mean of both measurements.
        """
        last, self._motion = self._motion, (time_s, wheel_mps, gyro_radps)
        if last is None or self.state is None:
            return
        step_s = time_s - last[0]
        if not 0.0 < step_s <= _LONGEST_STEP_S:
            return
        wheel, gyro = 0.5 * (last[1] + wheel_mps), 0.5 * (last[2] + gyro_radps)
        sideways = self._sideways(wheel, gyro)
        F = motion_jacobian(self.state, wheel, sideways, gyro, step_s)
        Q = self._motion_noise(wheel, gyro, step_s)
        self.covariance = kalman.predicted_covariance(self.covariance, F, Q)
        self.state = moved(self.state, wheel, sideways, gyro, step_s)

    def add_position(self, x_m: float, y_m: float, variance_m2: float) -> bool:
        """Correct the state by a GNSS position, unless it is an outlier.

        Returns:
            whether the position was used
        """
        used = self.correct(
            np.array([x_m - self.state[X], y_m - self.state[Y]]),
            _POSITION,
            np.diag([variance_m2, variance_m2]),
            self.settings.gate_2,
        )
        if used:
            self._refused_since_s = None
        elif self._refused_since_s is None:
            self._refused_since_s = self._time_s
        return used

    def correct(self, innovation: np.ndarray, H: np.ndarray, R: np.ndarray, limit: float) -> bool:
        """Correct the state by a measurement; return whether it was plausible and used.

        Args:
            innovation: (m,) measurement minus expectation
            H: (m, 5) Jacobian of the measurement
            R: (m, m) covariance of its noise
            limit: quantile of the chi-square distribution with m degrees of freedom
        """
        S = kalman.innovation_covariance(self.covariance, H, R)
        if not kalman.is_plausible(innovation, S, limit):
            return False
        K = kalman.gain(self.covariance, H, S)
        self.state = kalman.corrected_state(self.state, K, innovation)
        self.covariance = kalman.corrected_covariance(self.covariance, K, H, R)
        return True

    @property
    def lost(self) -> bool:
        """Whether GNSS has contradicted the estimate for so long that the estimate is wrong."""
        since_s = self._refused_since_s
        return since_s is not None and self._time_s - since_s > self.settings.reset_after_s

    @property
    def estimate(self) -> Estimate:
        """The present estimate; call it after `start` and `move`."""
        assert self._motion is not None
        _, wheel, gyro = self._motion
        x, y, yaw, bias, scale = self.state.tolist()
        return Estimate(
            x,
            y,
            yaw,
            (1.0 + scale) * wheel,
            self._sideways(wheel, gyro),
            gyro - bias,
            self.covariance[: YAW + 1, : YAW + 1],
        )

    @property
    def _time_s(self) -> float:
        return self._motion[0] if self._motion is not None else 0.0

    def _sideways(self, wheel_mps: float, gyro_radps: float) -> float:
        return sideways_speed(
            (1.0 + self.state[SCALE]) * wheel_mps,
            gyro_radps - self.state[BIAS],
            self.settings.rear_axle_m,
            self.settings.rear_slip_s2pm,
        )

    def _motion_noise(self, wheel_mps: float, gyro_radps: float, step_s: float) -> np.ndarray:
        """Return Q: it grows with the distance, with the angle of the turn, and with time."""
        s = self.settings
        distance = abs(wheel_mps) * step_s
        along, across = s.along_m_per_sqrt_m**2 * distance, s.across_m_per_sqrt_m**2 * distance
        Q = np.zeros((SIZE, SIZE))
        Q[:2, :2] = along_and_across(self.state[YAW], along, across)
        turn_rad = abs(gyro_radps) * step_s
        Q[YAW, YAW] = s.yaw_rad_per_sqrt_s**2 * step_s + s.yaw_rad_per_sqrt_rad**2 * turn_rad
        Q[BIAS, BIAS] = s.bias_radps_per_sqrt_s**2 * step_s
        Q[SCALE, SCALE] = s.scale_per_sqrt_s**2 * step_s
        return Q
