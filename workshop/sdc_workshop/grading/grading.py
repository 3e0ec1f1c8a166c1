"""Grade one workspace: copy, build and check it in its own programs, within a time limit."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Callable

from sdc_sim.report.writer import write_json
from sdc_workshop.exam.answer import NOT_JUDGED, PASSED
from sdc_workshop.exam.limits import GROUP, control_groups, entering
from sdc_workshop.exam.process import Program
from sdc_workshop.exam.sandbox import outer_command
from sdc_workshop.grading.copies import written_tokens
from sdc_workshop.grading.handed_in import HandedInError, copy_workspace
from sdc_workshop.grading.record import (
    ANSWERS,
    BUILD_LOG,
    NO_SANDBOX,
    SECRET,
    STATE,
    printable,
    read,
)
from sdc_workshop.show import first_open
from sdc_workshop.steps import WORKSHOP, load_steps
from sdc_workshop.temporary import temporary_folder
from sdc_workshop.workspace import PROJECT, WORLD, package_of, solved_steps, version

_POLL_S = 0.2
_CHECK_LOG = "check.log"
_GRADE = "grade.json"
_WRITTEN = (BUILD_LOG, _CHECK_LOG, ANSWERS, STATE, _GRADE)
# The build gets this share of a student's time, but no more than this.
_BUILD_SHARE = 0.5
_BUILD_LIMIT_S = 120.0


@dataclass
class Grade:
    """The result of a student."""

    name: str  # name in the summary
    folder: Path  # the workspace
    answers: dict = field(default_factory=dict)  # the answers by step id, as dictionaries
    report: dict = field(default_factory=dict)  # the referee's report
    note: str = ""  # what went wrong with the grading itself, or empty
    # What the sandbox has kept the student's programs from
    contained: list = field(default_factory=list)
    lab: str = WORKSHOP  # the lab, or WORKSHOP
    # The referee's report of the drive on the unknown route
    unknown: dict = field(default_factory=dict)
    championship: str = ""  # score of its driver.py in the championship
    # IDs of the steps that `./workshop/check --solution` wrote
    solved: list = field(default_factory=list)
    # What the student has written, for the search for copies
    tokens: list = field(default_factory=list)

    @property
    def steps_done(self) -> int:
        """Number of the steps that passed."""
        return sum(answer["status"] == PASSED for answer in self.answers.values())

    @property
    def score(self) -> float:
        """Driving score; 0 without a drive."""
        return float(self.report.get("driving_score") or 0.0)

    @property
    def unknown_score(self) -> float:
        """Driving score on the unknown route; 0 without a drive."""
        return float(self.unknown.get("driving_score") or 0.0)

    @property
    def first_open(self) -> str:
        """The step that the student must fix or write next."""
        statuses = {step_id: answer["status"] for step_id, answer in self.answers.items()}
        step = first_open(load_steps(self.lab), statuses)
        return step.id if step else ""


class _Ended(Exception):
    """A program was ended; the message names the reason."""


@dataclass(frozen=True)
class Conditions:
    """How a student's programs run."""

    limit_s: float  # time limit of the student [s]
    # The user of the programs in their sandbox, if the teacher is root; None: no sandbox
    user_id: int | None = None
    stopped: Callable[[], bool] = lambda: False  # once it returns True, all programs are ended
    steps: tuple = ()  # ids of the steps that are checked; empty: all
    lab: str = WORKSHOP  # the lab, or WORKSHOP
    # The secret of the class, which the unknown route is drawn from; None: no such drive
    seed: int | None = None


