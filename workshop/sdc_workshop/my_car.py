"""./workshop/check my-car: a driver of one's own on public seeds of the championship."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from statistics import mean

from sdc_workshop import progress
from sdc_workshop.workspace import PROJECT, WorkspaceError, find

# In the folder of a workspace; `./workshop/grade --championship` takes it, too.
DRIVER = "driver.py"
# The league of traffic needs a planner for streets, which the car of the workshop is not.
LEAGUES = ("control", "driving")


def run(drives: int, place: Path) -> int:
    """Drive the driver of a workspace, print its score and place, and keep the best score.

    In each league it drives on the seeds 1, 2, 3, ... Return 0 when no drive had a problem. After a
    league in which each drive has one, it stops.

    Raises:
        WorkspaceError: there is no workspace, or no driver in it
    """
    folder = find(place)
    driver = folder / DRIVER
    if not driver.is_file():
        new = f"{PROJECT}/championship new {DRIVER}"
        raise WorkspaceError(f"{driver} does not exist; in that folder, `{new}` writes one")
    results, status = {}, 0
    for league in LEAGUES:
        report = folder / "report" / "my-car" / league
        record = report / f"{driver.stem}.json"
        record.unlink(missing_ok=True)
        words = [f"league:={league}", f"drives:={drives}", f"report:={report}"]
        done = subprocess.run([PROJECT / "championship", "try", driver, *words], check=False)
        if not record.is_file():
            return done.returncode
        status = status or done.returncode
        result = json.loads(record.read_text(encoding="utf-8"))
        problems = [row["problem"] for row in result["rows"]]
        if all(problems):
            print(f"\nmy-car: no drive worked: {problems[0]}")
            return done.returncode
        results[record.with_suffix(".html")] = result
    score = mean(result["score"] for result in results.values())
    others = [result["baselines"] for result in results.values()]
    names = set.intersection(*map(set, others))
    better = [name for name in names if mean(found[name] for found in others) > score]
    parts = ", ".join(f"{result['league']} {result['score']:.1f}" for result in results.values())
    page = min(results, key=lambda path: min(row["score"] for row in results[path]["rows"]))
    print(f"\nmy-car: {score:.1f} of 100 ({parts})")
    place_text = f"place {1 + len(better)} of {1 + len(names)}"
    print(f"my-car: {place_text}, among the baselines of both leagues")
    print(f"my-car: your best is {progress.keep_best_car(folder, score):.1f}")
    print(f"my-car: the worst drive: {page.as_uri()}")
    return status
