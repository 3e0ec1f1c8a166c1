"""./workshop/grade DIR ...: grades students' workspaces and writes a summary."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from sdc_workshop.grading.copying import is_workspace
from sdc_workshop.grading.grading import Grade, grade
from sdc_workshop.grading.summary import leaderboard, write_csv, write_html
from sdc_workshop.steps import load_steps

DESCRIPTION = """Checks every student's workspace, each with a ROS master and a time limit of its own, and never writes into it. A DIR is
a workspace, or a folder with workspaces in it. The summary, grades.csv and grades.html, and for each student the logs and the report of
the drive, are written into a folder."""


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(prog="./workshop/grade", description=DESCRIPTION)
    parser.add_argument("folders", nargs="+", metavar="DIR", type=Path)
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("grades"),
        metavar="FOLDER",
        help="where the summary is written (default: grades)",
    )
    parser.add_argument(
        "--limit",
        type=float,
        default=600.0,
        metavar="SECONDS",
        help="time for one student, build and drive included (default: 600)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="students at the same time (default: one a core)",
    )
    options = parser.parse_args(arguments)
    if options.limit <= 0.0 or options.jobs < 1:
        parser.error("--limit and --jobs must be positive")
    return options


def workspaces(folders: list) -> list:
    """The workspaces that are meant by some folders, by full paths, none twice. A folder that neither is one nor holds one stands for
    itself: its row of the summary will say so."""
    found = []
    for folder in folders:
        folder = folder.absolute()
        inside = (
            []
            if is_workspace(folder) or not folder.is_dir()
            else sorted(path for path in folder.iterdir() if is_workspace(path))
        )
        found.extend(inside or [folder])
    return list(dict.fromkeys(Path(os.path.normpath(path)) for path in found))


def names(folders: list) -> dict:
    """{folder: name}: the last parts of its path, as many as tell it from the others."""
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


def main(arguments) -> int:
    """Returns the exit status: 0 when all folders could be graded."""
    options = parse(arguments)
    output = options.output.absolute()
    named = names(workspaces(options.folders))
    for folder in named:
        if output == folder or folder in output.parents:
            print(
                f"grade: the summary would be written into {folder}, a student's folder; name another one with --output",
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
    total = len(load_steps())
    grades = []
    stop = threading.Event()
    with ThreadPoolExecutor(options.jobs) as pool:
        waiting = [
            pool.submit(grade, name, folder, output / name, options.limit, stop.is_set)
            for folder, name in named.items()
        ]
        try:
            for done in as_completed(waiting):
                grades.append(done.result())
                print(line(grades[-1], total), flush=True)
        except KeyboardInterrupt:
            stop.set()
            for job in waiting:
                job.cancel()
            raise
    ranked = leaderboard(grades)
    write_csv(output / "grades.csv", ranked)
    write_html(output / "grades.html", ranked)
    print(f"grade: {len(grades)} workspaces, see {output / 'grades.html'} and grades.csv")
    return 0 if all(not found.note for found in grades) else 1


def line(found: Grade, total: int) -> str:
    """One line about a student for the terminal."""
    drive = (
        f"driving score {found.score:.1f} ({found.report['status']})"
        if found.report
        else "no drive"
    )
    after = f"; next: {found.first_open}" if found.first_open else ""
    note = f"; {found.note}" if found.note else ""
    return f"grade: {found.name}: {found.steps_done} of {total} steps, {drive}{after}{note}"


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
