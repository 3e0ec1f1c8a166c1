"""The last step: the whole car drives the route in lockstep."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.report.comparison import load_report
from sdc_workshop.exam.answer import PASSED, Answer, listed, mistake
from sdc_workshop.exam.output import crash, last_line, plain
from sdc_workshop.exam.process import TIMEOUT_S
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.unknown_route import write_unknown_route, write_unseen_road

DRIVE_TIMEOUT_S = 240.0
# The speed went wrong where the car was so much faster than the packaged plan [m/s].
_TOO_FAST_MPS = 2.0
# The steering went wrong where the car was so far beside the route [m].
_BESIDE_M = 0.5
_ARGUMENTS = "sdc_package all.launch sync:=true headless:=true"
_REFEREE = re.compile(r"referee: (\w+): (.*)")
_DIED = re.compile(r"^\[(\w+)-\d+\] process has died \[.*?(exit code -?\d+)", re.MULTILINE)


def _driven(stage: Stage, path: Path, arguments: list, table: dict, road: tuple) -> tuple:
    """Drive and write the report; return the status, None after a timeout, and the output."""
    traffic = [f"obstacles_path:={file}" for file in road[1:]]
    if stage.sandbox is not None:
        from sdc_workshop.exam.refereed_drive import refereed_drive

        route = (road[0], "unseen" in table) if road else ()
        return 0, refereed_drive(stage, arguments, path, [*table["world"], *traffic], *route)
    if road:
        arguments = [*arguments, f"waypoints_path:={road[0]}", *traffic]
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


def _first_wrong(report: Path, road: tuple) -> str:
    """Return which of speed and steering went wrong first in a drive, "" where neither did."""
    from sdc_workshop.exam.refereed_drive import ROUTE, packaged_rules

    route = Route(load_waypoints(str(road[0] if road else ROUTE)))
    trace = load_report(str(report)).trace
    if trace is None:
        return ""
    planned_mps = np.interp(
        trace["s_m"], route.s, IdealDrive(route, packaged_rules(True).speed_limits()).speed_mps
    )
    is_fast = trace["speed_mps"] > planned_mps + _TOO_FAST_MPS
    is_beside = np.abs(trace["cross_track_m"]) > _BESIDE_M
    places = np.flatnonzero(is_fast | is_beside)
    if not len(places):
        return ""
    first = places[0]
    speed, beside = trace["speed_mps"][first], abs(trace["cross_track_m"][first])
    found = "drive_speed" if is_fast[first] else "drive_steering"
    texts = {"speed": speed, "planned": planned_mps[first], "beside": beside}
    return listed(found, time=trace["time_s"][first] - trace["time_s"][0], **texts).hint


def drive_answer(stage: Stage, table: dict, second: bool = False) -> tuple:
    """Drive as the entry `drive` of checks.yaml says; return the answer and the report, or None.

    The second drive of a grade is on a road that the secret draws.
    """
    path = stage.hidden / ("unknown" if second else "report") / "report.json"
    stage.forget_build()
    arguments = [*_ARGUMENTS.split(), *table["car"]]
    road: tuple = ()
    if table.get("unseen"):
        road = write_unseen_road(stage.road_seed(second), stage.hidden)
    elif second:
        road = write_unknown_route(stage.road_seed(second), stage.hidden)
    status, output = _driven(stage, path, arguments, table, road)
    output = plain(output)
    stage.clear()
    cause, file, line = _cause(output, stage.student)
    if not path.is_file():
        seen = f"no end after {DRIVE_TIMEOUT_S:g} s" if status is None else last_line(output)
        hint = f"roslaunch {' '.join(arguments)} shows the whole output."
        found = mistake("a drive along the whole route", cause or seen, hint)
        return replace(found, file=file, line=line), None
    report = json.loads(path.read_text(encoding="utf-8"))
    if report["status"] == "completed":
        return Answer(PASSED), report
    result = _REFEREE.search(output)
    seen = result[0] if result else report["status"]
    found = listed(f"drive_{report['status']}", seen=seen)
    if cause:
        found = listed("drive_error", seen=seen, cause=cause)
    elif report["status"] == "off_route":
        found = replace(found, hint=f"{_first_wrong(path, road)} {found.hint}".strip())
    return replace(found, file=file, line=line), report
