"""./workshop/grade DIR ...: grade students' workspaces and write a summary."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import re
import secrets
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Iterator, Sequence

from sdc_common.validation import DocumentError
from sdc_experiments.commands import WordError, parse
from sdc_experiments.sandbox import SandboxError, user_id
from sdc_experiments.sweep.dask_engine import ClusterError
from sdc_sim.report.writer import write_json
from sdc_workshop.exam.limits import control_groups, has_share
from sdc_workshop.exam.sandbox import require
from sdc_workshop.grading.cluster import grade_on_cluster
from sdc_workshop.grading.copies import Copy, copies
from sdc_workshop.grading.grading import Conditions, Grade, grade
from sdc_workshop.grading.handed_in import HandedInError, names, submissions
from sdc_workshop.grading.record import printable, write_table
from sdc_workshop.grading.rubric import PACKAGED, load_rubric
from sdc_workshop.grading.summary import cells, ranked, write_csv, write_lms, write_pages
from sdc_workshop.my_car import DRIVER
from sdc_workshop.steps import load_steps
from sdc_workshop.student_file import MAX_BYTES
from sdc_workshop.workspace import PROJECT

_SETTINGS = "grading.json"
# Where the driver of a student's own car is, in what was handed in.
_DRIVERS = (DRIVER, f"sdc_ws/{DRIVER}")
# No student's folder has the name of a file of the summary.
FILES = (_SETTINGS, "grades.csv", "grades.html", "moodle.csv", "canvas.csv", "copies.csv")


def main(arguments: Sequence[str]) -> int:
    """Run the command; return 0 when all folders could be graded."""
    try:
        options = parse("workshop/grade", arguments)
        grades = grade_class(options, Path(options.output).absolute())
    except (ClusterError, DocumentError, HandedInError, SandboxError, WordError) as error:
        print(f"grade: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        fix = "name another folder with --output"
        print(f"grade: {error.filename}: {error.strerror}; {fix}", file=sys.stderr)
        return 1
    return 0 if not any(found.note or found.contained for found in grades) else 1


def grade_class(options: SimpleNamespace, output: Path) -> list:
    """Grade all students, write the summary into a folder, and return the grades."""
    named = names(submissions(map(Path, options.dir), output, options.lab), FILES)
    for folder in named:
        if output == folder or folder in output.parents:
            raise HandedInError(
                f"{output} is in {folder}, a student's folder; name another one with --output"
            )
    rubric = load_rubric(Path(options.rubric or PACKAGED), named.values())
    if rubric["weights"]["my_car"] and not options.championship:
        raise HandedInError(
            f"{options.rubric}: 'weights.my_car' needs the scores of a round; "
            "add --championship with a number of drives, or set it to 0"
        )
    if not output.exists():
        output.mkdir(mode=0o700, parents=True)  # other users do not read the marks
    seed = class_seed(output, options.seed)
    jobs = []
    for number, (folder, name) in enumerate(named.items()):
        user = None if options.no_sandbox else user_id(number)
        jobs.append((name, folder, Conditions(options.limit, user, lab=options.lab, seed=seed)))
    if options.scheduler:
        found = grade_on_cluster(options.scheduler, jobs, output, not options.no_sandbox)
    else:
        found = grade_here(jobs, output, options)
    total = len(load_steps(options.lab))
    grades = []
    with contextlib.closing(found):
        for one in found:
            grades.append(shown(one, rubric))
            print(line(grades[-1], total), flush=True)
    if options.championship:
        add_championship(grades, output, options.championship)
    rows = ranked(grades, rubric)
    pairs = copies({found.name: found.tokens for found in grades}, options.lab)
    # First the pages: the tables contain what is wrong with a page.
    write_pages(output, rows, pairs, options.lab)
    write_csv(output / "grades.csv", rows, options.lab)
    write_lms(output, rows, rubric)
    write_table(output / "copies.csv", Copy._fields, (pair._asdict() for pair in pairs))
    print(f"grade: {len(grades)} students, see {output / 'grades.html'} and grades.csv")
    return grades


def shown(found: Grade, rubric: dict) -> Grade:
    """Return a grade that the tables can show: without its results where these are strange."""
    try:
        line(found, 0)
        cells(ranked([found], rubric)[0])
    except Exception as error:  # noqa: BLE001  without a sandbox, a student writes the results
        note = printable(f"the results cannot be read: {type(error).__name__}: {error}")
        return Grade(found.name, found.folder, note=note, lab=found.lab)
    return found


def add_championship(grades: list, output: Path, drives: int) -> None:
    """Hold a round of the championship with the driver.py of each folder, and add the scores."""
    folder = output / "championship"
    folder.mkdir(exist_ok=True)
    for left in folder.glob("*.py"):
        left.unlink()  # of an earlier grade
    names: dict = {}
    for found in grades:
        paths = [Path(found.folder, place) for place in _DRIVERS]
        path = next((file for file in paths if file.is_symlink() or file.is_file()), paths[0])
        if any(place.is_symlink() for place in (path, path.parent, found.folder)):
            found.contained.append(f"the link {printable(str(path))} is not followed")
        elif path.is_file():
            # The name of a page; "index" is that of the round itself.
            name = re.sub(r"[^\w-]|^-", "_", found.name)[:50]
            while name in {"index", *names}:
                name += "_"
            names[name] = found
            with path.open("rb") as file:  # a longer file is refused by the round
                (folder / f"{name}.py").write_bytes(file.read(MAX_BYTES))
    command = [PROJECT / "championship", "round", folder, f"drives:={drives}", "reveal:=false"]
    subprocess.run([*command, "baselines:=false"], check=False)
    for name, found in names.items():
        try:
            path = folder / "results" / f"{name}.json"
            result = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            found.note = "; ".join(filter(None, (found.note, "the championship has no result")))
        else:
            found.championship = f"{result['score']:.1f}"
            found.contained += result["problems"]


def class_seed(output: Path, given: int | None) -> int:
    """Return the secret seed of a class, which is written at the first run into a folder."""
    path = output / _SETTINGS
    if given is None and path.is_file():
        return int(json.loads(path.read_text(encoding="utf-8"))["seed"])
    seed = secrets.randbits(63) if given is None else given
    write_json(path, {"seed": seed}, 0o600)
    return seed


def grade_here(jobs: list, output: Path, options: SimpleNamespace) -> Iterator[Grade]:
    """Grade workspaces on this machine and yield each grade as soon as it is known.

    Raises:
        SandboxError: there is no sandbox on this machine
    """
    if not options.no_sandbox:
        require()
    stop = threading.Event()
    waiting: list = []
    # A check waits for its nodes about a third of its time.
    cores = sorted(os.sched_getaffinity(0))
    count, sets = options.jobs or len(cores) + 1, [cores]
    with control_groups() as (group, _):
        is_shared = has_share(group)
    if not is_shared and not options.no_sandbox:
        # Without control groups, each student has cores that the programs of no other one use.
        count = min(count, len(cores), len(jobs)) or 1
        sets = [cores[number::count] for number in range(count)]
    free = itertools.cycle(sets)
    with ThreadPoolExecutor(count, "grade", lambda: os.sched_setaffinity(0, next(free))) as pool:
        try:
            for name, folder, conditions in jobs:
                conditions = replace(conditions, stopped=stop.is_set)
                waiting.append(pool.submit(grade, name, folder, output / name, conditions))
            for done in as_completed(waiting):
                try:
                    found = done.result()
                except Exception as error:  # noqa: BLE001  the others are graded all the same
                    name, folder, _ = jobs[waiting.index(done)]
                    note = printable(f"could not be graded: {type(error).__name__}: {error}")
                    found = Grade(name, folder, note=note, lab=options.lab)
                yield found
        finally:
            stop.set()
            for job in waiting:
                job.cancel()


def line(found: Grade, total: int) -> str:
    """Return one line about a student."""
    drive = (
        f"driving score {found.score:.1f} ({found.report['status']})"
        if found.report
        else "no drive"
    )
    if found.unknown:
        drive += f", unknown route {found.unknown_score:.1f} ({found.unknown['status']})"
    after = f"; next: {found.first_open}" if found.first_open else ""
    note = f"; {found.note}" if found.note else ""
    contained = f"; contained: {'; '.join(found.contained)}" if found.contained else ""
    done = f"{found.steps_done} of {total} steps"
    return f"grade: {found.name}: {done}, {drive}{after}{note}{contained}"


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
