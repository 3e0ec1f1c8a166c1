"""The score of a drive, and of many; docs/championship.md has the reasons."""

from __future__ import annotations

import math
from typing import Any, Mapping

import numpy as np

from sdc_experiments.championship.league import LEAGUES
from sdc_sim.evaluation.drive_evaluation import COLUMNS, DriveEvaluation
from sdc_sim.evaluation.metrics import accelerations, root_mean_square

# The errors count from here: a car may start beside its path [m].
_COUNTED_FROM_M = 25.0


def values(result: DriveEvaluation) -> dict[str, float]:
    """Return what the parts of the score are computed from, of the true motion of a car."""
    trace = dict(zip(COLUMNS, result.rows.T))
    time_s, speed = trace["time_s"], trace["speed_mps"]
    error = np.abs(trace["cross_track_m"][trace["s_m"] >= _COUNTED_FROM_M])
    jerk = [part[3] for part in accelerations(time_s, speed, trace["yaw_rad"])]
    steer = trace["steer"][np.isfinite(trace["steer"])]
    rates = np.diff(steer) / np.median(np.diff(time_s)) if len(steer) > 1 else np.zeros(1)
    metrics, ideal = result.metrics, result.ideal.speed_mps
    cruise_mps = result.progress.rules.planner["planned_speed_mps"]

    def work(speeds: np.ndarray) -> float:
        return float(np.maximum(np.diff(speeds**2), 0.0).sum())

    return {
        "error_rms_m": root_mean_square(error) if len(error) else math.inf,
        "error_max_m": float(error.max()) if len(error) else math.inf,
        "time_ratio": metrics["time_ratio"],
        "jerk_rms_mps3": root_mean_square(np.concatenate(jerk)) if jerk else math.inf,
        "steer_rate_rms_per_s": root_mean_square(rates),
        "energy_ratio": work(speed) / work(ideal),
        "over_limit_mps": max(0.0, float(speed.max()) - cruise_mps),
        "lateral_max_mps2": metrics["lateral_acceleration_max_mps2"] or 0.0,
    }


def points(league: str, found: Mapping[str, float]) -> dict[str, float]:
    """Return the points of each part of the score, from values by the names of the parts."""
    return {
        name: weight * _share(found[name], good, bad, scale)
        for name, (weight, good, bad, scale) in LEAGUES[league]["score"].items()
    }


def _share(value: float, good: float, bad: float, scale: str) -> float:
    """Return 1 for the good value, 0 for the bad one, and between them in proportion."""
    if scale == "log":
        value, good, bad = (math.log(max(number, 1e-9)) for number in (value, good, bad))
    return min(max((bad - value) / (bad - good), 0.0), 1.0)


def score(parts: Mapping[str, float], metrics: Mapping[str, Any]) -> float:
    """Return the score of a drive, 0 to 100: its points times its driving score."""
    return sum(parts.values()) * metrics["driving_score"] / 100.0
