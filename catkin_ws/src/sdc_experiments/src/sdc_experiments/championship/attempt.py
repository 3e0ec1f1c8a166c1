"""./championship new, try and baselines: one driver on public seeds."""

from __future__ import annotations

import contextlib
import json
import math
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Mapping, Sequence

from sdc_experiments.championship.command import (
    BASELINES,
    FAST,
    baseline,
    graded,
    result_of,
    seeds_of,
    source_of,
    worst_of,
)
from sdc_experiments.championship.drive import drive, drive_seed
from sdc_experiments.championship.driver_process import DriverServer, sandbox_problem
from sdc_experiments.championship.league import LEAGUES, TABLE, draw
from sdc_experiments.championship.stack import drive_stack
from sdc_experiments.commands import called
from sdc_experiments.sweep.dask_engine import DaskEngine, cores
from sdc_experiments.sweep.progress import SweepProgress
from sdc_experiments.sweep.statistics import estimate
from sdc_sim.report import templates

# Scores of the baselines by league, name and public seed.
STORED = Path(__file__).with_name("baselines.json")
_NEW = '''"""A driver for ./championship: pure pursuit (Coulter, CMU-RI-TR-92-01) with our car."""

from math import atan, atan2, hypot, sin


class Driver:
    def __init__(self, mission):  # what is known before the drive, such as mission.waypoints_m
        self.mission = mission

    def wheel_angle(self, path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps):
        ahead_m = path.place(x_m, y_m).s_m + 2.0 + 0.4 * speed_mps
        to_x_m, to_y_m = (b - a for a, b in zip((x_m, y_m), path.line.point_at(ahead_m)))
        angle = atan2(to_y_m, to_x_m) - yaw_rad
        return atan(2.0 * 2.87 * sin(angle) / hypot(to_x_m, to_y_m))
'''


def new(options: SimpleNamespace) -> int:
    """Write a driver into a new file."""
    path = options.file
    if not path.endswith(".py"):
        raise ValueError(f"new: name one file, such as {called('championship')} new my_driver.py")
    try:
        with open(path, "x", encoding="utf-8") as file:
            file.write(_NEW)
    except FileExistsError:
        raise ValueError(f"{path}: exists already; name another file") from None
    print(f"championship: wrote {path}; drive it with {called('championship')} try {path}")
    return 0


def stored(league: str, seeds: Sequence[str]) -> dict[str, float]:
    """Return the mean score of each baseline, on the same seeds where all are stored."""
    found = {}
    for name, scores in json.loads(STORED.read_text(encoding="utf-8")).get(league, {}).items():
        same = [scores[seed] for seed in seeds if seed in scores]
        found[name] = estimate(same if len(same) == len(seeds) else [*scores.values()]).mean
    return found


def _sandboxed(options: SimpleNamespace) -> bool:
    """Return whether to drive in the sandbox; without a choice of the user, where there is one."""
    problem = "" if "sandbox" in options.texts else sandbox_problem()
    if problem:
        print(f"championship: no sandbox: {problem}; drive only files that you trust", flush=True)
    return options.sandbox and not problem


