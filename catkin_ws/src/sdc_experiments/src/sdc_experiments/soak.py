"""The parts of the soak test: a route of many laps, and the judgement on a process."""

from __future__ import annotations

from statistics import median
from typing import NamedTuple, Sequence

import numpy as np

from sdc_sim.road.route_generator import generate_route

SPEED_MPS = 10.0
# The bends are wide enough for this speed.
LAP = [{"straight_m": 200.0}, {"left_deg": 180.0, "radius_m": 40.0, "transition_m": 20.0}] * 2
WARM_UP_PERCENT = 25.0
_MIN_SAMPLES = 5


class ProcessSample(NamedTuple):
    """The state of a process at one moment of the drive.

    Attributes:
        percent: completed share of the drive [%]
        memory_mb: private memory [MB]
        files: number of open files
    """

    percent: float
    memory_mb: float
    files: int


class ProcessVerdict(NamedTuple):
    """The judgement on a process.

    Attributes:
        memory_mb: private memory at the end of the warm-up [MB]
        growth_mb: largest growth after that [MB]
        leaked_files: number of files that stayed open
    """

    memory_mb: float
    growth_mb: float
    leaked_files: int


def laps(hours: float) -> np.ndarray:
    """Return a route of laps on an oval.

    Args:
        hours: simulated time that the default car needs for it [h]

    Returns:
        (N, 2) points x, y in CARLA coordinates, 1 m apart [m]
    """
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}
    lap = generate_route({"elements": LAP, "spacing_m": 1.0, "start": start})[:-1, :2]
    return np.tile(lap, (max(1, int(np.ceil(3600.0 * hours * SPEED_MPS / len(lap)))), 1))


def judge(samples: Sequence[ProcessSample]) -> ProcessVerdict | None:
    """Return the verdict on a process, or None if it did not run during most of the drive.

    Samples at the last percentage do not count: they may be from after the drive, when the report
    is written.

    Args:
        samples: samples of one process in the order of time
    """
    driven = [
        sample for sample in samples if WARM_UP_PERCENT <= sample.percent < samples[-1].percent
    ]
    if len(driven) < _MIN_SAMPLES:
        return None
    # Each request to the master opens a file for a moment: medians ignore it.
    tenth = max(1, len(driven) // 10)
    leaked = median(sample.files for sample in driven[-tenth:]) - median(
        sample.files for sample in driven[:tenth]
    )
    return ProcessVerdict(
        driven[0].memory_mb,
        max(sample.memory_mb for sample in driven) - driven[0].memory_mb,
        max(0, round(leaked)),
    )
