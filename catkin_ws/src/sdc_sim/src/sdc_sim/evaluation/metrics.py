"""Metrics of a drive: errors, accelerations, comfort and the driving score."""

from __future__ import annotations

import math
from typing import Collection

import numpy as np

from sdc_sim.yaml_document import packaged_config

_SCORING = packaged_config("scoring")
# Coefficients of the infractions of CARLA leaderboard 2.1, by their names in the report.
WITHOUT_STREETS: dict[str, float] = _SCORING["infractions"]
COEFFICIENTS: dict[str, float] = {**WITHOUT_STREETS, **_SCORING["infractions_on_a_map"]}

# The limits of nuPlan's comfort metrics, and its filter (Savitzky-Golay, second order): samples so
# far apart [s], and so many of them for yaw rate, acceleration, and jerk or yaw acceleration; it
# has 8 for the acceleration, which has no middle (nuplan-devkit, metrics/utils/state_extractors).
_COMFORT: dict[str, list[float]] = _SCORING["comfort"]
_SAMPLE_S, _OF_RATE, _OF_ACCELERATION, _OF_JERK = 0.1, 5, 7, 15
# The accelerations of the report are slopes over this time and at least this many samples.
_SMOOTHING_S = 0.4
_MIN_SAMPLES = 5
# No slope is computed across a longer gap between two samples.
_MAX_GAP_S = 1.0


def drive_metrics(
    columns: dict,
    completion_percent: float,
    infractions: dict,
    lane_width_m: float,
    on_lane_s: Collection[float] = (),
) -> dict:
    """Return the metrics of the report that follow from the samples of a drive.

    Args:
        columns: the fields of DriveSample, (n,) each
        completion_percent: completed share of the route [%]
        infractions: counts by the keys of COEFFICIENTS
        lane_width_m: width of the lane around the route [m]
        on_lane_s: times at which the car is on another lane that it may use [s]
    """
    time_s, speed, error = columns["time_s"], columns["speed_mps"], columns["cross_track_m"]
    metrics: dict = {}
    if len(time_s):
        size = np.abs(error)
        metrics.update(
            cross_track_rms_m=root_mean_square(size),
            cross_track_p95_m=float(np.percentile(size, 95.0)),
            cross_track_max_m=float(size.max()),
            heading_rms_rad=root_mean_square(columns["heading_error_rad"]),
            speed_mean_mps=float(speed.mean()),
            speed_max_mps=float(speed.max()),
        )
    metrics.update(peak_accelerations(time_s, speed, columns["yaw_rad"]))
    breaks = comfort_breaks(time_s, speed, columns["yaw_rad"])
    beside = np.where(np.isin(time_s, list(on_lane_s)), 0.0, error)
    off_lane = off_lane_percent(time_s, speed, beside, lane_width_m)
    metrics.update(
        off_lane_percent=off_lane,
        infractions=dict(infractions),
        driving_score=driving_score(completion_percent, off_lane, infractions),
        comfortable=None if breaks is None else not breaks,
    )
    return metrics


def root_mean_square(values: np.ndarray) -> float:
    """Return the root of the mean square of (n,) values, n >= 1."""
    return math.sqrt(float(np.mean(np.square(values))))


def off_lane_percent(
    time_s: np.ndarray, speed_mps: np.ndarray, cross_track_m: np.ndarray, lane_width_m: float
) -> float:
    """Return the share of the driven distance with the car's centre off the lane [%].

    There is a sample for each time (n,); the middle of the lane is the route.
    """
    if len(time_s) < 2:
        return 0.0
    # The distance comes from the speed: noise in the positions would add to it.
    steps_m = 0.5 * (speed_mps[:-1] + speed_mps[1:]) * np.diff(time_s)
    off = np.abs(cross_track_m[1:]) > 0.5 * lane_width_m
    return 100.0 * float(steps_m[off].sum()) / max(float(steps_m.sum()), 1e-9)


def driving_score(completion_percent: float, off_lane: float, infractions: dict) -> float:
    """Return the driving score of CARLA leaderboard 2.1, 0 to 100.

    Infractions are counts by the keys of COEFFICIENTS, and `off_lane` a share of the distance [%].
    """
    penalty = sum(COEFFICIENTS[name] * count for name, count in infractions.items())
    return completion_percent * (1.0 - off_lane / 100.0) / (1.0 + penalty)


