"""The last step: the whole car drives the route in lockstep."""

from __future__ import annotations

import json
import re

from sdc_workshop.exam.answer import PASSED, WRONG, Answer
from sdc_workshop.exam.output import crash, last_words, plain
from sdc_workshop.exam.process import PATIENCE_S

LIMIT_S = 240.0
_REFEREE = re.compile(r"referee: (\w+): (.*)")
_MEANINGS = {
    "off_route": "The car has left its road: look at steering and local planner; `./workshop/check` says whether a step is wrong.",
    "blocked": "The car stands: does it get a path, and does the controller answer it? `rostopic echo "
    "/carla/ego_vehicle/vehicle_control_cmd` shows its commands.",
    "timeout": "The car is far too slow: look at the planned speeds and at the pedals.",
    "collision": "The car has hit something.",
    "aborted": "A node has ended before the drive was over: its words above say why.",
}


def drive_answer(stage) -> tuple:
    """(Answer, report): the report of the referee as a dictionary, None when there was none."""
    report = stage.folder / "report" / "report.json"
    stage.master  # noqa: B018  roslaunch finds a master that runs, and uses it
    with stage.program(
        [
            "roslaunch",
            "--skip-log-check",
            "sdc_package",
            "all.launch",
            "sync:=true",
            "camera:=false",
            "headless:=true",
            f"report:={report}",
        ]
    ) as program:
        status = program.wait(LIMIT_S)
        output = plain(program.output)
        if status is None:
            program.interrupt()
            program.wait(PATIENCE_S / 2)
    stage.clear()
    if not report.is_file():
        broken = crash(output, stage.student.src)
        seen = (
            broken.error
            if broken
            else ("no end after " + f"{LIMIT_S:g} s" if status is None else last_words(output))
        )
        return Answer(
            WRONG,
            "a drive along the whole route",
            seen,
            "roslaunch sdc_package all.launch sync:=true camera:=false headless:=true shows all that is said.",
        ), None
    figures = json.loads(report.read_text(encoding="utf-8"))
    if figures["status"] == "completed":
        return Answer(PASSED), figures
    said = _REFEREE.search(output)
    return Answer(
        WRONG,
        "a drive along the whole route: completed",
        said[0] if said else figures["status"],
        _MEANINGS.get(figures["status"], "Look at report.png."),
    ), figures