def grade(name: str, folder: Path, result: Path, conditions: Conditions) -> Grade:
    """Grade what a student has handed in, without changing it; `result` is for logs and answers.

    Return the earlier grade of the same files, if there is one.
    """
    found = Grade(name, folder, lab=conditions.lab)
    result.mkdir(parents=True, exist_ok=True)
    notes, links, key = [], [], ""
    with temporary_folder("workshop_grade_") as temporary:
        workspace = temporary / "workspace"
        try:
            links = copy_workspace(folder, workspace, conditions.lab)
            key = _key(workspace, conditions)
            with contextlib.suppress(OSError, ValueError, TypeError):
                saved = json.loads((result / _GRADE).read_text(encoding="utf-8"))
                if saved.pop("key") == key:
                    return Grade(**{**saved, "name": name, "folder": folder})
            _clear(result)
            found.solved = solved_steps(workspace, conditions.lab)
            found.tokens = written_tokens(workspace / "src", conditions.lab)
            _examine(result, temporary, conditions)
        except (HandedInError, OSError, _Ended) as error:
            notes.append(str(error))
        except Exception as error:  # noqa: BLE001  a student's files may cause any; others go on
            notes.append(f"could not be graded: {type(error).__name__}: {error}")
    if not key:
        _clear(result)
    found.answers, state = read(result)
    found.note = "; ".join(dict.fromkeys([*state["notes"], *notes]))
    found.contained = [
        f"the link {link} leads out of the workspace or to a folder" for link in links
    ]
    # Whether there is a file that the sandbox may hide is not asked: the student would learn it.
    found.contained += [
        f"{step}: {text}"
        for step, text, path in state["contained"]
        if not path.startswith(str(temporary))
    ]
    found.note, found.contained = printable(found.note), [*map(printable, found.contained)]
    for name in ("report", "unknown"):
        with contextlib.suppress(OSError, ValueError):
            text = (result / f"{name}.json").read_text(encoding="utf-8")
            setattr(found, name, json.loads(text))
    statuses = [answer["status"] for answer in found.answers.values()]
    if key and not conditions.stopped() and NOT_JUDGED not in statuses:
        write_json(result / _GRADE, {"key": key, **asdict(found), "folder": str(folder)})
    return found


def _key(workspace: Path, conditions: Conditions) -> str:
    """Return a text that changes with a student's files, and with what they are graded by."""
    by = (conditions.seed, conditions.lab, conditions.steps, conditions.user_id is None, version())
    found = hashlib.sha256(repr(by).encode())
    for path in sorted((workspace / "src" / package_of(conditions.lab)).rglob("*")):
        if path.is_file():
            name = path.relative_to(workspace)
            found.update(repr((str(name), path.stat().st_mode, path.read_bytes())).encode())
    return found.hexdigest()


def _clear(result: Path) -> None:
    """Remove what an earlier grading has written."""
    reports = (*result.glob("report*"), *result.glob("unknown*"))
    for path in (*reports, *(result / name for name in _WRITTEN)):
        if path.is_file():
            path.unlink()


def _examine(result: Path, temporary: Path, conditions: Conditions) -> None:
    workspace, home, scratch = (temporary / name for name in ("workspace", "home", "tmp"))
    built = [workspace / name for name in ("build", "devel")]
    environment = {name: os.environ[name] for name in ("LANG", "PATH") if name in os.environ}
    environment.update(
        PYTHONDONTWRITEBYTECODE="1",
        PYTHONPATH=f"{PROJECT / 'workshop'}:{os.environ.get('PYTHONPATH', '')}",
        HOME=str(home),
        TMPDIR=str(scratch),
        OMP_NUM_THREADS="1",
        OPENBLAS_NUM_THREADS="1",
        MALLOC_ARENA_MAX="2",  # more take addresses, which are limited
    )
    command = [sys.executable, "-B", "-m", "sdc_workshop.grading.examine_one", workspace, result]
    user_id = NO_SANDBOX if conditions.user_id is None else conditions.user_id
    command += [min(_BUILD_LIMIT_S, _BUILD_SHARE * conditions.limit_s), user_id]
    command += [conditions.lab, *conditions.steps]
    if conditions.seed is not None:
        environment[SECRET] = str(conditions.seed)
    home.mkdir()
    scratch.mkdir()
    if conditions.user_id is not None:
        # The programs cannot write into src, in which catkin_make makes this link.
        os.symlink(os.readlink(WORLD / "src" / "CMakeLists.txt"), workspace / "src/CMakeLists.txt")
        for folder in built:
            folder.mkdir()
    until = time.monotonic() + conditions.limit_s
    with contextlib.ExitStack() as stack:
        if conditions.user_id is not None:
            group, inner = stack.enter_context(control_groups())
            inner = environment[GROUP] = inner or ""
            command = entering(group, outer_command(command, result, temporary, built, inner))
        program = stack.enter_context(Program(command, environment, workspace))
        try:
            _wait(program, until, conditions.stopped, result)
        finally:
            (result / _CHECK_LOG).write_text(program.output, encoding="utf-8")
        if program.status != 0:
            raise _Ended(f"the check ended with status {program.status}, see {result / _CHECK_LOG}")


def _wait(program: Program, until: float, stopped: Callable[[], bool], result: Path) -> None:
    while program.status is None:
        if stopped():
            raise _Ended("the check was interrupted")
        # What the check waits for a processor is the machine's time, not the student's.
        if time.monotonic() > until + program.waited_s:
            step = read(result)[1]["step"]
            raise _Ended(f"the check took longer than its time limit and was ended at {step}")
        time.sleep(_POLL_S)
