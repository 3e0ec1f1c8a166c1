"""Drive between random places of a map.

    python3 -m sdc_experiments.map_drives MAP [COUNT [OTHERS [LENGTH_M]]]

Prints the time to load the map, and of COUNT drives (100) with the seeds 0, 1, ...: how many are
complete, the greatest errors, a sum of all traces, which is the same in each run, how the drives
ended with which infractions, and the seeds of the first 20 that were not clean; among OTHERS road
users also the time of a tick, and how many drives were comfortable. With LENGTH_M it takes the
seeds whose routes are about as long.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Iterator

import numpy as np

from sdc_experiments.closed_loop import drive_result
from sdc_package.speed_control import LATE_MPS
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.road.lane_graph import LaneGraph
from sdc_sim.road.network_file import MapError, load_network
from sdc_sim.scenario.map_drive import first_mission

# A route is about as long as wanted within this share.
_ABOUT = 0.2


def seeds_of(graph: LaneGraph, length_m: int) -> Iterator[int]:
    """Yield the seeds, those whose routes are about this long; 0: all."""
    for seed in itertools.count():
        points_m = first_mission(graph, None, (), seed)[0].points_m if length_m else ()
        away_m = np.hypot(*np.diff(points_m, axis=0).T).sum() - length_m if length_m else 0.0
        if abs(away_m) <= _ABOUT * length_m:
            yield seed


def had_emergency(result: DriveEvaluation) -> bool:
    """Return whether the car was so much faster than its plan that it braked with all jerk.

    This is the controller's condition for `emergency_jerk_mps3`: it has seen something late.
    """
    _, planned_mps, time_s = np.array(result.planned).reshape(-1, 3).T
    speed_mps = np.interp(time_s, *result.rows[:, [0, 4]].T)
    return bool((planned_mps < speed_mps - LATE_MPS).any())


def one_drive(path: str, traffic: int, seed: int) -> tuple[dict[str, Any], str]:
    """Return the metrics of a drive between places drawn from a seed, and the sum of its trace."""
    started_s = time.process_time()
    result = drive_result(map=path, seed=seed, traffic=traffic, compiled=True)
    tick_ms = 1000.0 * (time.process_time() - started_s) / len(result.rows)
    trace = hashlib.sha256(result.rows.tobytes()).hexdigest()
    more = {"tick_ms": tick_ms, "emergency": had_emergency(result)}
    return {**result.metrics, **more}, trace


def main() -> None:
    """Run the command line."""
    if len(sys.argv) not in range(2, 6) or not all(one.isdecimal() for one in sys.argv[2:]):
        sys.exit("Usage: python3 -m sdc_experiments.map_drives MAP [COUNT [OTHERS [LENGTH_M]]]")
    path, given = sys.argv[1], [int(one) for one in sys.argv[2:]]
    count, traffic, length_m = (*given, *(100, 0, 0)[len(given) :])
    started_s = time.perf_counter()
    try:
        network = load_network(path)
    except MapError as error:
        sys.exit(f"map_drives: {error}")
    graph = LaneGraph(network)
    print(f"{network.name}: loaded in {time.perf_counter() - started_s:.2f} s")
    seeds = list(itertools.islice(seeds_of(graph, length_m), count))
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(functools.partial(one_drive, path, traffic), seeds, chunksize=4))
    metrics = [one for one, _ in found]
    clean = [
        one for one in metrics if one["status"] == "completed" and one["driving_score"] >= 100.0
    ]
    print(
        f"{len(clean)} of {count} drives complete without infraction, "
        f"{sum(one['route_length_m'] for one in metrics) / 1000.0:.1f} km; greatest RMS "
        f"{max(one['cross_track_rms_m'] for one in metrics):.4f} m, greatest error "
        f"{max(one['cross_track_max_m'] for one in metrics):.3f} m, off the lane "
        f"{max(one['off_lane_percent'] for one in metrics):.1f} %; traces "
        f"{hashlib.sha256(''.join(trace for _, trace in found).encode()).hexdigest()[:16]}"
    )
    ends = Counter(one["status"] for one in metrics)
    for one in metrics:
        ends.update(one["infractions"])
        ends["collisions at fault"] += one["collisions_at_fault"]
    print(", ".join(f"{count} {end}" for end, count in ends.items() if count))
    others = [seed for seed, one in zip(seeds, metrics) if one not in clean]
    print("seeds of the others:", ", ".join(map(str, others[:20])) or "none")
    if traffic:
        calm = [bool(one["comfortable"]) for one in metrics if not one["emergency"]]
        print(
            f"comfortable: {sum(calm)} of {len(calm)} drives without an emergency, "
            f"{sum(bool(one['comfortable']) for one in metrics)} of all"
        )
        print(f"a tick takes {np.median([one['tick_ms'] for one in metrics]):.2f} ms (median)")


if __name__ == "__main__":
    main()
