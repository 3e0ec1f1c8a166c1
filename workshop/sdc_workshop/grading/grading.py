"""Grades one workspace: copied, built and examined within a time limit, by programs of its own."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG
from sdc_workshop.exam.process import Program, marked
from sdc_workshop.grading.copying import CopyError, copy_workspace
from sdc_workshop.grading.examine_one import ANSWERS
from sdc_workshop.steps import load_steps

# A student's programs that start more processes than these are ended, and the rest of the check with them.
MOST_PROCESSES = 150
_LOOK_EVERY_S = 0.2
_BUILD_LOG = "build.log"
_CHECK_LOG = "check.log"


@dataclass
class Grade:
    """What is known about a student's workspace. `answers` are {step id: answer as a dictionary}, `report` the referee's figures; `note`
    says what went wrong with the grading itself, or nothing."""

    name: str
    folder: Path
    answers: dict = field(default_factory=dict)
    report: dict = field(default_factory=dict)
    note: str = ""
    wall_s: float = 0.0

    @property
    def steps_done(self) -> int:
        return sum(answer["status"] == PASSED for answer in self.answers.values())

    @property
    def score(self) -> float:
        """Driving score, 0 without a drive."""
        value = self.report.get("driving_score")
        return float(value) if isinstance(value, (int, float)) else 0.0

    @property
    def first_open(self) -> str:
        """The step that the student should look at first."""
        for wanted in ((WRONG,), (UNFINISHED, WAITING)):
            for step in load_steps():
                if self.answers.get(step.id, {}).get("status") in wanted:
                    return step.id
        return ""


def grade(name: str, folder: Path, result: Path, limit_s: float, stopped=lambda: False) -> Grade:
    """Grade the workspace in `folder`, of which nothing is changed; logs, answers and report go to `result`. Once `stopped()` is true,
    all that runs is ended."""
    found = Grade(name, folder)
    start = time.monotonic()
    result.mkdir(parents=True, exist_ok=True)
    for path in (
        *result.glob("report*"),
        result / ANSWERS,
        result / _BUILD_LOG,
        result / _CHECK_LOG,
    ):
        if path.is_file():
            path.unlink()
    with tempfile.TemporaryDirectory(prefix="workshop_grade_") as temporary:
        workspace = Path(temporary) / "workspace"
        try:
            copy_workspace(folder, workspace)
            _build(workspace, result, start + limit_s, stopped)
            _examine(workspace, result, Path(temporary), start + limit_s, stopped)
        except (CopyError, OSError, _Ended) as error:
            found.note = str(error)
    with contextlib.suppress(OSError, ValueError):
        found.answers = json.loads((result / ANSWERS).read_text(encoding="utf-8"))
    with contextlib.suppress(OSError, ValueError):
        found.report = json.loads((result / "report.json").read_text(encoding="utf-8"))
    found.wall_s = time.monotonic() - start
    return found


class _Ended(Exception):
    """A program had to be ended; the message says why."""


def _plain_environment(**more) -> dict:
    return {
        **{name: os.environ[name] for name in ("HOME", "LANG", "PATH") if name in os.environ},
        "PYTHONDONTWRITEBYTECODE": "1",
        **more,
    }


def _build(workspace: Path, result: Path, until: float, stopped) -> None:
    """catkin_make, as in a new terminal. What does not build is examined all the same: many steps can be judged without."""
    setup = "[ ! -f /opt/ros/noetic/setup.bash ] || . /opt/ros/noetic/setup.bash"
    with Program(
        ["bash", "-c", f"{setup}; exec catkin_make -j1"],
        _plain_environment(PATH="/usr/bin:/bin"),
        workspace,
    ) as program:
        try:
            _wait(program, until, stopped, "the build")
        finally:
            (result / _BUILD_LOG).write_text(program.output, encoding="utf-8")


def _examine(workspace: Path, result: Path, temporary: Path, until: float, stopped) -> None:
    home, scratch = temporary / "home", temporary / "tmp"
    home.mkdir()
    scratch.mkdir()
    environment = _plain_environment(
        PYTHONPATH=os.environ.get("PYTHONPATH", ""),
        HOME=str(home),
        TMPDIR=str(scratch),
        OMP_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
    )
    with Program(
        [sys.executable, "-B", "-m", "sdc_workshop.grading.examine_one", workspace, result],
        environment,
        workspace,
    ) as program:
        try:
            _wait(program, until, stopped, "the check")
        finally:
            (result / _CHECK_LOG).write_text(program.output, encoding="utf-8")
        if program.status != 0:
            raise _Ended(f"the check ended with status {program.status}, see {result / _CHECK_LOG}")


def _wait(program: Program, until: float, stopped, what: str) -> None:
    while program.status is None:
        if stopped():
            raise _Ended(f"{what} was interrupted")
        if time.monotonic() > until:
            raise _Ended(f"{what} took longer than its time limit and was ended")
        if len(marked(program.mark)) > MOST_PROCESSES:
            raise _Ended(f"more than {MOST_PROCESSES} processes were started; {what} was ended")
        program.wait(_LOOK_EVERY_S)
