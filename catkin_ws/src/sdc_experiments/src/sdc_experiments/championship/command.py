"""Command lines of ./championship, and many drives of one driver."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any, Iterable, Mapping, Sequence

import numpy as np
import rospkg

from sdc_common.validation import suggestion
from sdc_experiments.championship.drive import drive_seed
from sdc_experiments.championship.driver_process import MAX_SOURCE, DriverServer
from sdc_experiments.championship.league import LEAGUES, TABLE, streets_of
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_experiments.sweep.progress import SweepProgress
from sdc_experiments.sweep.statistics import estimate

BASELINES: dict[str, dict[str, str]] = TABLE["baselines"]
_DRIVES_A_TASK = 10
_STEERING = """class Driver:
    def __init__(self, mission):
        self.step = mission.default_car("{}").step
"""


def options_of(
    arguments: Sequence[str], known: Mapping[str, str]
) -> tuple[dict[str, str], list[str]]:
    """Return the options of a command line, with defaults, and its other words.

    Raises:
        ValueError: an argument is not valid; the message is one line
    """
    options, words, left = dict(known), [], iter(arguments)
    for word in left:
        word = f"{word[2:]}:={next(left, '')}" if word.startswith("--") else word
        name, is_option, value = word.partition(":=")
        if is_option and name not in known:
            raise ValueError(f"unknown argument '{word}'; {suggestion(name, known, 'see --help')}")
        if is_option:
            options[name] = value
        else:
            words.append(word)
    if options.get("league", "control") not in LEAGUES:
        fix = suggestion(options["league"], LEAGUES, f"use one of {', '.join(LEAGUES)}")
        raise ValueError(f"league:={options['league']}: unknown league; {fix}")
    return options, words


def seeds_of(options: Mapping[str, str]) -> list[str]:
    """Return the public seeds of `drives` or `seeds`."""
    text = options.get("seeds") or f"1-{options['drives']}"
    if not re.fullmatch(r"(\d{1,9}-)?\d{1,9}", text):
        raise ValueError(f"seeds:={text}: must be a number, or FIRST-LAST")
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
    source = path.read_text(encoding="utf-8")
    if len(source.encode()) > MAX_SOURCE:
        raise ValueError(f"{path}: has more than {MAX_SOURCE} bytes; compute the numbers in it")
    try:
        compile(source, str(path), "exec")
    except (SyntaxError, ValueError) as error:
        place = getattr(error, "lineno", None) or 1
        raise ValueError(f"{path}, line {place}: {getattr(error, 'msg', error)}") from None
    return source


def baseline(name: str) -> str:
    """Return the file of a baseline."""
    row = BASELINES[name]
    if "file" in row:
        folder = Path(rospkg.RosPack().get_path("sdc_experiments"), "drivers")
        return (folder / row["file"]).read_text(encoding="utf-8")
    return _STEERING.format(row["steering"])


def drive_seeds(
    source: str, league: str, seeds: Sequence[str], sandboxed: bool, late: Mapping[str, list]
) -> list[dict[str, Any]]:
    """Drive what some seeds draw, and return their rows; `late` are records to repeat."""
    with DriverServer(source, sandboxed, streets_of(league)) as server:
        return [drive_seed(server, league, seed, late.get(seed)) for seed in seeds]


def parts_of(seeds: Sequence[str]) -> list[Sequence[str]]:
    """Return seeds in groups, each for one task."""
    return [seeds[at : at + _DRIVES_A_TASK] for at in range(0, len(seeds), _DRIVES_A_TASK)]


def drive_many(
    engine: DaskEngine,
    source: str,
    league: str,
    seeds: Sequence[str],
    sandboxed: bool = True,
    late: Mapping[str, list] | None = None,
) -> list[dict[str, Any]]:
    """Drive what seeds draw on a cluster, and return their rows in the order of the seeds.

    Raises:
        ValueError: a task failed
    """
    given = sandboxed, dict(late or {})
    tasks = ((part[0], (source, league, part, *given)) for part in parts_of(seeds))
    progress, found = SweepProgress(sys.stdout, len(seeds), 0, "championship"), {}
    for outcome in engine.outcomes(drive_seeds, tasks):
        if outcome.error:
            raise ValueError(outcome.error)
        for row in outcome.result:
            progress.add(bool(row["problem"]))
            found[row["seed"]] = row
    progress.close()
    return [found[seed] for seed in seeds]


def summary(rows: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the mean score with its interval, the mean of each part, and what went wrong."""
    rows = list(rows)
    score, names = estimate([row["score"] for row in rows]), rows[0]["points"]
    good = {one: [row["values"][one] for row in rows if one in row["values"]] for one in names}
    problems = {text for row in rows for text in (row["problem"], *row["refused"]) if text}
    return {
        "score": score.mean,
        "half_width": score.half_width,
        "points": {one: float(np.mean([row["points"][one] for row in rows])) for one in names},
        "values": {one: float(np.mean(good[one])) if good[one] else None for one in names},
        "completed": sum(row["status"] == "completed" for row in rows),
        "late_steps": sum(len(row["late"]) for row in rows),
        "step_p99_ms": max(row["step_p99_ms"] for row in rows),
        "problems": sorted(problems),
    }
