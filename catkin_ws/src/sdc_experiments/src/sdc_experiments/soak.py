"""Drive laps for many simulated hours in lockstep and watch every process.

rosrun sdc_experiments soak.py [hours:=10] [camera:=false]

The exit status is 0 if the drive was completed without a missed tick, no process grew by 5 MB or
more after the warm-up, and no file stayed open.
"""

from __future__ import annotations

import contextlib
import math
import re
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
import psutil

from sdc_experiments.process_metrics import (
    measured_drive,
    private_memory_mb,
    process_name,
    stack_processes,
)
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.road.route_generator import generate_route
from sdc_sim.runner import CheckedDrive

SPEED_MPS = 10.0
# The bends are wide enough for this speed.
LAP = [{"straight_m": 200.0}, {"left_deg": 180.0, "radius_m": 40.0, "transition_m": 20.0}] * 2
MAX_GROWTH_MB = 5.0
_WARM_UP_PERCENT = 25.0
_MIN_SAMPLES = 5
_PROGRESS = re.compile(r"referee: *([0-9.]+) %")
# The route takes long to load, and a busy machine must not cause a missed tick.
_SIM_OPTIONS = "{start_patience_s: 600.0, patience_s: 60.0}"


def laps(hours: float) -> np.ndarray:
    """Return a route of laps on an oval that takes the default car so many simulated hours.

    Returns:
        (N, 2) points x, y in CARLA coordinates, 1 m apart [m]
    """
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}
    lap = generate_route({"elements": LAP, "spacing_m": 1.0, "start": start})[:-1, :2]
    return np.tile(lap, (max(1, int(np.ceil(3600.0 * hours * SPEED_MPS / len(lap)))), 1))


def judge(samples: np.ndarray) -> tuple[float, float, int] | None:
    """Return the verdict on a process, or None if it did not run during most of the drive.

    Samples at the last percentage may be from after the drive, when the report is written.

    Args:
        samples: (N, 3) completed share of the drive [%], private memory [MB] and number of open
            files of the process, in the order of time

    Returns:
        memory at the end of the warm-up [MB], largest growth after that [MB], number of files that
        stayed open
    """
    percent = samples[:, 0]
    driven = samples[(percent >= _WARM_UP_PERCENT) & (percent < percent[-1])]
    if len(driven) < _MIN_SAMPLES:
        return None
    _, memory_mb, files = driven.T
    # Each request to the master opens a file for a moment: medians ignore it.
    tenth = max(1, len(driven) // 10)
    leaked = round(float(np.median(files[-tenth:]) - np.median(files[:tenth])))
    return float(memory_mb[0]), float(memory_mb.max() - memory_mb[0]), max(0, leaked)


def _percent(log: Path, last: float) -> float:
    """Return the completed share of a drive [%] from the end of its log, the last one without."""
    with open(log, "rb") as file:
        file.seek(max(0, log.stat().st_size - 4096))
        printed = _PROGRESS.findall(file.read().decode(errors="replace"))
    return float(printed[-1]) if printed else last


def soak(hours: float, camera: str) -> bool:
    """Drive all laps, print the drive and a table of all processes; return whether all is good.

    Raises:
        RuntimeError: the drive wrote no report; the message contains the end of its output
    """
    samples: dict[tuple[str, int], list] = defaultdict(list)
    percent = 0.0

    def sample(drive: CheckedDrive) -> None:
        nonlocal percent
        percent = _percent(Path(drive.log_path), percent)
        for process in stack_processes(drive.environment["ROS_MASTER_URI"]):
            with contextlib.suppress(psutil.Error):
                row = percent, private_memory_mb(process), process.num_fds()
                samples[process_name(process), process.pid].append(row)

    # The y axis of `laps` points to the right.
    route_m, given = laps(hours) * (1.0, -1.0), {"sim_options": _SIM_OPTIONS}
    metrics = measured_drive(camera, given=given, route_m=route_m, timeout_s=math.inf, watch=sample)
    print(
        f"{metrics['status']}: {metrics['duration_s'] / 3600.0:.2f} simulated hours, "
        f"{metrics['ticks']} ticks, {metrics['missed_ticks']} missed, "
        f"{metrics['real_time_factor']:.0f} times real time"
    )
    good = metrics["status"] == COMPLETED and metrics["missed_ticks"] == 0
    print("| process | memory after warm-up | growth | files left open |\n|---|---|---|---|")
    for (name, _), rows in sorted(samples.items()):
        if (verdict := judge(np.array(rows))) is not None:
            memory_mb, growth_mb, leaked = verdict
            print(f"| {name} | {memory_mb:.1f} MB | {growth_mb:.2f} MB | {leaked} |")
            good = good and growth_mb < MAX_GROWTH_MB and leaked == 0
    return good


def main() -> None:
    """Run the command."""
    arguments = dict(word.split(":=", 1) for word in sys.argv[1:] if ":=" in word)
    hours, camera = float(arguments.pop("hours", "10")), arguments.pop("camera", "false")
    if arguments or not hours > 0.0 or camera not in ("true", "false"):
        sys.exit(__doc__)
    good = soak(hours, camera)
    print("flat" if good else "NOT flat")
    sys.exit(0 if good else 1)
