"""What a drive of many hours does to its processes: the laps that it drives, and whether memory and files stay flat."""

from __future__ import annotations

from statistics import median
from typing import NamedTuple

import numpy as np

from sdc_sim.road.route_generator import draw

SPEED_MPS = 10.0
# Bends wide enough for that speed.
LAP = [{"straight_m": 200.0}, {"left_deg": 180.0, "radius_m": 40.0, "transition_m": 20.0}] * 2
WARM_UP_PERCENT = 25.0


class ProcessSample(NamedTuple):
    """One process at one moment of the drive: how far the drive had come, and what the process had for itself."""

    percent: float
    memory_mb: float
    files: int


class Verdict(NamedTuple):
    """memory_mb at the end of the warm-up, the most that it grew by after that, and by how many open files."""

    memory_mb: float
    growth_mb: float
    leaked_files: int


def laps(hours: float) -> np.ndarray:
    """Rows of x, y (metres, CARLA coordinates), 1 m apart, of so many laps of an oval as the default car drives in this time: (N, 2)."""
    lap = draw(
        {"elements": LAP, "spacing_m": 1.0, "start": {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}}
    )[:-1, :2]
    return np.tile(lap, (max(1, int(np.ceil(3600.0 * hours * SPEED_MPS / len(lap)))), 1))


def judge(samples) -> Verdict:
    """The Verdict on the samples of one process in the order of time, None for one that was not there all the way.

    What was seen at the last percentage may have been seen after the drive, when the report was made.
    """
    driven = [
        sample for sample in samples if WARM_UP_PERCENT <= sample.percent < samples[-1].percent
    ]
    if len(driven) < 5:
        return None
    # Files come and go with every question to the master: medians tell what stays.
    tenth = max(1, len(driven) // 10)
    leaked = median(sample.files for sample in driven[-tenth:]) - median(
        sample.files for sample in driven[:tenth]
    )
    return Verdict(
        driven[0].memory_mb,
        max(sample.memory_mb for sample in driven) - driven[0].memory_mb,
        max(0, round(leaked)),
    )
