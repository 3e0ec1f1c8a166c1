"""./workshop/grade DIR ...: grade students' workspaces and write a summary."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Iterator, Sequence

from sdc_experiments.sweep.dask_engine import ClusterError
from sdc_workshop.exam.sandbox import SandboxError, require, user_id
from sdc_workshop.grading.cluster import grade_on_cluster
from sdc_workshop.grading.copying import is_workspace
from sdc_workshop.grading.grading import Conditions, Grade, grade
from sdc_workshop.grading.summary import leaderboard, write_csv, write_html
from sdc_workshop.steps import LABS, WORKSHOP, load_steps

DESCRIPTION = """Check every student's workspace, each with its own ROS master and time limit,
without writing into it. A DIR is a workspace, or a folder that contains workspaces. The summary
(grades.csv and grades.html) and each student's logs and report are written into one folder."""


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(prog="./workshop/grade", description=DESCRIPTION)
    parser.add_argument("folders", nargs="+", metavar="DIR", type=Path)
    parser.add_argument(
        "--lab",
        choices=sorted(LABS),
        default=WORKSHOP,
        help="grade a lab instead of the workshop",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("grades"),
        metavar="FOLDER",
        help="folder of the summary (default: grades)",
    )
    parser.add_argument(
        "--limit",
        type=float,
        default=600.0,
        metavar="SECONDS",
        help="time limit for one student, with build and drive (default: 600)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=(os.cpu_count() or 1) + 1,  # a check waits for its nodes about a third of its time
        metavar="N",
        help="students that are graded at the same time (default: number of cores + 1)",
    )
    parser.add_argument(
        "--scheduler",
        default="",
        metavar="tcp://HOST:PORT",
        help="grade on this Dask cluster, whose workers see the same folders (default: here)",
    )
    parser.add_argument(
        "--no-sandbox",
        action="store_true",
        help="run the students' programs with your permissions, on your network and your files",
    )
    options = parser.parse_args(arguments)
    if options.limit <= 0.0 or options.jobs < 1:
        parser.error("--limit and --jobs must be positive")
    return options


def workspaces(folders: list, lab: str = WORKSHOP) -> list:
    """Return the workspaces in some folders, as absolute paths without duplicates.

    A folder without a workspace is returned, too: its row of the summary reports it.
    """
    found = []
    for folder in folders:
        folder = folder.absolute()
        inside = (
            []
            if is_workspace(folder, lab) or not folder.is_dir()
            else sorted(path for path in folder.iterdir() if is_workspace(path, lab))
        )
        found.extend(inside or [folder])
    return list(dict.fromkeys(Path(os.path.normpath(path)) for path in found))


def names(folders: list) -> dict:
    """Return a unique name for each folder: the last parts of its path, as few as possible."""
    found = {}
    for folder in folders:
        count = 1
        while (
            count < len(folder.parts)
            and sum(other.parts[-count:] == folder.parts[-count:] for other in folders) > 1
        ):
            count += 1
        found[folder] = "_".join(part for part in folder.parts[-count:] if part != "/") or "root"
    return found


def main(arguments: Sequence[str]) -> int:
    """Run the command; return 0 when all folders could be graded."""
    options = parse(arguments)
    output = options.output.absolute()
    named = names(workspaces(options.folders, options.lab))
    for folder in named:
        if output == folder or folder in output.parents:
            print(
                f"grade: {output} is in {folder}, a student's folder; "
                "name another one with --output",
                file=sys.stderr,
            )
            return 2
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(
            f"grade: {output}: {error.strerror}; name another folder with --output", file=sys.stderr
        )
        return 1
    jobs = []
    for number, (folder, name) in enumerate(named.items()):
        user = None if options.no_sandbox else user_id(number)
        jobs.append((name, folder, Conditions(options.limit, user, lab=options.lab)))
    if options.scheduler:
        found = grade_on_cluster(options.scheduler, jobs, output, not options.no_sandbox)
    else:
        found = grade_here(jobs, output, options)
    total = len(load_steps(options.lab))
    grades = []
    try:
        with contextlib.closing(found):
            for one in found:
                grades.append(one)
                print(line(one, total), flush=True)
    except (ClusterError, SandboxError) as error:
        print(f"grade: {error}", file=sys.stderr)
        return 2
    ranked = leaderboard(grades)
    write_csv(output / "grades.csv", ranked, options.lab)
    write_html(output / "grades.html", ranked, options.lab)
    print(f"grade: {len(grades)} workspaces, see {output / 'grades.html'} and grades.csv")
    return 0 if not any(found.note or found.contained for found in grades) else 1


def grade_here(jobs: list, output: Path, options: argparse.Namespace) -> Iterator[Grade]:
    """Grade workspaces on this machine and yield each grade as soon as it is known.

    Raises:
        SandboxError: there is no sandbox on this machine
    """
    if not options.no_sandbox:
        require()
    stop = threading.Event()
    waiting: list = []
    with ThreadPoolExecutor(options.jobs) as pool:
        try:
            for name, folder, conditions in jobs:
                conditions = replace(conditions, stopped=stop.is_set)
                waiting.append(pool.submit(grade, name, folder, output / name, conditions))
            for done in as_completed(waiting):
                yield done.result()
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
