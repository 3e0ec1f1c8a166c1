"""Grade one workspace: copy, build and check it in its own programs, within a time limit."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG
from sdc_workshop.exam.process import Program, marked
from sdc_workshop.grading.copying import CopyError, copy_workspace
from sdc_workshop.grading.examine_one import ANSWERS
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import WORLD_SETUP

# A check with more processes than these is ended.
MAX_PROCESSES = 150
_POLL_S = 0.2
_BUILD_LOG = "build.log"
_CHECK_LOG = "check.log"
_LOGS = (_BUILD_LOG, _CHECK_LOG)


@dataclass
class Grade:
    """The result of a student.

    Attributes:
        name: name in the summary
        folder: the workspace
        answers: the answers by step id, as dictionaries
        report: the referee's report
        note: what went wrong with the grading itself, or empty
        wall_s: duration of the grading [s]
    """

    name: str
    folder: Path
    answers: dict = field(default_factory=dict)
    report: dict = field(default_factory=dict)
    note: str = ""
    wall_s: float = 0.0

    @property
    def steps_done(self) -> int:
        """Number of the steps that passed."""
        return sum(answer["status"] == PASSED for answer in self.answers.values())

    @property
    def score(self) -> float:
        """Driving score; 0 without a drive."""
        value = self.report.get("driving_score")
        return float(value) if isinstance(value, (int, float)) else 0.0

    @property
    def first_open(self) -> str:
        """The step that the student must fix or write next."""
        for wanted in ((WRONG,), (UNFINISHED, WAITING)):
            for step in load_steps():
                if self.answers.get(step.id, {}).get("status") in wanted:
                    return step.id
        return ""


class _Ended(Exception):
    """A program was ended; the message names the reason."""


@dataclass(frozen=True)
class _Limit:
    """When a student's programs are ended: at a time, or once `stopped()` is true."""

    until: float
    stopped: Callable[[], bool]


def grade(
    name: str,
    folder: Path,
    result: Path,
    limit_s: float,
    stopped: Callable[[], bool] = lambda: False,
) -> Grade:
    """Grade one workspace, without changing it.

    Args:
        name: name of the student
        folder: the workspace
        result: folder for logs, answers and report
        limit_s: time limit [s]
        stopped: once it returns True, all programs are ended
    """
    found = Grade(name, folder)
    start = time.monotonic()
    result.mkdir(parents=True, exist_ok=True)
    for path in (*result.glob("report*"), *(result / log for log in (ANSWERS, *_LOGS))):
        if path.is_file():
            path.unlink()
    limit = _Limit(start + limit_s, stopped)
    with tempfile.TemporaryDirectory(prefix="workshop_grade_") as temporary:
        workspace = Path(temporary) / "workspace"
        try:
            copy_workspace(folder, workspace)
            _build(workspace, result, limit)
            _examine(workspace, result, Path(temporary), limit)
        except (CopyError, OSError, _Ended) as error:
            found.note = str(error)
    with contextlib.suppress(OSError, ValueError):
        found.answers = json.loads((result / ANSWERS).read_text(encoding="utf-8"))
    with contextlib.suppress(OSError, ValueError):
        found.report = json.loads((result / "report.json").read_text(encoding="utf-8"))
    found.wall_s = time.monotonic() - start
    return found


def _plain_environment(**more: str) -> dict:
    kept = {name: os.environ[name] for name in ("HOME", "LANG", "PATH") if name in os.environ}
    return {**kept, "PYTHONDONTWRITEBYTECODE": "1", **more}


def _build(workspace: Path, result: Path, limit: _Limit) -> None:
    """Run catkin_make as in a new terminal. Many steps can be checked although it fails."""
    with Program(
        ["bash", "-c", 'source "$1"; exec catkin_make -j1', "bash", WORLD_SETUP],
        _plain_environment(PATH="/usr/bin:/bin"),
        workspace,
    ) as program:
        try:
            _wait(program, limit, "the build")
        finally:
            (result / _BUILD_LOG).write_text(program.output, encoding="utf-8")


def _examine(workspace: Path, result: Path, temporary: Path, limit: _Limit) -> None:
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
            _wait(program, limit, "the check")
        finally:
            (result / _CHECK_LOG).write_text(program.output, encoding="utf-8")
        if program.status != 0:
            raise _Ended(f"the check ended with status {program.status}, see {result / _CHECK_LOG}")


def _wait(program: Program, limit: _Limit, what: str) -> None:
    while program.status is None:
        if limit.stopped():
            raise _Ended(f"{what} was interrupted")
        if time.monotonic() > limit.until:
            raise _Ended(f"{what} took longer than its time limit and was ended")
        if len(marked(program.mark)) > MAX_PROCESSES:
            raise _Ended(f"more than {MAX_PROCESSES} processes were started; {what} was ended")
        program.wait(_POLL_S)
