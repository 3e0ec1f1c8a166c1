"""What the figures of a drive are: errors, accelerations, comfort, and the driving score."""

from __future__ import annotations

import math

import numpy as np

# CARLA leaderboard 2.1 (https://leaderboard.carla.org/#evaluation-and-metrics): what each infraction counts.
COEFFICIENTS = {
    "collision_pedestrian": 1.0,
    "collision_vehicle": 0.7,
    "collision_static": 0.6,
    "red_light": 0.4,
    "stop": 0.25,
}

# Accelerations are slopes over this time and at least so many samples, as nuPlan's comfort metrics smooth them (Savitzky-Golay,
# second order).
_SMOOTHING_S = 0.4
_FEWEST = 5
# Over a longer silence nothing is known: no slope is taken across it.
_SILENCE_S = 1.0

# nuPlan (H. Caesar et al., NuPlan: A closed-loop ML-based planning benchmark, 2021): what a passenger finds comfortable.
_COMFORT = {
    "longitudinal_acceleration_max_mps2": (-math.inf, 2.40),
    "longitudinal_acceleration_min_mps2": (-4.05, math.inf),
    "lateral_acceleration_max_mps2": (0.0, 4.89),
    "jerk_max_mps3": (0.0, 8.37),
}


def measure(
    columns: dict, completion_percent: float, infractions: dict, lane_width_m: float
) -> dict:
    """The report's figures that come from the samples of a drive: `columns` are the fields of Sample, (n,) each."""
    figures = {}
    if len(columns["time_s"]):
        error, speed = np.abs(columns["cross_track_m"]), columns["speed_mps"]
        figures.update(
            {
                "cross_track_rms_m": root_mean_square(error),
                "cross_track_p95_m": float(np.percentile(error, 95.0)),
                "cross_track_max_m": float(error.max()),
                "heading_rms_rad": root_mean_square(columns["heading_error_rad"]),
                "speed_mean_mps": float(speed.mean()),
                "speed_max_mps": float(speed.max()),
            }
        )
    figures.update(
        greatest_accelerations(columns["time_s"], columns["speed_mps"], columns["yaw_rad"])
    )
    off_lane = off_lane_percent(
        columns["time_s"], columns["speed_mps"], columns["cross_track_m"], lane_width_m
    )
    figures.update(
        {
            "off_lane_percent": off_lane,
            "infractions": dict(infractions),
            "driving_score": driving_score(completion_percent, off_lane, infractions),
            "comfortable": comfortable(figures),
        }
    )
    return figures


def root_mean_square(values: np.ndarray) -> float:
    """Root of the mean of the squares of (n,) values, n >= 1."""
    return math.sqrt(float(np.mean(np.square(values))))


def off_lane_percent(time_s, speed_mps, cross_track_m, lane_width_m: float) -> float:
    """Share of the driven distance on which the car's centre was farther than half the lane's width from the route."""
    if len(time_s) < 2:
        return 0.0
    # From the speed, as places that tremble or jump would count as driven metres.
    steps_m = 0.5 * (speed_mps[:-1] + speed_mps[1:]) * np.diff(time_s)
    off = np.abs(cross_track_m[1:]) > 0.5 * lane_width_m
    return 100.0 * float(steps_m[off].sum()) / max(float(steps_m.sum()), 1e-9)


def driving_score(completion_percent: float, off_lane: float, infractions: dict) -> float:
    """CARLA leaderboard 2.1, 0..100: completion x (1 - off lane) / (1 + sum of the infractions' coefficients)."""
    penalty = sum(COEFFICIENTS[name] * count for name, count in infractions.items())
    return completion_percent * (1.0 - off_lane / 100.0) / (1.0 + penalty)


def comfortable(figures: dict):
    """Whether all accelerations and the jerk stayed within nuPlan's thresholds; None where they are not known."""
    if any(figures[name] is None for name in _COMFORT):
        return None
    return all(low <= figures[name] <= high for name, (low, high) in _COMFORT.items())


def greatest_accelerations(time_s, speed_mps, yaw_rad) -> dict:
    """The greatest lateral, forward and backward acceleration and the greatest jerk; None where a drive is too short to tell."""
    parts = accelerations(time_s, speed_mps, yaw_rad)
    names = (
        "lateral_acceleration_max_mps2",
        "longitudinal_acceleration_max_mps2",
        "longitudinal_acceleration_min_mps2",
        "jerk_max_mps3",
    )
    if not parts:
        return dict.fromkeys(names)
    _, longitudinal, lateral, jerk = (np.concatenate(part) for part in zip(*parts))
    return dict(
        zip(
            names,
            (
                float(np.abs(lateral).max()),
                float(longitudinal.max()),
                float(longitudinal.min()),
                float(jerk.max()),
            ),
        )
    )


def accelerations(time_s, speed_mps, yaw_rad) -> list:
    """(time, longitudinal, lateral, size of the jerk) of each part of the drive without a silence: (m,) seconds, m/s^2 and m/s^3.

    The lateral acceleration is speed times yaw rate: what follows from the odometry's pose and speed alone.
    """
    parts = []
    for part in np.split(np.arange(len(time_s)), np.flatnonzero(np.diff(time_s) > _SILENCE_S) + 1):
        if len(part) >= _FEWEST:
            parts += _slopes(time_s[part], speed_mps[part], np.unwrap(yaw_rad[part]))
    return parts


def _slopes(time_s, speed_mps, yaw_rad) -> list:
    from scipy.signal import savgol_filter  # slow to load, and needed once, at the end of a drive

    step_s = float(np.median(np.diff(time_s)))
    if np.ptp(np.diff(time_s)) > 0.01 * step_s:
        even_s = np.arange(time_s[0], time_s[-1] + 0.5 * step_s, step_s)
        speed_mps, yaw_rad, time_s = (
            np.interp(even_s, time_s, speed_mps),
            np.interp(even_s, time_s, yaw_rad),
            even_s,
        )
    window = max(_FEWEST, int(round(_SMOOTHING_S / step_s)) | 1)
    if len(time_s) < window:
        return []

    def slope(values):
        return savgol_filter(values, window, 2, deriv=1, delta=step_s)

    longitudinal, lateral = slope(speed_mps), speed_mps * slope(yaw_rad)
    return [(time_s, longitudinal, lateral, np.hypot(slope(longitudinal), slope(lateral)))]
