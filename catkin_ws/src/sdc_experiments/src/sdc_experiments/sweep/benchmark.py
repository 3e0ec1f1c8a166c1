"""Time sweeps in process: drives per second, and how much faster two workers are than one.

python3 -m sdc_experiments.sweep.benchmark [--drives N]

The ratio is the median over rounds; in each round, one worker and two workers drive alternately.
The whole sweep, with its start and its page, is timed afterwards, on all cores.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Sequence

import rospkg

from sdc_experiments.sweep.cell_drive import code_version, drive_cell
from sdc_experiments.sweep.command import run
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_experiments.sweep.settings import IN_PROCESS
from sdc_experiments.sweep.study import Cell, load_study

_ROUNDS = 5
_DRIVES_OF_A_ROUND = 60
_STUDY = """about: drives for a benchmark
scenarios: [{scenario}]
settings: {{sim_options/odometry_noise/position_m: 0.02}}
factors:
  simple_controller/stanley_compensated/k: [1.5, 2.0, 2.5, 3.0]
seeds: {seeds}
"""


def drives_per_second(engine: DaskEngine, cells: Sequence[Cell]) -> float:
    """Return the rate at which an engine drives some cells."""
    version = code_version()
    tasks = ((cell.key, (tuple(cell), IN_PROCESS, 0.0, version)) for cell in cells)
    start_s = time.monotonic()
    errors = [outcome.error for outcome in engine.outcomes(drive_cell, tasks) if outcome.error]
    assert not errors, errors[0]
    return len(cells) / (time.monotonic() - start_s)


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=2000, help="drives of the whole sweep")
    drives = parser.parse_args().drives
    package = Path(rospkg.RosPack().get_path("sdc_experiments"))
    scenario = str(package / "studies" / "bends.yaml")
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "benchmark.yaml"
        path.write_text(_STUDY.format(scenario=scenario, seeds=-(-drives // 4)), encoding="utf-8")
        cells = load_study(str(path)).cells()
        ratios = []
        with DaskEngine("", 1) as one, DaskEngine("", 2) as two:
            drives_per_second(one, cells[:2])
            drives_per_second(two, cells[:8])
            for number in range(_ROUNDS):
                alone = drives_per_second(one, cells[:_DRIVES_OF_A_ROUND])
                both = drives_per_second(two, cells[: 2 * _DRIVES_OF_A_ROUND])
                ratios.append(both / alone)
                print(
                    f"round {number + 1}: {alone:.2f} drives/s with one worker, {both:.2f} with "
                    f"two: {ratios[-1]:.2f} times; load {os.getloadavg()[0]:.1f}",
                    flush=True,
                )
        print(f"two workers are {median(ratios):.2f} times as fast as one")
        start_s = time.monotonic()
        run([str(path), "--output", str(Path(name) / "results")])
        wall_s = time.monotonic() - start_s
    print(
        f"{len(cells)} drives of 300 m in {wall_s:.0f} s on {os.cpu_count()} cores: "
        f"{len(cells) / wall_s:.1f} drives/s; load {os.getloadavg()[0]:.1f}"
    )


if __name__ == "__main__":
    main()
