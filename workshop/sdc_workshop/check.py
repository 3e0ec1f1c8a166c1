"""./workshop/check: says how far a student has come, and what is wrong."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import time
from pathlib import Path

from sdc_workshop.exam.answer import PASSED, Answer
from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.hints import hint_of
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import RegionError
from sdc_workshop.show import Show
from sdc_workshop.steps import StepError, load_steps
from sdc_workshop.workspace import WorkspaceError, find, solution_body, solve

_LOOK_EVERY_S = 0.3

DESCRIPTION = """Checks your workspace, from anywhere inside of it. Without a STEP it goes through all steps in their order and explains
the first that is not right; with STEPs it checks just those. A STEP is an id such as camera-3, or the beginning of several: camera."""


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(prog="./workshop/check", description=DESCRIPTION)
    parser.add_argument("steps", nargs="*", metavar="STEP")
    parser.add_argument(
        "--watch", action="store_true", help="check again whenever a file is saved, until Ctrl-C"
    )
    parser.add_argument("--hint", metavar="STEP", help="say more about a step, and check nothing")
    parser.add_argument(
        "--solution", metavar="STEP", help="write the solution of a step into the workspace"
    )
    parser.add_argument("--list", action="store_true", help="list all steps, and check nothing")
    parser.add_argument(
        "--json", metavar="FILE", help="write all answers into a file, too, for programs"
    )
    return parser.parse_args(arguments)


def chosen(names: list) -> list:
    """The steps that are meant, in their order. Raises StepError."""
    steps = load_steps()
    meant = set()
    for name in names:
        found = [step.id for step in steps if step.id == name] or [
            step.id for step in steps if step.id.startswith(name.rstrip("-") + "-")
        ]
        if not found:
            near = [step.id for step in steps if step.id[:3] == name[:3]] or [
                step.id for step in steps
            ]
            raise StepError(f"there is no step '{name}'; there are {', '.join(near)}")
        meant.update(found)
    return [step for step in steps if not names or step.id in meant]


def one(name: str):
    """The step of this id. Raises StepError."""
    found = chosen([name])
    if len(found) > 1:
        raise StepError(
            f"'{name}' are several steps: {', '.join(step.id for step in found)}; name one"
        )
    return found[0]


def check(folder: Path, steps: list, show: Show, json_path: str | None = None) -> int:
    """Check some steps and say how they are; returns the exit status."""
    student = Student(folder)
    with Stage(student) as stage:
        examination = Examination(student, stage)
        everything = len(steps) == len(load_steps())
        show.begin(folder, steps)
        answers = examination.judge(steps, show.step)
        show.end(steps, answers, everything)
        if json_path is not None:
            Path(json_path).write_text(
                json.dumps(
                    {
                        "answers": {
                            step_id: answer.as_dict() for step_id, answer in answers.items()
                        },
                        "report": examination.report,
                    },
                    indent=1,
                )
                + "\n",
                encoding="utf-8",
            )
    return 0 if all(answer.status == PASSED for answer in answers.values()) else 1


def stamp(folder: Path) -> tuple:
    """(path, time and permissions) of all that changes when a file is saved, or when the workspace is built."""
    found = [folder / "devel" / "setup.bash", *sorted((folder / "src").rglob("*"))]
    found += sorted((folder / "devel" / "lib").glob("python3*/dist-packages/*/msg/*.py"))
    times = []
    for path in found:
        if path.suffix != ".pyc" and path.name != "__pycache__" and not path.name.endswith("~"):
            try:
                entry = path.stat()
                times.append((str(path), (entry.st_mtime_ns, entry.st_mode)))
            except OSError:
                continue
    return tuple(times)


def watch(folder: Path, steps: list, show: Show) -> int:
    """Check again and again, up to the first step that is not right, until all are or until Ctrl-C. What was right is looked at again
    only when its file has changed."""
    right = {}
    with Stage(Student(folder)) as stage:
        while True:
            seen = stamp(folder)
            stage.student = Student(folder)
            examination = Examination(stage.student, stage)
            times = dict(seen)
            unchanged = [
                step_id for step_id, (path, saved) in right.items() if times.get(path) == saved
            ]
            examination.answers.update((step_id, Answer(PASSED)) for step_id in unchanged)
            show.clear()
            show.begin(folder, steps)
            answers = examination.judge(steps, show.step, stop_at_first=True)
            show.end(steps, answers, len(steps) == len(load_steps()))
            if all(answer.status == PASSED for answer in answers.values()):
                return 0
            for step in steps:
                path = str(folder / "src" / step.file) if step.file else ""
                if step.id in answers and answers[step.id].status == PASSED and path in times:
                    right[step.id] = path, times[path]
            print("\nWaiting for you to save a file; Ctrl-C ends.", flush=True)
            while stamp(folder) == seen:
                time.sleep(_LOOK_EVERY_S)
            time.sleep(_LOOK_EVERY_S)  # editors write several files


def say_more(name: str) -> int:
    """Print all that hints.yaml knows about a step."""
    step = one(name)
    known = hint_of(step.id)
    print(f"{step.id}: {step.title}")
    if step.file:
        print(f"In src/{step.place}.")
    print(f"\n{known.hint}\n{known.more}")
    return 0


def apply_solution(folder: Path, name: str) -> int:
    """Write the solution of a step into the workspace, and show it."""
    step = one(name)
    if step.file is None:
        print(f"{step.id}: there is nothing to write in this step. {hint_of(step.id).hint}")
        return 0
    solve(folder, step)
    print(f"{step.id}: src/{step.place} is written:\n")
    print(solution_body(step), end="")
    if step.file.endswith((".msg", "CMakeLists.txt", "package.xml")):
        print(
            "\nNow `catkin_make`, and `source devel/setup.bash`, when the steps of this group are done."
        )
    return 0


def main(arguments) -> int:
    """Returns the exit status: 0 when all that was checked is right, 1 when not, 2 for a wrong command line."""
    options = parse(arguments)
    try:
        if options.hint:
            return say_more(options.hint)
        steps = chosen(options.steps)
        if options.list:
            for step in steps:
                print(f"{step.id:22} {step.title}")
            return 0
        folder = find(Path(os.environ.get("PWD") or os.getcwd()))
        if options.solution:
            return apply_solution(folder, options.solution)
        if options.watch:
            return watch(folder, steps, Show(sys.stdout))
        return check(folder, steps, Show(sys.stdout), options.json)
    except (WorkspaceError, StepError, RegionError, OSError) as error:
        print(f"check: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    # A terminal that is closed, or a `timeout`, ends it as Ctrl-C does: with all that it started.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        print()
        sys.exit(130)
