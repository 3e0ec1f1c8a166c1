"""Build and check one workspace, and write the answers after each step.

So the answers are kept when the check is ended before its end.
Usage: python3 -m sdc_workshop.grading.examine_one WORKSPACE RESULT_FOLDER BUILD_LIMIT_S USER_ID
LAB [STEP ...]

The student's programs run in a sandbox, as the user with this id where this one is root; with the
user id "none", without a sandbox. With the secret of the class in the environment, a car that has
driven the first road drives the unknown route, too. LAB is the name of the lab, or "" for the
workshop. Without a STEP, all its steps are checked.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import sys
from dataclasses import asdict
from pathlib import Path

from sdc_common.processes import isolate_network
from sdc_workshop.exam.answer import NOT_JUDGED, Answer
from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.process import NotJudged
from sdc_workshop.exam.sandbox import Sandbox
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.grading.record import BUILD_LOG, NO_SANDBOX, SECRET, Record
from sdc_workshop.steps import Step, load_steps
from sdc_workshop.workspace import WORLD_SETUP

_ROUNDS = 200_000
BUILD = "the build"
UNKNOWN = "the drive on the unknown route"
_NOT_JUDGED = "not judged, the machine was too busy; grade again"


def build(stage: Stage, record: Record, result: Path, limit_s: float) -> None:
    """Run catkin_make as in a new terminal. Many steps can be checked although it fails."""
    record.begin(BUILD)
    workspace = stage.student.folder
    script = 'source "$1"; cd "$2" && exec catkin_make -j1'
    command = ["bash", "-c", script, "bash", WORLD_SETUP, workspace]
    environment = {"PATH": "/usr/bin:/bin", "PYTHONDONTWRITEBYTECODE": "1"}
    # Only Python's classes are used; the others take more time than the rest of the build.
    environment["ROS_LANG_DISABLE"] = "gencpp:genlisp:geneus:gennodejs"
    environment["HOME"] = os.environ.get("HOME", "/")
    options = {} if stage.sandbox is None else {"building": True}
    with stage.start(command, environment, **options) as program:
        late = True
        while late:
            with contextlib.suppress(NotJudged):
                if program.wait(limit_s) is None:
                    record.note(f"{BUILD} took longer than its time limit and was ended")
                late = False
        (result / BUILD_LOG).write_text(program.output, encoding="utf-8")


def arguments_seed(secret: str) -> str:
    """Return the seed of the arguments of the checks, from which no student finds the secret.

    The pages that students get show this seed; a guess of the secret takes some 0.1 s.
    """
    if not secret:
        return ""
    return hashlib.pbkdf2_hmac("sha256", secret.encode(), b"arguments", _ROUNDS).hex()[:8]


def main() -> None:
    """Write RESULT_FOLDER/answers.json, and the referee's report next to it."""
    workspace, result, limit_s = Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3])
    record = Record(result)
    sandbox = None
    os.umask(0o022)
    if sys.argv[4] != NO_SANDBOX:
        sandbox = Sandbox(workspace, int(sys.argv[4]), record.contained)
    else:
        isolate_network()
    # No program that starts from now on inherits it, and no argument shows it.
    secret = os.environ.pop(SECRET, "")
    lab, ids = sys.argv[5], sys.argv[6:]
    steps = [step for step in load_steps(lab) if step.id in ids or not ids]
    with Stage(Student(workspace), sandbox, arguments_seed(secret), secret) as stage:
        build(stage, record, result, limit_s)
        examination = Examination(stage.student, stage, drive_anyway=True)

        def save(step: Step, answer: Answer) -> None:
            record.answer(step.id, asdict(answer))
            if answer.status == NOT_JUDGED:
                record.note(f"{step.id} was {_NOT_JUDGED}")

        examination.judge(steps, save, on_begin=lambda step, _: record.begin(step.id))
        if secret and (examination.report or {}).get("driving_score"):
            record.begin(UNKNOWN)
            # The student's programs see the road when they drive it, and never its traffic.
            try:
                examination.drive_unknown(lab)
            except NotJudged:
                record.note(f"{UNKNOWN} was {_NOT_JUDGED}")
        for name in ("report", "unknown"):
            for path in sorted((stage.hidden / name).glob("report*")):
                if path.is_file():
                    shutil.copyfile(path, result / path.name.replace("report", name))


if __name__ == "__main__":
    main()
