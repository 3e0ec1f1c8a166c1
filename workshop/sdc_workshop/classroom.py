"""./workshop/class DIR ...: one page with the progress of a class, written again and again."""

from __future__ import annotations

import json
import random
import sys
import time
from functools import lru_cache
from pathlib import Path
from statistics import median
from types import SimpleNamespace
from typing import Sequence

from sdc_experiments.commands import parse
from sdc_sim.report import templates
from sdc_sim.report.writer import complete
from sdc_workshop import progress
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.handed_in import names, submissions
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import package_of

# A student who was away for longer was not at a step all the time.
_LONGEST_MIN = 60.0
_PERIOD_S = 5
# Number of the best cars that the page shows.
_CARS = 5
_MOST_BYTES = 1_000_000


def workspace_in(folder: Path, lab: str) -> Path | None:
    """Return the workspace in a student's folder, or None."""
    package = f"src/{package_of(lab)}"
    try:
        return next((one for one in (folder, folder / "sdc_ws") if (one / package).is_dir()), None)
    except PermissionError:
        tell(f"{folder} cannot be read: let the student permit it, or start this command as root")
        return None


@lru_cache
def tell(text: str) -> None:
    """Print a line once, however often the page is written."""
    print(f"class: {text}", file=sys.stderr)


def minutes(stamps: dict) -> dict:
    """Return the minutes that a student took for each step that is right, by step id.

    They count from the step that was right before; for the first, from its first attempt. Steps
    that became right in one check share the time.
    """
    right: dict = {}
    for step_id, row in stamps.items():
        if "passed" in row:
            right.setdefault(row["passed"], []).append(step_id)
    found: dict = {}
    before = min((row["first"] for row in stamps.values()), default=0.0)
    for passed in sorted(right):
        taken = min((passed - before) / 60.0, _LONGEST_MIN)
        found.update(dict.fromkeys(right[passed], taken / len(right[passed])))
        before = passed
    return found


def student(workspace: Path, lab: str, now_s: float) -> dict:
    """Return a student's row of the page; raises ValueError where the kept file is damaged."""
    kept = workspace / "src" / package_of(lab) / progress.NAME
    # Students write this file: what is not a plain small one is not read.
    is_plain = kept.is_file() and kept.stat().st_size <= _MOST_BYTES
    if kept.is_symlink() or (kept.exists() and not is_plain):
        raise ValueError("it is not a file of ./workshop/check")
    try:
        statuses, stamps = progress.statuses(workspace, lab), progress.times(workspace, lab)
        attempts, taken = progress.attempts(workspace, lab), minutes(stamps)
        done = [step.id for step in load_steps(lab) if statuses.get(step.id) == PASSED]
        at = next((step for step in load_steps(lab) if step.id not in done), None)
        last_s = max((row.get("passed", row["first"]) for row in stamps.values()), default=None)
        return {
            "done": done,
            "at": at,
            "taken": taken,
            "attempts": {key: int(value) for key, value in attempts.items()},
            "waits": None if last_s is None else max(0, round((now_s - last_s) / 60.0)),
            "car": progress.best_car(workspace),
            "quizzes": {str(key): int(right) for key, right in progress.quizzes(workspace).items()},
        }
    except (TypeError, LookupError, AttributeError, ArithmeticError, RecursionError) as error:
        raise ValueError(f"it is damaged ({error!r})") from None


def pseudonyms(real: list, path: Path) -> dict:
    """Return "student N" for each name: the same as in the file, and new ones in random order."""
    known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else []
    new = [name for name in real if name not in known]
    random.SystemRandom().shuffle(new)
    if new:
        path.write_text(json.dumps(known + new), encoding="utf-8")
        path.chmod(0o600)
    return {name: f"student {number}" for number, name in enumerate(known + new, 1)}


def write_page(options: SimpleNamespace, now_s: float) -> int:
    """Write the page, and return the number of students."""
    rows, output = [], Path(options.output).absolute()
    named = names(submissions(map(Path, options.dir), output, options.lab))
    found = {name: workspace_in(folder, options.lab) for folder, name in named.items()}
    real = [name for name, workspace in found.items() if workspace]
    shown = dict(zip(real, real))
    if not options.names:
        shown = pseudonyms(real, output.with_suffix(".pseudonyms.json"))
    for name in real:
        try:
            rows.append({"name": shown[name], **student(found[name], options.lab, now_s)})
        except (ValueError, OSError) as error:
            tell(f"{shown[name]}: {progress.NAME} is left out: {error}")
    steps = []
    for step in load_steps(options.lab):
        taken = [row["taken"][step.id] for row in rows if step.id in row["taken"]]
        steps.append(
            {
                "step": step,
                "done": sum(step.id in row["done"] for row in rows),
                "here": [row["name"] for row in rows if row["at"] == step],
                "wrong": sum(row["attempts"].get(step.id, 0) for row in rows),
                "minutes": median(taken) if taken else None,
            }
        )
    slow = sorted((row["minutes"] for row in steps if row["minutes"]), reverse=True)[:5]
    template = templates(Path(__file__).parent, trim_blocks=True).get_template("classroom.html.j2")
    page = template.render(
        rows=sorted(rows, key=lambda row: (len(row["done"]), row["name"])),
        steps=steps,
        slow=slow,
        cars=sorted((-row["car"], row["name"]) for row in rows if row["car"])[:_CARS],
        every=0 if options.once else _PERIOD_S,
        time=time.strftime("%H:%M:%S", time.localtime(now_s)),
    )
    with complete(output) as part:  # A browser never reads half a page.
        part.write_text(page, encoding="utf-8")
    return len(rows)


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    try:
        options = parse("workshop/class", arguments)
        count, page = write_page(options, time.time()), Path(options.output).absolute()
        print(f"class: {count} students, see {page.as_uri()}", flush=True)
        while not options.once:
            time.sleep(_PERIOD_S)
            write_page(options, time.time())
    except KeyboardInterrupt:
        print()
    except (OSError, ValueError) as error:
        print(f"class: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
