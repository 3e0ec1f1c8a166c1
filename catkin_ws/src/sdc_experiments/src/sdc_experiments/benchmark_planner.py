"""Time the local planner on routes of a thousand to a million waypoints.

python3 -m sdc_experiments.benchmark_planner
"""

from __future__ import annotations

import time
import tracemalloc
from typing import NamedTuple

import numpy as np

from sdc_experiments.configuration import node_parameters
from sdc_package.local_planner import LocalPlanner, PlannerSettings
from sdc_package.obstacles import DetectedObstacle
from sdc_package.waypoint_search import WaypointSearch

_TICKS = 2000
_COUNTS = (1_000, 10_000, 100_000, 1_000_000)


class PlannerTimes(NamedTuple):
    """What a route of some length costs.

    Attributes:
        load_s: time to load the route [s]
        memory_mb: memory that the planner keeps [MB]
        tick_us: median time of a tick [us]
        obstacle_tick_us: median time of a tick with an obstacle ahead [us]
    """

    load_s: float
    memory_mb: float
    tick_us: float
    obstacle_tick_us: float


def winding_route(count: int) -> np.ndarray:
    """Return (count, 2) points, 1 m apart, on a winding road that does not cross itself [m]."""
    heading = 0.9 * np.sin(np.arange(count) / 60.0)
    return np.column_stack([np.cumsum(np.cos(heading)), np.cumsum(np.sin(heading))])


def measure(count: int) -> PlannerTimes:
    """Measure the planner in the middle of a route of `count` waypoints."""
    points = winding_route(count)
    settings = PlannerSettings.read(node_parameters("local_planner").__getitem__)
    tracemalloc.start()
    start = time.perf_counter()
    planner = LocalPlanner(points, settings)
    search = WaypointSearch(planner.route.points)
    x, y = points[count // 2].tolist()
    planner.plan(search.first_ahead(x, y), x, y, 0.0)
    load_s = time.perf_counter() - start
    memory_mb = tracemalloc.get_traced_memory()[0] / 1e6
    tracemalloc.stop()
    times: tuple[list[float], list[float]] = ([], [])
    for tick in range(_TICKS):
        x, y = points[(count // 2 + tick // 4) % count].tolist()
        obstacles = [DetectedObstacle(x + 30.0, y, 0.0, 4.7, 2.0, 0.0)] if tick % 2 else []
        start = time.perf_counter()
        planner.plan(search.first_ahead(x, y), x, y, 0.0, obstacles)
        times[tick % 2].append(time.perf_counter() - start)
    free_us, obstacle_us = (1e6 * float(np.median(values)) for values in times)
    return PlannerTimes(load_s, memory_mb, free_us, obstacle_us)


def main() -> None:
    """Measure all routes and print a table."""
    print("waypoints    load      memory    tick    tick with an obstacle")
    for count in _COUNTS:
        times = measure(count)
        print(
            f"{count:9,d}  {times.load_s:6.2f} s  {times.memory_mb:7.1f} MB  "
            f"{times.tick_us:4.0f} us  {times.obstacle_tick_us:4.0f} us",
            flush=True,
        )


if __name__ == "__main__":
    main()
