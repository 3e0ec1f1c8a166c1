"""./scenarios: drive the scenario types on streets, and write their scores to one page.

docs/scenarios.md describes its arguments, the scores, the page and the exit status.
"""

from __future__ import annotations

import hashlib
import json
import math
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable, Iterable, Mapping, Sequence

import numpy as np
from scipy import stats

from sdc_experiments.championship.attempt import write_page
from sdc_experiments.championship.stack import nodes_drive
from sdc_experiments.closed_loop import drive_result
from sdc_experiments.sweep.cell_drive import code_version, worker_problem
from sdc_experiments.sweep.dask_engine import DaskEngine, cores
from sdc_experiments.sweep.progress import SweepProgress
from sdc_experiments.sweep.results import write_csv
from sdc_experiments.sweep.statistics import estimate
from sdc_map.map_file import RANDOM, map_file, town_seeds
from sdc_map.network_file import load_network
from sdc_sim.evaluation.drive_evaluation import OBSTACLES, DriveEvaluation
from sdc_sim.scenario.street_scenarios import Placement, of_map, types

OWN, NAIVE = "own", "naive"
_PASSES_PERCENT = 50.0  # a driver passes a type if more of its drives succeed
_WORST = 10  # number of the worst drives on the page
_SHOWN_TICKS = 10  # ticks, half a second, between two samples of the trace in a picture
_NEAR_M = 80.0  # the picture of a type shows what is within this distance of the event
_S_M = np.arange(0.0, 5000.0, 5.0)  # arc lengths of the points of a lane in a picture


def _seeds(text: str) -> range:
    first, _, last = text.rpartition("-")
    if not (found := range(int(first or 1), int(last) + 1)):
        raise ValueError(f"seeds:={text}: must be a number, or FIRST-LAST")
    return found


def drive(
    name: str, path: str, seed: int, car: Mapping[str, Any]
) -> tuple[Placement, DriveEvaluation]:
    """Drive a type on a map with a car, by the arguments of drive_result that describe it."""
    placed = of_map(path, name, seed)
    return placed, drive_result(
        map=path,
        sim_options={"street_scenario": name},
        seed=seed,
        longest_s=placed.limit_s,
        compiled=True,
        **car,
    )


def drive_row(name: str, path: str, seed: int, car: Mapping, driver: str) -> dict[str, Any]:
    """Drive a type in this process, and return its row of the results."""
    placed, result = drive(name, path, seed, car)
    trace = np.ascontiguousarray(result.rows, dtype="<f8").tobytes()
    return row_of(name, seed, driver, placed.limit_s, result.metrics, trace)


def drive_nodes(name: str, path: str, seed: int, options: SimpleNamespace) -> dict[str, Any]:
    """Drive a type with the nodes of a package through ROS, and return its row of the results."""
    report = Path(options.report).absolute().with_name(f"{name}_{seed}.json")
    arguments = {"map": path, "stack": options.stack, "workspace": options.workspace}
    arguments.update(seed=str(seed), camera="false", sim_options=f"{{street_scenario: {name}}}")
    arguments["referee_options"] = "{}"
    with nodes_drive(arguments, report_path=str(report)) as (drive, _):
        if not report.exists():
            log = drive.log_path
            raise ValueError(f"{name}, seed {seed}: the drive wrote no report; see {log}")
    metrics, trace = json.loads(report.read_text()), report.with_suffix(".csv").read_bytes()
    return row_of(name, seed, options.stack, of_map(path, name, seed).limit_s, metrics, trace)


def row_of(name: str, seed: int, driver: str, limit_s: float, metrics: dict, trace: bytes) -> dict:
    """Return a row of the results, with the success of Bench2Drive."""
    is_late = metrics["status"] == "aborted" or metrics["duration_s"] > limit_s
    status = "too_late" if is_late else metrics["status"]
    names = [infraction for infraction, count in metrics["infractions"].items() if count]
    names += ["off_lane"] if metrics["off_lane_percent"] > 0.0 else []
    kept = ("driving_score", "route_completion_percent", "duration_s")
    return {
        "type": name,
        "seed": seed,
        "driver": driver,
        "status": status,
        "success": status == "completed" and metrics["driving_score"] >= 100.0,
        **{key: metrics[key] for key in kept},
        "infractions": " ".join(names),
        "trace_sha256": hashlib.sha256(trace).hexdigest(),
    }


