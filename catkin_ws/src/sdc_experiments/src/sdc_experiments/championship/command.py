"""Many drives of one driver, and what all commands of ./championship share."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Iterator, Mapping, Sequence

import numpy as np

from sdc_common.configuration import package_folder
from sdc_experiments.championship.drive import drive_seed
from sdc_experiments.championship.driver_process import MAX_SOURCE, DriverServer
from sdc_experiments.championship.league import TABLE
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_experiments.sweep.progress import SweepProgress
from sdc_experiments.sweep.statistics import estimate

BASELINES: dict[str, dict[str, Any]] = TABLE["baselines"]
FAST = [name for name, row in BASELINES.items() if not row.get("slow")]
_DRIVES_A_TASK = 10
_STEERING = """class Driver:
    def __init__(self, mission):
        self.step = mission.default_car("{}").step
"""


def seeds_of(options: SimpleNamespace) -> list[str]:
    """Return the public seeds of `seeds`, or of `drives` without it."""
    text = getattr(options, "seeds", "") or f"1-{options.drives}"
    first, _, last = text.rpartition("-")
    found = [*map(str, range(int(first or last), int(last) + 1))]
    if not found:
        raise ValueError(f"seeds:={text}: there is no seed; write FIRST-LAST")
    return found


def source_of(path: Path) -> str:
    """Return a driver's file.

    Raises:
        ValueError: it is no file in Python, or too long
    """
    if path.stat().st_size > MAX_SOURCE:
        raise ValueError(f"{path}: has more than {MAX_SOURCE} bytes; compute the numbers in it")
    source = path.read_text(encoding="utf-8")
    try:
        compile(source, str(path), "exec")
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        place = getattr(error, "lineno", None) or 1
        text = getattr(error, "msg", str(error)) or "the expression is too long"
        raise ValueError(f"{path}, line {place}: {text}") from None
    return source


def baseline(name: str) -> str:
    """Return the file of a baseline."""
    row = BASELINES[name]
    if "file" in row:
        folder = Path(package_folder("sdc_experiments"), "drivers")
        return (folder / row["file"]).read_text(encoding="utf-8")
    return _STEERING.format(row["steering"])


def drive_seeds(
    source: str, league: str, seeds: Sequence[str], sandboxed: bool, late: Mapping[str, list]
) -> list[dict[str, Any]]:
    """Drive what some seeds draw, and return their rows; `late` are records to repeat."""
    with DriverServer(source, sandboxed) as server:
        return [drive_seed(server, league, seed, late.get(seed)) for seed in seeds]


def graded(
    engine: DaskEngine,
    entries: Mapping[str, str],
    league: str,
    seeds: Sequence[str],
    sandboxed: bool = True,
    late: Mapping[str, list] | None = None,
) -> Iterator[dict[str, Any]]:
    """Drive what seeds draw, and yield the result of each driver as soon as it is complete.

    A driver with a task that failed is reported, and has no result. `entries` are the files of the
    drivers by their names, and `late` the records of late steps to repeat by the seeds.
    """
    tasks: Iterator[tuple[str, tuple]] = (
        (f"{seeds[start]} {name}", (source, league, part, sandboxed, dict(late or {})))
        for name, source in entries.items()
        for start in range(0, len(seeds), _DRIVES_A_TASK)
        for part in [seeds[start : start + _DRIVES_A_TASK]]
    )
    rows: dict[str, dict[str, Any]] = {name: {} for name in entries}
    progress = SweepProgress(sys.stdout, len(entries) * len(seeds), 0, "championship")
    for outcome in engine.outcomes(drive_seeds, tasks):
        name = outcome.key.partition(" ")[2]
        if outcome.error and rows.pop(name, None) is not None:
            text = f"not judged: {outcome.error}; the same command tries again"
            print(f"championship: {name}: {text}", file=sys.stderr)
        if name not in rows:
            continue
        for row in outcome.result:
            progress.add(bool(row["problem"]))
            rows[name][row["seed"]] = row
        if len(rows[name]) == len(seeds):
            yield result_of(name, league, [rows[name][seed] for seed in seeds])
    progress.close()


def result_of(name: str, league: str, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return a driver's score with its interval, the means of its parts, and what went wrong."""
    score, parts = estimate([row["score"] for row in rows]), rows[0]["points"]
    good = {part: [row["values"][part] for row in rows if part in row["values"]] for part in parts}
    problems = {text for row in rows for text in (row["problem"], *row["refused"]) if text}
    return {
        "name": name,
        "league": league,
        "score": score.mean,
        "half_width": score.half_width,
        "points": {part: float(np.mean([row["points"][part] for row in rows])) for part in parts},
        "values": {part: float(np.mean(good[part])) if good[part] else None for part in parts},
        "completed": sum(row["status"] == "completed" for row in rows),
        "late_steps": sum(len(row["late"]) for row in rows),
        "step_p99_ms": max(row["step_p99_ms"] for row in rows),
        "problems": sorted(problems),
        "rows": rows,
    }


def worst_of(result: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of the worst drive."""
    return min(result["rows"], key=lambda row: row["score"])
