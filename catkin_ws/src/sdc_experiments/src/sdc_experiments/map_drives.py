"""Drive between random places of a map.

    python3 -m sdc_experiments.map_drives MAP [COUNT [OTHERS [LENGTH_M [FIRST]]]]

Prints the time to load the map, and of COUNT drives (100) with seeds from FIRST (0): how many are
complete, the greatest errors, a sum of all traces, which is the same in each run, and how the
drives ended with which infractions; each drive that is not clean has a line when it ends. Among
OTHERS road users it also prints the collisions, those at fault, how many drives were comfortable,
and the time of a tick. With LENGTH_M it takes the seeds whose routes are about as long. In a MAP
random:FIRST-LAST each drive has a town of its own, and its seed or the next with such a route.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Callable, Iterator, Sequence

import numpy as np

from sdc_common.geometry.route import Route
from sdc_experiments.closed_loop import drive_result
from sdc_map.crossings import crossings, places_along
from sdc_map.lane_graph import LaneGraph, NoRouteError
from sdc_map.map_file import map_file, town_seeds
from sdc_map.network_file import MapError, load_network
from sdc_package.behaviour.scene import PEDESTRIAN
from sdc_sim.evaluation.metrics import comfort_breaks
from sdc_sim.scenario.map_drive import first_mission
from sdc_sim.simulation.snapshot import ObstacleState, Snapshot

_SEEDS = 500  # so many may follow each other whose routes have another length
_ABOUT = 0.2  # share within which a route is about as long as wanted
_BACK_M = 5.0  # the place of the car is searched from this distance behind the last place
_AHEAD_M = 50.0  # an emergency begins within this distance of the car
_GENTLE_MPS2 = 4.05  # hardest braking of a gentle stop, by nuPlan's limit
_REACTS_S = 0.5  # time for the car to react
_KEPT = 20  # ticks of the second for which the car would have kept its speed
_TICK_S = 0.05
_NEAR_M = 2.5  # a road user is on a lane within this distance
_CAR_FRONT_M = 2.35
_CAR_WIDTH_M = 2.0


def seeds_of(graph: LaneGraph, length_m: int, first: int = 0) -> Iterator[int]:
    """Yield the seeds from a first one whose routes are about this long; 0: all.

    Raises:
        MapError: there are too few such seeds
    """
    for seed in itertools.count(first):
        points_m = first_mission(graph, None, (), seed)[0].points_m if length_m else ()
        away_m = np.hypot(*np.diff(points_m, axis=0).T).sum() - length_m if length_m else 0.0
        if abs(away_m) <= _ABOUT * length_m:
            yield seed
            first = seed
        if seed - first >= _SEEDS:
            raise MapError(f"none of {_SEEDS} routes is about {length_m} m long; change LENGTH_M")


def had_emergency(
    route: Route, snapshots: Sequence[Snapshot], is_first: Callable[[ObstacleState], bool]
) -> bool:
    """Return whether a road user came into the way of the car too late for a gentle stop.

    This is a fact of the world: a tick before, it was beside the route. It is too late for the
    car as it is then; and, if it had to give way, for the car as it would be then if it had kept
    its speed for a second.
    """
    s_m = 0.0
    cars: list[tuple[float, float]] = []  # arc length and speed of the car
    known, inside = set[int](), set[int]()
    for snapshot in snapshots:
        car, last_known, last_inside = snapshot.state, known, inside
        known, inside = {user.id for user in snapshot.obstacles}, set()
        s_m = route.line.project(car.x_m, car.y_m, s_m, _BACK_M, _AHEAD_M).s_m
        cars = [*cars[-_KEPT:], (s_m, car.speed_mps)]
        before_m, kept_mps = cars[0]
        kept = before_m + (len(cars) - 1) * _TICK_S * kept_mps, kept_mps
        for user in snapshot.obstacles:
            if math.dist((car.x_m, car.y_m), (user.x_m, user.y_m)) > _AHEAD_M:
                continue
            place = route.line.project(user.x_m, user.y_m, s_m, 0.0, _AHEAD_M)
            turned_rad = user.yaw_rad - place.heading_rad
            cos, sin = math.cos(turned_rad), math.sin(turned_rad)
            across_m = 0.5 * (user.length_m * abs(sin) + user.width_m * abs(cos) + _CAR_WIDTH_M)
            along_m = 0.5 * (user.length_m * abs(cos) + user.width_m * abs(sin)) + _CAR_FRONT_M
            if place.distance_m > across_m or place.s_m <= s_m:
                continue
            inside.add(user.id)
            if user.id not in last_known or user.id in last_inside:
                continue
            for its_s_m, mps in cars[-1:] if is_first(user) else (cars[-1], kept):
                closing_mps = max(mps - user.speed_mps * cos, 0.0)
                room_m = max(place.s_m - its_s_m - along_m - _REACTS_S * closing_mps, 0.0)
                if closing_mps**2 > 2.0 * _GENTLE_MPS2 * room_m:
                    return True
    return False


def _first_on(path: str, route: Route) -> Callable[[ObstacleState], bool]:
    """Return a function that returns whether a road user may have right of way over the car."""
    network = load_network(path)
    met = crossings(network, route, list(places_along(network, route)), np.ones(len(route.s)))
    lanes = {lane for point in met for way in point.conflicts if way.is_first for lane in way.lanes}

    def is_first(user: ObstacleState) -> bool:
        place = network.nearest(user.x_m, user.y_m, user.yaw_rad, _NEAR_M, user.z_m)
        return user.kind == PEDESTRIAN or place is None or place.lane in lanes

    return is_first


def _drive_in_town(traffic: int, length_m: int, town: int) -> tuple[dict[str, Any], str]:
    """Return what `one_drive` returns, in a town that is drawn."""
    path = map_file(f"random:{town}")
    seed = next(seeds_of(LaneGraph(load_network(path)), length_m, town)) if length_m else town
    return one_drive(path, traffic, seed)


def one_drive(path: str, traffic: int, seed: int) -> tuple[dict[str, Any], str]:
    """Return the metrics of a drive between places drawn from a seed, and the sum of its trace."""
    started_s = time.process_time()
    seen: list[Snapshot] = []
    result = drive_result(map=path, seed=seed, traffic=traffic, compiled=True, observe=seen.append)
    tick_ms = 1000.0 * (time.process_time() - started_s) / len(result.rows)
    trace = hashlib.sha256(result.rows.tobytes()).hexdigest()
    emergency = had_emergency(result.route, seen, _first_on(path, result.route))
    breaks = comfort_breaks(*result.rows[:, [0, 4, 3]].T) or ()
    facts = {"tick_ms": tick_ms, "emergency": emergency, "breaks": breaks}
    return {**result.metrics, **facts}, trace


def main() -> None:
    """Run the command line."""
    if len(sys.argv) not in range(2, 7) or not all(word.isdecimal() for word in sys.argv[2:]):
        sys.exit("Usage: map_drives MAP [COUNT [OTHERS [LENGTH_M [FIRST]]]]")
    path, numbers = sys.argv[1], [int(word) for word in sys.argv[2:]]
    count, traffic, length_m, first = (*numbers, *(100, 0, 0, 0)[len(numbers) :])
    seeds = town_seeds(path)[:count]
    count = len(seeds) or count
    started_s = time.perf_counter()
    network = load_network(f"random:{seeds[0]}" if seeds else path)
    print(f"{network.name}: loaded in {time.perf_counter() - started_s:.2f} s")
    drive = functools.partial(_drive_in_town, traffic, length_m)
    if not seeds:
        seeds = list(itertools.islice(seeds_of(LaneGraph(network), length_m, first), count))
        drive = functools.partial(one_drive, path, traffic)
    metrics, total = [], hashlib.sha256()
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        drives = pool.map(drive, seeds)
        for seed, (row, trace) in zip(seeds, drives):
            metrics.append(row)
            total.update(trace.encode())
            if not _is_clean(row):
                ends = {name: n for name, n in row["infractions"].items() if n}
                fault = ", at fault" if row.get("collisions_at_fault") else ""
                print(f"drive {len(metrics)}, seed {seed}: {row['status']}{fault} {ends}")
    print(
        f"{sum(map(_is_clean, metrics))} of {count} drives complete without infraction, "
        f"{sum(row['route_length_m'] for row in metrics) / 1000.0:.1f} km; greatest RMS "
        f"{max(row['cross_track_rms_m'] for row in metrics):.4f} m, greatest error "
        f"{max(row['cross_track_max_m'] for row in metrics):.3f} m, off the lane "
        f"{max(row['off_lane_percent'] for row in metrics):.1f} %; traces {total.hexdigest()[:16]}"
    )
    ends = Counter(row["status"] for row in metrics)
    for row in metrics:
        ends.update(row["infractions"])
    print(", ".join(f"{count} {end}" for end, count in ends.items() if count))
    if traffic:
        _print_in_traffic(seeds, metrics)


def _is_clean(row: dict[str, Any]) -> bool:
    return row["status"] == "completed" and row["driving_score"] >= 100.0


def _print_in_traffic(seeds: list[int], metrics: list[dict[str, Any]]) -> None:
    faults = [seed for seed, row in zip(seeds, metrics) if row["collisions_at_fault"]]
    print(
        f"{sum(row['status'] == 'collision' for row in metrics)} collisions, {len(faults)} at "
        f"fault; seeds of those: {', '.join(map(str, faults)) or 'none'}"
    )
    calm = [row for row in metrics if not row["emergency"]]
    breaks = Counter(name for row in calm for name in row["breaks"])
    print(
        f"comfortable: {sum(not row['breaks'] for row in calm)} of {len(calm)} drives without an "
        f"emergency, {sum(not row['breaks'] for row in metrics)} of all; limits that those break: "
        f"{', '.join(f'{n} {name}' for name, n in breaks.most_common()) or 'none'}"
    )
    print(f"a tick takes {np.median([row['tick_ms'] for row in metrics]):.2f} ms (median)")


if __name__ == "__main__":
    try:
        main()
    except (MapError, NoRouteError) as error:
        sys.exit(f"map_drives: {error}")