def comfort_breaks(
    time_s: np.ndarray, speed_mps: np.ndarray, yaw_rad: np.ndarray
) -> list[str] | None:
    """Return the comfort limits of nuPlan that the samples (n,) break; None if they are few."""

    def slope(values: np.ndarray, window: int) -> np.ndarray:
        return smoothed_slope(values, window) / _SAMPLE_S

    broken: set[str] | None = None
    for part in _parts(time_s):
        even_s = np.arange(time_s[part[0]], time_s[part[-1]] + 1e-6, _SAMPLE_S)
        if len(even_s) < _OF_JERK:
            continue
        speed = np.interp(even_s, time_s[part], speed_mps[part])
        yaw = np.interp(even_s, time_s[part], np.unwrap(yaw_rad[part]))
        along, rate = slope(speed, _OF_ACCELERATION), slope(yaw, _OF_RATE)
        across = speed * slope(yaw, _OF_ACCELERATION)
        jerks = (slope(signal, _OF_JERK) for signal in (along, np.hypot(along, across), rate))
        values = zip(_COMFORT.items(), (along, across, rate, *jerks))
        beyond = {
            name for (name, (low, high)), data in values if data.min() < low or data.max() > high
        }
        broken = beyond | (broken or set())
    return None if broken is None else sorted(broken)


def peak_accelerations(time_s: np.ndarray, speed_mps: np.ndarray, yaw_rad: np.ndarray) -> dict:
    """Return the extreme accelerations and the greatest jerk of samples (n,); None if too few."""
    names = (
        "lateral_acceleration_max_mps2",
        "longitudinal_acceleration_max_mps2",
        "longitudinal_acceleration_min_mps2",
        "jerk_max_mps3",
    )
    parts = [part[1:] for part in accelerations(time_s, speed_mps, yaw_rad)]
    if not parts:
        return dict.fromkeys(names)
    longitudinal, lateral, jerk = (np.concatenate(part) for part in zip(*parts))
    peaks = np.abs(lateral).max(), longitudinal.max(), longitudinal.min(), jerk.max()
    return dict(zip(names, map(float, peaks)))


def accelerations(time_s: np.ndarray, speed_mps: np.ndarray, yaw_rad: np.ndarray) -> list:
    """Return the accelerations of each part of a drive between two gaps.

    The lateral acceleration is speed times yaw rate, which follows from the odometry alone.

    Returns:
        for each part: time [s], longitudinal and lateral acceleration [m/s^2] and magnitude of
        the jerk [m/s^3], (m,) each
    """
    parts = []
    for part in _parts(time_s):
        if len(part) >= _MIN_SAMPLES:
            parts += _slopes(time_s[part], speed_mps[part], np.unwrap(yaw_rad[part]))
    return parts


def _parts(time_s: np.ndarray) -> list[np.ndarray]:
    """Return the indices of the samples between two gaps."""
    return np.split(np.arange(len(time_s)), np.flatnonzero(np.diff(time_s) > _MAX_GAP_S) + 1)


def _slopes(time_s: np.ndarray, speed_mps: np.ndarray, yaw_rad: np.ndarray) -> list:
    step_s = float(np.median(np.diff(time_s)))
    if np.ptp(np.diff(time_s)) > 0.01 * step_s:
        even_s = np.arange(time_s[0], time_s[-1] + 0.5 * step_s, step_s)
        speed_mps, yaw_rad, time_s = (
            np.interp(even_s, time_s, speed_mps),
            np.interp(even_s, time_s, yaw_rad),
            even_s,
        )
    window = max(_MIN_SAMPLES, int(round(_SMOOTHING_S / step_s)) | 1)
    if len(time_s) < window:
        return []

    def slope(values: np.ndarray) -> np.ndarray:
        return smoothed_slope(values, window) / step_s

    longitudinal, lateral = slope(speed_mps), speed_mps * slope(yaw_rad)
    return [(time_s, longitudinal, lateral, np.hypot(slope(longitudinal), slope(lateral)))]


def smoothed_slope(values: np.ndarray, window: int) -> np.ndarray:
    """Return the slope per sample of the parabola that fits best around each sample.

    This is `scipy.signal.savgol_filter(values, window, 2, deriv=1)`, whose import takes longer than
    the rest of a report.

    Args:
        values: (n,) evenly spaced values, n >= window
        window: number of samples of each parabola, odd
    """
    half = window // 2
    offsets = np.arange(-half, half + 1.0)
    slopes = np.correlate(values, offsets / np.sum(offsets**2), "valid")

    def of_one_parabola(part: np.ndarray) -> np.ndarray:
        return np.polyval(np.polyder(np.polyfit(offsets, part, 2)), offsets)

    first = of_one_parabola(values[:window])[:half]
    last = of_one_parabola(values[-window:])[half + 1 :]
    return np.concatenate([first, slopes, last])