def page_of(name: str, path: str, seed: int, car: Mapping) -> str:
    """Drive a type, and return the page of the drive."""
    from sdc_sim.report.html_page import html_of  # Matplotlib is slow to import

    return html_of(drive(name, path, seed, car)[1])


def picture_of(name: str, path: str, seed: int, car: Mapping) -> dict[str, Any]:
    """Drive a type, and return its plan: lines and boxes in metres, with the event at (0, 0)."""
    placed, result = drive(name, path, seed, car)
    event_m, way_m = np.array(placed.event_m), placed.mission_m
    row = int(np.argmin(np.hypot(*(way_m - event_m).T)))
    dx, dy = way_m[min(row + 2, len(way_m) - 1)] - way_m[max(row - 2, 0)]
    yaw_rad = math.atan2(dy, dx)
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)

    def line(points_m: Any) -> list:
        places_m = (np.asarray(points_m)[:, :2] - event_m) @ [[c, s], [s, -c]]
        return places_m[np.abs(places_m).max(axis=1) < _NEAR_M].round(1).tolist()

    rows, scene = result.rows[::_SHOWN_TICKS], result.scene[OBSTACLES]
    nearest = rows[np.argmin(np.hypot(*(rows[:, 1:3] - event_m).T))]
    _, around = min(scene, key=lambda row: abs(row[0] - nearest[0]), default=(0.0, []))
    tracks: dict[int, list] = {}
    for _, bodies in scene:
        for number, *place_m in bodies:
            tracks.setdefault(number, []).append(place_m)
    lanes = load_network(path).driving
    bodies = [body for _, *body in around] + [[*nearest[1:4], 4.7, 2.0]]
    return {
        "lanes": [
            (line(lane.at(_S_M[lane.length_m + 5.0 > _S_M])), lane.width_m) for lane in lanes
        ],
        "route": line(way_m),
        "trace": line(rows[:, 1:3]),
        "tracks": list(map(line, tracks.values())),
        # The last box is our car.
        "boxes": [(line([body]), math.degrees(yaw_rad - body[2]), *body[3:]) for body in bodies],
    }


