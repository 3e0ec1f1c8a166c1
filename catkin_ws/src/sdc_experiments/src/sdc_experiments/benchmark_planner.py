"""Times the local planner on routes of a thousand to a million waypoints: python3 -m sdc_experiments.benchmark_planner"""

from __future__ import annotations

import time
import tracemalloc

import numpy as np

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_package.local_planner import LocalPlanner
from sdc_package.obstacles import DetectedObstacle, ObstacleMargins
from sdc_package.waypoint_search import WaypointSearch

_TICKS = 2000
_COUNTS = (1_000, 10_000, 100_000, 1_000_000)


def winding_route(count: int) -> np.ndarray:
    """(count, 2) points 1 m apart on a road that winds but never turns back."""
    heading = 0.9 * np.sin(np.arange(count) / 60.0)
    return np.column_stack([np.cumsum(np.cos(heading)), np.cumsum(np.sin(heading))])


def measure(count: int):
    """(seconds to load, megabytes kept, median microseconds a tick, the same with an obstacle in sight)."""
    points = winding_route(count)
    tracemalloc.start()
    start = time.perf_counter()
    planner = LocalPlanner(
        points,
        SpeedLimits(10.0, 3.0, 1.8, 2.5, 6.0),
        lookahead_m=25.0,
        join_within_m=20.0,
        caution=ObstacleMargins(side_m=0.4, gap_m=5.0, car_front_m=2.35, car_width_m=2.0),
    )
    search = WaypointSearch(planner.route.points)
    planner.plan(search.first_ahead(*points[count // 2]), *points[count // 2], 0.0)
    load_s = time.perf_counter() - start
    megabytes = tracemalloc.get_traced_memory()[0] / 1e6
    tracemalloc.stop()
    times = ([], [])
    for tick in range(_TICKS):
        x, y = points[(count // 2 + tick // 4) % count]
        obstacles = [DetectedObstacle(x + 30.0, y, 0.0, 4.7, 2.0, 0.0)] if tick % 2 else []
        start = time.perf_counter()
        planner.plan(search.first_ahead(x, y), x, y, 0.0, obstacles)
        times[tick % 2].append(time.perf_counter() - start)
    return load_s, megabytes, *(1e6 * float(np.median(values)) for values in times)


def main() -> None:
    print("waypoints    load      memory    tick    tick with an obstacle")
    for count in _COUNTS:
        load_s, megabytes, free_us, blocked_us = measure(count)
        print(
            f"{count:9,d}  {load_s:6.2f} s  {megabytes:7.1f} MB  {free_us:4.0f} us  {blocked_us:4.0f} us",
            flush=True,
        )


if __name__ == "__main__":
    main()
