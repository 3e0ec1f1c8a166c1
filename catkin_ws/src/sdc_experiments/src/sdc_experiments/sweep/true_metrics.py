"""Metrics of the true motion of a car whose odometry is noisy or late, and of its steering."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from sdc_sim.evaluation.drive_evaluation import COLUMNS
from sdc_sim.evaluation.metrics import peak_accelerations, root_mean_square
from sdc_sim.physics.vehicle import VehicleState

_PEAKS = ("lateral_acceleration_max_mps2", "jerk_max_mps3")
TRUE_METRICS = (
    *("true_cross_track_rms_m", "true_cross_track_max_m", "true_heading_rms_rad"),
    *(f"true_{name}" for name in _PEAKS),
    "steer_rate_rms_per_s",
)


def true_metrics(rows: np.ndarray, states: Sequence[VehicleState]) -> dict[str, float | None]:
    """Return TRUE_METRICS of a drive; None for those that a short drive does not define.

    The true states of the vehicle are those at the rows (n, 11) of its trace.
    """
    trace = dict(zip(COLUMNS, rows.T))
    found: dict[str, float | None] = dict.fromkeys(TRUE_METRICS)
    if not len(rows):
        return found
    motion = [
        (state.x_m, state.y_m, state.yaw_rad, math.hypot(state.speed_mps, state.lateral_speed_mps))
        for state in states[: len(rows)]
    ]
    x, y, yaw, speed = np.transpose(motion)
    heading = trace["yaw_rad"] - trace["heading_error_rad"]
    off_x, off_y = x - trace["x_m"], y - trace["y_m"]
    error = np.abs(trace["cross_track_m"] + off_y * np.cos(heading) - off_x * np.sin(heading))
    turned = np.remainder(yaw - heading + math.pi, 2.0 * math.pi) - math.pi
    found["true_cross_track_rms_m"] = root_mean_square(error)
    found["true_cross_track_max_m"] = float(error.max())
    found["true_heading_rms_rad"] = root_mean_square(turned)
    peaks = peak_accelerations(trace["time_s"], speed, yaw)
    found.update({f"true_{name}": peaks[name] for name in _PEAKS})
    rates = np.diff(trace["steer"]) / np.diff(trace["time_s"])
    rates = rates[np.isfinite(rates)]
    found["steer_rate_rms_per_s"] = root_mean_square(rates) if len(rates) else None
    return found
