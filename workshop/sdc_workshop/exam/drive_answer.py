"""The last step: the whole car drives the route in lockstep."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Sequence

from sdc_workshop.exam.answer import PASSED, WRONG, Answer, listed, wrong
from sdc_workshop.exam.output import crash, last_line, plain
from sdc_workshop.exam.process import TIMEOUT_S
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.steps import lesson_folder

DRIVE_TIMEOUT_S = 240.0
_ARGUMENTS = "sdc_package all.launch sync:=true headless:=true"
_REFEREE = re.compile(r"referee: (\w+): (.*)")
_DIED = re.compile(r"^\[(\w+)-\d+\] process has died \[.*?(exit code -?\d+)", re.MULTILINE)


def _driven(
    stage: Stage, path: Path, arguments: list, lab: str, table: dict, unknown: Sequence[Path]
) -> tuple:
    """Drive and write the report; return the status, None after a timeout, and the output."""
    traffic = [f"obstacles_path:={file}" for file in unknown[1:]]
    if stage.sandbox is not None:
        from sdc_workshop.exam.refereed_drive import refereed_drive

        held_out = lesson_folder(lab) / table["held_out"] if "held_out" in table else None
        world = [*table["world"], *traffic]
        more = {"held_out": held_out}
        if unknown:
            more = {"route" if held_out is None else "held_out": unknown[0]}
        return 0, refereed_drive(stage, arguments, path, world, **more)
    if unknown:
        arguments = [*arguments, f"waypoints_path:={unknown[0]}", *traffic]
    stage.master  # noqa: B018  roslaunch uses a master that already runs
    command = ["roslaunch", "--skip-log-check", *arguments, f"report:={path}"]
    with stage.program(command) as program:
        status = program.wait(DRIVE_TIMEOUT_S)
        output = program.output
        if status is None:
            program.interrupt()
            program.wait(TIMEOUT_S / 2)
    # The end of the launch has ended the process that writes the pages of the report, too.
    with stage.program(["rosrun", "sdc_sim", "report.py", path.parent]) as completion:
        completion.wait(TIMEOUT_S)
    return status, output


def _cause(output: str, student: Student) -> tuple:
    """Return what ended a node of the student or a callback of it, its file and its line."""
    broken, died = crash(output, student.src), _DIED.search(output)
    if broken is not None and broken.file is not None and broken.kind != "KeyboardInterrupt":
        return broken.error, str(Path(broken.file).relative_to(student.folder)), broken.line
    if died is not None:
        last = last_line(output[: died.start()])
        return f"the node {died[1]} ended with {died[2]}; last line: {last}", None, None
    return broken.error if broken is not None else "", None, None


def drive_answer(stage: Stage, lab: str, table: dict, unknown: Sequence[Path] = ()) -> tuple:
    """Drive the route.

    Args:
        stage: where the car drives
        lab: the lab, or WORKSHOP
        table: how it drives, the entry `drive` of checks.yaml
        unknown: waypoint file of another road than the packaged one, and its scenario, if any

    Returns:
        the answer, and the referee's report as a dictionary, or None without one
    """
    path = stage.hidden / ("unknown" if unknown else "report") / "report.json"
    stage.forget_build()
    arguments = [*_ARGUMENTS.split(), *table["car"]]
    if "route" in table and stage.sandbox is None and not unknown:
        arguments.append(f"waypoints_path:={lesson_folder(lab) / table['route']}")
    status, output = _driven(stage, path, arguments, lab, table, unknown)
    output = plain(output)
    stage.clear()
    cause, *place = _cause(output, stage.student)
    if not path.is_file():
        seen = f"no end after {DRIVE_TIMEOUT_S:g} s" if status is None else last_line(output)
        hint = f"roslaunch {' '.join(arguments)} shows the whole output."
        return Answer(WRONG, "a drive along the whole route", cause or seen, hint, *place), None
    report = json.loads(path.read_text(encoding="utf-8"))
    if report["status"] == "completed":
        return Answer(PASSED), report
    result = _REFEREE.search(output)
    seen = result[0] if result else report["status"]
    found = listed(f"drive_{report['status']}", seen=seen)
    if cause:
        found = listed("drive_error", seen=seen, cause=cause)
    return wrong(found, *place), report