def run(options: SimpleNamespace) -> int:
    """Drive a driver on public seeds, print its score and write the page."""
    stack = options.stack
    if bool(stack) == bool(options.file):
        raise ValueError(f"try: name one driver, such as {called('championship')} try my_driver.py")
    path, seeds, league = Path(stack or options.file), seeds_of(options), options.league
    source = "" if stack else source_of(path)
    late: Mapping[str, list] = {}
    if options.replay:
        earlier = json.loads(Path(options.replay).read_text(encoding="utf-8"))
        late = {row["seed"]: row["late"] for row in earlier["rows"]}
        seeds, league = list(late), earlier["league"]
    sandboxed = not stack and _sandboxed(options)
    with contextlib.ExitStack() as opened:
        if stack:
            nodes = stack, options.workspace, league
            drivers: dict[str, Any] = {seed: drive_stack(*nodes, seed) for seed in seeds}
            rows = [drive_seed(drivers[seed], league, seed) for seed in seeds]
            result = result_of(path.stem, league, rows)
        else:
            with DaskEngine(options.scheduler, cores()) as engine:
                entries = {path.stem: source}
                result, *_ = *graded(engine, entries, league, seeds, sandboxed, late), {}
            if not result:
                return 1
            server = opened.enter_context(DriverServer(source, sandboxed))
            drivers = dict.fromkeys(seeds, server)
        worst = worst_of(result)
        progress = SweepProgress(sys.stdout, 1, 0, "championship", "pages")
        shown = page_of(drivers[worst["seed"]], league, worst)
        progress.add()
        progress.close()
    others = stored(league, seeds)
    table = sorted([*others.items(), (path.stem, result["score"])], key=lambda entry: -entry[1])
    folder = Path(options.report)
    folder.mkdir(parents=True, exist_ok=True)
    record, page = (folder / f"{path.stem}{ending}" for ending in (".json", ".html"))
    write_page(page, result=result, table=table, worst=worst, shown=shown)
    print(*lines(result), sep="\n")
    print(
        f"championship: see {page}, "
        + write_record(record, {**result, "baselines": others}, path.name, source)
    )
    rank = 1 + sum(score > result["score"] for score in others.values())
    print(f"{last_line(result)}, rank {rank} of {len(others) + 1}")
    return 1 if result["problems"] else 0


def write_record(record: Path, result: Mapping[str, Any], name: str, source: str) -> str:
    """Write the record of a driver, and its file if it has one; return what names both."""
    record.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    if not source:
        return f"the record {record}"
    file = record.with_name(name)
    file.write_text(source, encoding="utf-8")
    return f"the record {record}; the file to submit is {file}"


def lines(result: Mapping[str, Any]) -> list[str]:
    """Return a line for each part of a score, and for what went wrong."""
    league = result["league"]
    found = [
        f"{league}: {name} {'-' if value is None else f'{value:.3f}'}: "
        f"{result['points'][name]:.1f} of {LEAGUES[league]['score'][name][0]} points"
        for name, value in result["values"].items()
    ]
    count = f"{result['completed']} drives completed, {result['late_steps']} steps late"
    found.append(f"{league}: {count}, 99 of 100 steps within {result['step_p99_ms']:.2f} ms")
    return [*found, *(f"championship: {result['name']}: {text}" for text in result["problems"])]


def last_line(result: Mapping[str, Any]) -> str:
    """Return the line with the score."""
    width = result["half_width"]
    interval = "" if math.isnan(width) else f" (+- {width:.1f})"
    return f"championship: {result['league']}: score {result['score']:.1f} of 100{interval}"


def page_of(server: DriverServer, league: str, row: Mapping[str, Any]) -> str:
    """Repeat a drive, and return its page with plots and the slider."""
    from sdc_sim.report.html_page import html_of  # Matplotlib is slow to import

    result = drive(server, draw(league, row["seed"]), row["late"])[1]
    return html_of(result) if len(result.rows) >= 10 else ""


def write_page(page: Path, template: str = "championship.html.jinja", **shown: Any) -> None:
    """Write a page from a template of this package."""
    shown.update(leagues=LEAGUES, titles=BASELINES, names=TABLE["parts"])
    found = templates(Path(__file__).parents[1] / "templates").get_template(template)
    page.write_text(found.render(shown), encoding="utf-8")


def drive_baselines(options: SimpleNamespace) -> int:
    """Drive baselines on public seeds, and store their scores."""
    league, seeds = options.league, seeds_of(options)
    found = json.loads(STORED.read_text(encoding="utf-8"))
    entries = {name: baseline(name) for name in options.name or FAST}
    failed = False
    with DaskEngine(options.scheduler, cores()) as engine:
        for result in graded(engine, entries, league, seeds):
            failed = failed or bool(result["problems"])
            if not result["problems"]:  # such as a solver that is not installed
                scores = {row["seed"]: round(row["score"], 6) for row in result["rows"]}
                found.setdefault(league, {})[result["name"]] = scores
                text = json.dumps(found, separators=(",", ":"))
                STORED.write_text(text + "\n", encoding="utf-8")
            print("\n".join([*lines(result), f"{last_line(result)}, {result['name']}"]), flush=True)
    return int(failed)
