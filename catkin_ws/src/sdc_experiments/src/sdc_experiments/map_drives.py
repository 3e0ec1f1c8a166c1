"""Drive between random places of a map: python3 -m sdc_experiments.map_drives MAP [COUNT [OTHERS]].

Prints the time to load the map, and of COUNT drives (100) with the seeds 0, 1, ...: how many are
complete, the greatest errors, a sum of all traces, which is the same in each run, how the drives
ended with which infractions, and the seeds of the first 20 that were not clean; among OTHERS road
users also the time of a tick.
"""

from __future__ import annotations

import functools
import hashlib
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from sdc_experiments.closed_loop import drive_result
from sdc_sim.road.lane_graph import LaneGraph
from sdc_sim.road.network_file import MapError, load_network


def one_drive(path: str, traffic: int, seed: int) -> tuple[dict[str, Any], str]:
    """Return the metrics of a drive between places drawn from a seed, and the sum of its trace."""
    started_s = time.process_time()
    result = drive_result(map=path, seed=seed, traffic=traffic, compiled=True)
    tick_ms = 1000.0 * (time.process_time() - started_s) / len(result.rows)
    trace = hashlib.sha256(result.rows.tobytes()).hexdigest()
    return {**result.metrics, "tick_ms": tick_ms}, trace


def main() -> None:
    """Run the command line."""
    if len(sys.argv) not in (2, 3, 4) or not all(one.isdecimal() for one in sys.argv[2:]):
        sys.exit("Usage: python3 -m sdc_experiments.map_drives MAP [COUNT [OTHERS]]")
    path, given = sys.argv[1], [int(one) for one in sys.argv[2:]]
    count, traffic = given[0] if given else 100, given[1] if len(given) > 1 else 0
    started_s = time.perf_counter()
    try:
        network = load_network(path)
    except MapError as error:
        sys.exit(f"map_drives: {error}")
    LaneGraph(network)
    print(f"{network.name}: loaded in {time.perf_counter() - started_s:.2f} s")
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = list(
            pool.map(functools.partial(one_drive, path, traffic), range(count), chunksize=4)
        )
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
    print(", ".join(f"{count} {end}" for end, count in ends.items() if count))
    others = [seed for seed, one in enumerate(metrics) if one not in clean]
    print("seeds of the others:", ", ".join(map(str, others[:20])) or "none")
    if traffic:
        print(f"a tick takes {np.median([one['tick_ms'] for one in metrics]):.2f} ms (median)")


if __name__ == "__main__":
    main()
