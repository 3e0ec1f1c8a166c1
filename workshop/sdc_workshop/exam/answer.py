"""The answer of a check about one step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import yaml

PASSED = "passed"
WRONG = "wrong"
UNFINISHED = "unfinished"  # the student has not written anything there yet
WAITING = "waiting"  # an earlier step must be fixed before this one can be checked
NOT_JUDGED = "not judged"  # the machine was too busy

# In a hint: what follows gives the line or the formula away. Show keeps it for the third attempt.
IN_FULL = "In full: "


def in_full(law: str | None) -> str:
    """Return a text that gives a line away as the end of a hint; some texts mark it themselves."""
    law = law or ""
    return law if IN_FULL in law or not law else IN_FULL + law


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong."""

    expected: str  # what was expected
    seen: str  # what was seen instead
    hint: str  # how to fix it
    todo: str | None = None  # number of the region that it is about, or None
    # Line in the file that was checked, from 1; it may differ from the student's line
    line: int | None = None
    # Whether `seen` is an error of Python, which needs the hint of the step, too
    is_error: bool = False


@lru_cache(maxsize=1)
def _problems() -> dict:
    return yaml.safe_load(Path(__file__).with_name("problems.yaml").read_text(encoding="utf-8"))


def listed(
    key: str, /, todo: str | None = None, line: int | None = None, **values: object
) -> Problem:
    """Return the problem with this name of problems.yaml, with values in its texts."""
    row = _problems()[key]
    texts = [row[part].format(**values) for part in ("expected", "seen", "hint")]
    return Problem(*texts, todo or row.get("todo"), line)


@dataclass(frozen=True)
class Answer:
    """The answer about a step: its status, and as in Problem what is wrong."""

    status: str  # PASSED, WRONG, UNFINISHED, WAITING or NOT_JUDGED
    expected: str = ""  # what was expected
    seen: str = ""  # what was seen instead
    hint: str = ""  # how to fix it
    file: str | None = None  # path relative to the workspace, or None
    line: int | None = None  # line in the file, from 1, or None
    seed: str = ""  # with this seed of the stage, the check draws the same arguments again

    @property
    def where(self) -> str:
        """The place, for people and editors: "src/sdc_package/scripts/camera.py:20"."""
        return f"{self.file}:{self.line}" if self.file and self.line else self.file or ""


def encodable(answer: Answer) -> Answer:
    """Return an answer that a file and a terminal can show: a result may be half a character."""
    texts = {name: getattr(answer, name) for name in ("expected", "seen", "hint")}
    shown = {name: text.encode(errors="backslashreplace") for name, text in texts.items()}
    return replace(answer, **{name: text.decode() for name, text in shown.items()})


def answered(
    key: str, /, file: str | None = None, line: int | None = None, **values: object
) -> Answer:
    """Return the answer with this name of problems.yaml; without a status there, it is WRONG."""
    problem = listed(key, line=line, **values)
    status = _problems()[key].get("status", WRONG)
    return Answer(status, problem.expected, problem.seen, problem.hint, file, line)


def wrong(problem: Problem, file: str | None = None, line: int | None = None) -> Answer:
    """Return the answer to a step that has this problem."""
    return Answer(WRONG, problem.expected, problem.seen, problem.hint, file, line)
