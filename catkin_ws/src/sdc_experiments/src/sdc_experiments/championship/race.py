"""./championship race: up to eight drivers in one world; docs/several_cars.md describes it."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Mapping

import numpy as np

from sdc_experiments.championship.attempt import write_page
from sdc_experiments.championship.command import source_of
from sdc_experiments.championship.drive import TimedDriver, TrueRecorder, row_of
from sdc_experiments.championship.driver_process import DriverError, DriverServer
from sdc_experiments.championship.league import draw, generator
from sdc_experiments.championship.mission import DriverMission
from sdc_experiments.closed_loop import evaluation_rules
from sdc_experiments.commands import called
from sdc_experiments.configuration import node_parameters
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.road.random_routes import long_route
from sdc_sim.scenario.drive_setup import drive_setup
from sdc_sim.scenario.packaged import overridden
from sdc_sim.simulation import shared_world

_ROUTE = {"length_m": 600.0, "least_radius_m": 12.0}
_SHOWN_TICKS = 2  # of so many ticks, the page shows one


def drive_race(
    servers: Mapping[str, DriverServer], seed: str, late: Mapping[str, list] | None = None
) -> tuple[list[dict[str, Any]], np.ndarray]:
    """Let drivers race, and return their rows in the order of the result, and the route.

    The order of the servers has no influence. `late` has the records of an earlier race by driver,
    which are repeated.
    """
    drawn = draw("driving", seed)
    grid = generator("race", seed, "grid").permutation(sorted(servers)).tolist()
    route_m = long_route(generator("race", seed, "route"), **_ROUTE)
    setup = drive_setup("", route_m, {**drawn.sim, "cars": len(grid)})
    world = setup.world()
    limits = overridden(node_parameters("local_planner"), drawn.planner, "planner")
    rules, tick_ns = evaluation_rules(limits), round(1e9 * world.tick_s)
    drivers, recorders, processes = {}, {}, {}
    tracks: dict[str, list] = {car: [] for car in world.cars}
    for car, name in zip(world.cars, grid):
        first = replace(world.cars[car].observation, stamp_ns=tick_ns)
        mission, problem = DriverMission(drawn.league, setup.waypoints_m, first, limits), ""
        try:
            processes[car] = servers[name].start(mission)
        except DriverError as error:
            problem = f"it did not start: {error}"
        drivers[car] = TimedDriver(processes.get(car), tick_ns, late[name] if late else None)
        drivers[car].problem = problem
        recorders[car] = TrueRecorder(rules, setup.waypoints_m, world.cars[car])

    def observe(snapshots: Mapping[str, Any]) -> None:
        for car in () if world.tick % _SHOWN_TICKS else snapshots:
            state = world.cars[car].vehicle.state
            place = state.x_m, state.y_m, state.yaw_rad, state.speed_mps
            tracks[car].append([round(value, 2) for value in place])

    try:
        shared_world.race(world, drivers, recorders, observe=observe)
    finally:
        refused = {car: process.close() for car, process in processes.items()}
    rows = []
    for place, (car, name) in enumerate(zip(world.cars, grid)):
        driver, progress = drivers[car], recorders[car].evaluator.result().progress
        ends = driver.problem, refused.get(car, []), driver.lateness.record, driver.spent_ms
        row = {"driver": name, "car": car, "start_place": len(grid) - place, "track": tracks[car]}
        row.update(row_of(drawn, recorders[car], *ends))
        row.update(duration_s=progress.duration_s, way_m=progress.progress_m)
        rows.append(row)
    return sorted(rows, key=_rank), setup.route.points


def _rank(row: Mapping[str, Any]) -> tuple:
    arrived = row["status"] == COMPLETED
    return not arrived, row["duration_s"] if arrived else -row["way_m"], row["driver"]


def run(options: SimpleNamespace) -> int:
    """Let drivers race, print the result and write the page."""
    paths = [*map(Path, options.file)]
    if not 2 <= len(paths) <= shared_world.MOST_CARS or {path.suffix for path in paths} != {".py"}:
        raise ValueError(
            f"race: name two to eight drivers, such as {called('championship')} race A.py B.py"
        )
    stems = [path.stem for path in paths]
    names = [f"{stem}-{i}" if stem in stems[:i] else stem for i, stem in enumerate(stems)]
    late, seed = None, options.seed
    if options.replay:
        earlier = json.loads(Path(options.replay).read_text(encoding="utf-8"))
        seed = earlier["seed"]
        late = {row["driver"]: row["late"] for row in earlier["rows"]}
        if set(late) != set(names):
            raise ValueError(
                f"replay: the drivers must be those of {options.replay}: {', '.join(late)}"
            )
    with contextlib.ExitStack() as stack:
        servers = {
            name: stack.enter_context(DriverServer(source_of(path), options.sandbox))
            for name, path in zip(names, paths)
        }
        rows, route_m = drive_race(servers, seed, late)
    page = Path(options.report).with_suffix(".html")
    page.parent.mkdir(parents=True, exist_ok=True)
    kept = [{key: row[key] for key in row if key != "track"} for row in rows]
    text = json.dumps({"seed": seed, "rows": kept}, indent=1)
    page.with_suffix(".json").write_text(text + "\n", encoding="utf-8")
    data = {
        "step_s": 0.05 * _SHOWN_TICKS,
        "route": route_m[::2].round(2).tolist(),
        "tracks": [row["track"] for row in rows],
    }
    write_page(page, "race.html.jinja", rows=kept, seed=seed, data=data)
    for place, row in enumerate(rows, 1):
        end = f"{row['status'].replace('_', ' ')} after {row['way_m']:.0f} m and "
        end = f"{'' if row['status'] == COMPLETED else end}{row['duration_s']:.2f} s"
        print(f"race: {place}. {row['driver']}: {end}, from place {row['start_place']}")
        for text in filter(None, (row["problem"], *row["refused"])):
            print(f"race: {row['driver']}: {text}")
    won = rows[0]["driver"] if rows[0]["status"] == COMPLETED else "no driver"
    print(f"championship: race: {won} of {len(rows)} wins on seed {seed}; see {page}")
    return 1 if any(row["problem"] or row["refused"] for row in rows) else 0
