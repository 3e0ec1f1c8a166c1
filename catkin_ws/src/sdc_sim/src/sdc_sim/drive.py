"""Measures a drive: progress along the route, errors, accelerations, and how it ended."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_package.route import Place, Route, wrap_angle

COMPLETED, OFF_ROUTE, BLOCKED, TIMEOUT, ABORTED = "completed", "off_route", "blocked", "timeout", "aborted"

# A car moves less than this between two samples; it may be pushed or towed back a little.
_WINDOW_BACK_M = 5.0
_WINDOW_AHEAD_M = 15.0
_STANDSTILL_MPS = 0.05
# Accelerations are slopes over this time, as nuPlan's comfort metrics smooth them (Savitzky-Golay, second order).
_SMOOTHING_S = 0.4


@dataclass(frozen=True)
class DriveLimits:
    """When a drive is over: metres, seconds of simulated time."""

    off_route_m: float
    blocked_s: float
    finish_within_m: float
    timeout_s: float

    def __post_init__(self):
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"{name} must be positive, got {value}")


@dataclass(frozen=True)
class Sample:
    """One odometry, placed on the route: seconds, metres, radians, m/s; errors positive to the left."""

    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    s_m: float
    cross_track_m: float
    heading_error_rad: float


class Drive:
    """Follows one drive along one route, from its first odometry to its end.

    The place on the route is searched near the drive's own progress only, so that a route which passes close to itself is
    measured against the pass that is being driven.
    """

    def __init__(self, route: Route, limits: DriveLimits):
        self.route = route
        self.limits = limits
        self.samples = []
        self.status = None
        self.progress_m = 0.0
        self._progress_at_s = 0.0

    @property
    def completion_percent(self) -> float:
        """Share of the route that lies behind the car; all of it once the drive is completed."""
        return 100.0 if self.status == COMPLETED else 100.0 * self.progress_m / self.route.length_m

    def update(self, time_s: float, x_m: float, y_m: float, yaw_rad: float, speed_mps: float) -> Sample:
        """Take one odometry; sets `status` when it ends the drive. Raises ValueError when time does not move on."""
        if self.samples and time_s <= self.samples[-1].time_s:
            raise ValueError(f"time went from {self.samples[-1].time_s:.3f} s to {time_s:.3f} s")
        place = self._place(x_m, y_m, yaw_rad)
        sample = Sample(time_s, x_m, y_m, yaw_rad, speed_mps, place.s_m, place.cross_track_m,
                        wrap_angle(yaw_rad - place.heading_rad))
        if not self.samples:
            self._progress_at_s = time_s
        self.samples.append(sample)
        if place.s_m > self.progress_m + 0.1:
            self._progress_at_s = time_s
        self.progress_m = max(self.progress_m, place.s_m)
        self.status = self._judge(sample, place)
        return sample

    def _place(self, x_m: float, y_m: float, yaw_rad: float) -> Place:
        if not self.samples:
            return self.route.locate(x_m, y_m, yaw_rad)
        return self.route.project(x_m, y_m, self.samples[-1].s_m, _WINDOW_BACK_M, _WINDOW_AHEAD_M)

    def _judge(self, sample: Sample, place: Place):
        at_rest = sample.speed_mps < _STANDSTILL_MPS
        left_m = self.route.length_m - place.s_m
        if at_rest and left_m < self.limits.finish_within_m and place.distance_m < self.limits.finish_within_m:
            return COMPLETED
        if place.distance_m > self.limits.off_route_m:
            return OFF_ROUTE
        if sample.time_s - self._progress_at_s > self.limits.blocked_s:
            return BLOCKED
        if sample.time_s - self.samples[0].time_s > self.limits.timeout_s:
            return TIMEOUT
        return None

    def column(self, name: str) -> np.ndarray:
        """All values of one field of Sample, in the order of time: (n,)."""
        return np.array([getattr(sample, name) for sample in self.samples])

    def figures(self, ideal_duration_s: float) -> dict:
        """The report's figures, units in their names; None where a drive is too short to tell."""
        duration = self.samples[-1].time_s - self.samples[0].time_s if self.samples else 0.0
        figures = {
            "status": self.status or ABORTED,
            "route_length_m": self.route.length_m,
            "route_completion_percent": self.completion_percent,
            "duration_s": duration,
            "ideal_duration_s": ideal_duration_s,
            "time_ratio": duration / ideal_duration_s,
        }
        if self.samples:
            error = np.abs(self.column("cross_track_m"))
            speed = self.column("speed_mps")
            figures.update({
                "cross_track_rms_m": root_mean_square(error),
                "cross_track_p95_m": float(np.percentile(error, 95.0)),
                "cross_track_max_m": float(error.max()),
                "heading_rms_rad": root_mean_square(self.column("heading_error_rad")),
                "speed_mean_mps": float(speed.mean()),
                "speed_max_mps": float(speed.max()),
            })
        figures.update(self._accelerations())
        return figures

    def _accelerations(self) -> dict:
        names = ("lateral_acceleration_max_mps2", "longitudinal_acceleration_max_mps2",
                 "longitudinal_acceleration_min_mps2", "jerk_max_mps3")
        time_s = self.column("time_s")
        window = int(round(_SMOOTHING_S / np.median(np.diff(time_s)))) | 1 if len(time_s) > 1 else 0
        if len(time_s) < max(window, 5) or window < 5:
            return dict.fromkeys(names)
        from scipy.signal import savgol_filter  # slow to load, and needed once, at the end of a drive
        step_s = float(np.median(np.diff(time_s)))
        speed = self.column("speed_mps")
        yaw = np.unwrap(self.column("yaw_rad"))
        longitudinal = savgol_filter(speed, window, 2, deriv=1, delta=step_s)
        lateral = speed * savgol_filter(yaw, window, 2, deriv=1, delta=step_s)
        jerk = np.hypot(*(savgol_filter(values, window, 2, deriv=1, delta=step_s) for values in (longitudinal, lateral)))
        return dict(zip(names, (float(np.abs(lateral).max()), float(longitudinal.max()), float(longitudinal.min()),
                                float(jerk.max()))))


def root_mean_square(values: np.ndarray) -> float:
    """Root of the mean of the squares of (n,) values, n >= 1."""
    return math.sqrt(float(np.mean(np.square(values))))
