"""./workshop/check: report how far a student has come, and what is wrong."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Sequence

from sdc_common.processes import isolate_network
from sdc_experiments.commands import WordError, parse
from sdc_workshop import my_car, progress, quiz
from sdc_workshop.exam.answer import PASSED, Answer
from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import RegionError
from sdc_workshop.show import Show
from sdc_workshop.steps import StepError, chosen, hint_of
from sdc_workshop.workspace import (
    UPDATE,
    WorkspaceError,
    find,
    is_older,
    lab_near,
    lab_of,
    note_solution,
    solution_body,
    solve,
)

_POLL_S = 0.3
_NOT_WATCHED = (progress.NAME, f"{progress.NAME}.part", "__pycache__")


def check(folder: Path, steps: list, show: Show, json_path: str = "", seed: str = "") -> int:
    """Check some steps of a workspace, show the answers, and return the exit status.

    The answers are also written to the file `json_path`, if it has a name. The checks draw their
    arguments from the seed; "" is a new one.
    """
    student = Student(folder)
    with Stage(student, seed=seed) as stage:
        examination = Examination(student, stage)
        show.begin(folder, steps)
        answers = examination.judge(steps, show.step, on_begin=show.waits)
        end(folder, steps, answers, show)
    if json_path:
        found = {
            "answers": {step_id: asdict(answer) for step_id, answer in answers.items()},
            "report": examination.report,
        }
        Path(json_path).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 0 if all(answer.status == PASSED for answer in answers.values()) else 1


def end(folder: Path, steps: list, answers: dict, show: Show) -> None:
    """Keep the answers of a check, and show the end of it."""
    lab = steps[0].lab
    progress.keep(folder, answers)
    show.end(steps, answers, progress.statuses(folder, lab), progress.attempts(folder, lab))


def stamps(folder: Path) -> dict:
    """Return (time, permissions) of each file that saving or building changes, by its path.

    Folders are left out: keeping the answers changes the time of one.
    """
    found = [folder / "devel" / "setup.bash", *sorted((folder / "src").rglob("*"))]
    found += sorted((folder / "devel" / "lib").glob("python3*/dist-packages/*/msg/*.py"))
    times = {}
    for path in found:
        is_watched = path.name not in _NOT_WATCHED and not path.name.endswith(("~", ".pyc"))
        if is_watched and not path.is_dir():
            with contextlib.suppress(OSError):
                entry = path.stat()
                times[str(path)] = entry.st_mtime_ns, entry.st_mode
    return times


def watch(folder: Path, steps: list, show: Show) -> int:
    """Check up to the first wrong step whenever a file is saved; return the exit status.

    A step that was right is checked again only when its file has changed.
    """
    right: dict = {}
    with Stage(Student(folder)) as stage:
        while True:
            times = stamps(folder)
            stage.student = Student(folder)
            examination = Examination(stage.student, stage)
            unchanged = [
                step_id for step_id, (path, saved) in right.items() if times.get(path) == saved
            ]
            examination.answers.update((step_id, Answer(PASSED)) for step_id in unchanged)
            show.clear()
            show.begin(folder, steps)
            answers = examination.judge(steps, show.step, True, show.waits)
            end(folder, steps, answers, show)
            if all(answer.status == PASSED for answer in answers.values()):
                return 0
            for step in steps:
                path = str(folder / "src" / step.file) if step.file else ""
                if step.id in answers and answers[step.id].status == PASSED and path in times:
                    right[step.id] = path, times[path]
            print("\nWaiting for you to save a file; Ctrl-C ends.", flush=True)
            while stamps(folder) == times:
                time.sleep(_POLL_S)
            time.sleep(_POLL_S)  # editors write several files


def print_hints(steps: list) -> None:
    """Print both hints of each step."""
    for step in steps:
        known = hint_of(step.id)
        print(f"{step.id}: {step.title}")
        if step.file:
            print(f"In src/{step.place}.")
        print(f"\n{known.hint}\n{known.more}\n")


def apply_solution(folder: Path, steps: list) -> None:
    """Write the solution of steps into the workspace, and print it."""
    for step in steps:
        if step.file is None:
            print(f"{step.id}: this step writes no file. {hint_of(step.id).hint}\n")
            continue
        solve(folder, step)
        note_solution(folder, step)
        print(f"{step.id}: src/{step.place} is written:\n\n{solution_body(step)}")
    if any((step.file or "").endswith((".msg", "CMakeLists.txt", "package.xml")) for step in steps):
        print(
            "When all steps of this group are done: `catkin_make`, then `source devel/setup.bash`."
        )


def main(arguments: Sequence[str]) -> int:
    """Run the command; return 0 if all checked steps are right, 1 if not, 2 for bad words."""
    try:
        options = parse("workshop/check", arguments)
        place = Path(os.environ.get("PWD") or os.getcwd())
        if options.command.endswith("my-car"):
            return my_car.run(options.drives, place)
        if options.language:
            os.environ["LANGUAGE"] = options.language
        if options.command.endswith("quiz"):
            return quiz.run(options.lesson, options.seed, place)
        if options.hint or options.list:
            lab = lab_near(place)
            steps = chosen(options.hint or options.step, lab, optional=True)
            print_hints(steps if options.hint else [])
            for step in [] if options.hint else steps:
                print(f"{step.id:22} {step.title}")
            return 0
        folder = find(place)
        steps = chosen(options.solution or options.step, lab_of(folder))
        if is_older(folder):
            print(f"check: {folder} is of another version of the workshop: {UPDATE} updates it.")
        if options.solution:
            apply_solution(folder, steps)
            return 0
        isolate_network()
        if options.watch:
            return watch(folder, steps, Show(sys.stdout))
        return check(folder, steps, Show(sys.stdout), options.json, options.seed)
    except (WordError, WorkspaceError, StepError, RegionError, OSError, ImportError) as error:
        print(f"check: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    # A closed terminal and `timeout` end the check as Ctrl-C does, with all programs it started.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        print()
        sys.exit(130)