def scores(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return success [%] with Wilson's interval, and mean driving score of some drives."""
    good = sum(row["success"] for row in rows)
    mean = estimate([row["driving_score"] for row in rows])
    low, high = stats.binomtest(good, len(rows)).proportion_ci(method="wilson")
    return {
        "drives": len(rows),
        "successes": good,
        "success_percent": 100.0 * good / len(rows),
        "success_interval_percent": [100.0 * low, 100.0 * high],
        "driving_score": mean.mean,
        "driving_score_half_width": None if math.isnan(mean.half_width) else mean.half_width,
    }


def summary(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the scores of all drives, each type and each ability, and the broken types."""
    found: dict[str, Any] = {}
    abilities: dict[str, list] = {}
    broken = {}
    for name in dict.fromkeys(row["type"] for row in rows if row["driver"] != NAIVE):
        of_type = [row for row in rows if row["type"] == name]
        own = [row for row in of_type if row["driver"] != NAIVE]
        naive = [row for row in of_type if row["driver"] == NAIVE]
        found[name] = {**scores(own), "naive": scores(naive) if naive else None}
        found[name]["naive_ends"] = sorted({row["infractions"] or row["status"] for row in naive})
        percents = [scores(part)["success_percent"] for part in (own, naive) if part]
        passes = {percent > _PASSES_PERCENT for percent in percents}
        if naive and len(passes) == 1:
            broken[name] = "pass" if passes.pop() else "fail"
        for ability in types()[name]["abilities"]:
            abilities.setdefault(ability, []).extend(own)
    every = scores([row for row in rows if row["driver"] != NAIVE])
    by_ability = {name: scores(abilities[name]) for name in sorted(abilities)}
    return {**every, "abilities": by_ability, "types": found, "broken": broken}


def write(page: Path, rows: Sequence[Mapping], result: Mapping, **shown: Any) -> None:
    """Write results as JSON, drives as CSV, and the page."""
    text = json.dumps({**result, "rows": rows}, indent=1)
    page.with_suffix(".json").write_text(text + "\n", encoding="utf-8")
    write_csv(page.with_suffix(".csv"), rows)
    write_page(page, "scenarios.html.jinja", result=result, table=types(), **shown)


def _results(
    engine: DaskEngine, problems: list, things: str, function: Callable, drives: Iterable
) -> list:
    """Return what a function returns for each drive, and add what it raises to the problems."""
    tasks, found = {" ".join(map(str, call)): call for call in drives}, {}
    progress = SweepProgress(sys.stdout, len(tasks), 0, "scenarios", things)
    for outcome in engine.outcomes(function, tasks.items()):
        progress.add(bool(outcome.error))
        found[outcome.key] = outcome.result
        if outcome.error:
            problems.append(f"{outcome.key.split()[0]}: {outcome.error}")
    progress.close()
    return [found[key] for key in tasks if found.get(key)]


def run(options: SimpleNamespace) -> int:
    """List the types, or drive them; return the exit status. See drive_types for what it raises."""
    if not options.list:
        return drive_types(options)
    for name, row in types().items():
        print(f"{name}: {row['about']} ({', '.join(row['abilities']) or '-'})")
    return 0


def drive_types(options: SimpleNamespace) -> int:
    """Drive, write the results, and return the exit status.

    Raises:
        ValueError, ClusterError, OSError: the drives cannot start; the message is one line
    """
    page, table, towns = Path(options.report).absolute(), types(), town_seeds(options.map)
    names, seeds = options.type or list(table), towns or _seeds(options.seeds)
    is_drawn = options.map == RANDOM or towns
    paths = {seed: f"{RANDOM}:{seed}" if is_drawn else map_file(options.map) for seed in seeds}
    load_network(paths[seeds[0]])
    page.parent.mkdir(parents=True, exist_ok=True)
    is_stack, lacking = options.stack, "" if options.behaviour else "signs"
    car = {"lacking": lacking, "planner_options": {"score_function": options.score}}
    places = [(name, paths[seed], seed) for name in names for seed in seeds]
    others = [(name, paths[seed], seed) for name in names for seed in seeds[: options.naive]]
    problems: list[str] = []
    with DaskEngine(options.scheduler, cores()) as engine:
        engine.check(worker_problem, code_version(), [] if is_drawn else [paths[seeds[0]]])
        results = partial(_results, engine, problems)
        began_s = time.monotonic()
        own = () if is_stack else [(*place, car, OWN) for place in places]
        rows = [drive_nodes(*place, options) for place in places if is_stack]
        rows = rows or results("drives", drive_row, own)
        if not rows:
            raise ValueError(problems[0])
        driven = sorted(rows, key=lambda row: (row["success"], row["driving_score"]))[:_WORST]
        if options.behaviour:
            naive_drives = [
                (*place, {"lacking": table[place[0]]["naive"]}, NAIVE) for place in others
            ]
            rows += results("naive drives", drive_row, naive_drives)
        took_s, result = time.monotonic() - began_s, summary(rows)
        files = [page.with_name(f"{row['type']}_{row['seed']}.html") for row in driven if is_stack]
        shown = () if is_stack else [(row["type"], row["seed"]) for row in driven]
        pages = [file.read_text(encoding="utf-8") for file in files]
        worst = [(name, paths[seed], seed, car) for name, seed in shown]
        pages = pages or results("pages", page_of, worst)
        seed_of = {row["type"]: row["seed"] for row in rows[::-1] if row["driver"] != NAIVE}
        first = [(name, paths[seed_of[name]], seed_of[name], car) for name in result["types"]]
        pictures = dict(zip(result["types"], results("plans", picture_of, first)))
    write(page, rows, result, options=options, worst=list(zip(driven, pages)), pictures=pictures)
    print_result(result, problems)
    driven_s = sum(row["duration_s"] for row in rows)
    print(
        f"scenarios: {driven_s:.0f} s of driving in {took_s:.0f} s on {cores()} cores; see {page}"
    )
    last = "driving score {driving_score:.1f}, success {success_percent:.1f} %".format(**result)
    print(f"scenarios: {result['drives']} drives of {len(result['types'])} types, {last}")
    return 1 if problems or result["broken"] else 0


def print_result(result: Mapping[str, Any], problems: Sequence[str]) -> None:
    """Print a line for each type, each problem and each broken type."""
    for name, row in result["types"].items():
        count, score = f"{row['successes']} of {row['drives']}", row["driving_score"]
        naive = row["naive"] and "; naive {successes} of {drives}".format(**row["naive"])
        print(f"{name}: {count}, driving score {score:.1f}{naive or ''}")
    for problem in dict.fromkeys(problems):
        print(f"scenarios: {problem}")
    for name, word in result["broken"].items():
        print(f"scenarios: {name} is broken: our driver and its naive one both {word}")
