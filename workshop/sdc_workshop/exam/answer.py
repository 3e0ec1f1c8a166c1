"""The answer of a check about one step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import yaml

PASSED = "passed"
WRONG = "wrong"
UNFINISHED = "unfinished"  # the student has not written anything there yet
WAITING = "waiting"  # an earlier step must be fixed before this one can be checked


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    Attributes:
        expected: what was expected
        seen: what was seen instead
        hint: how to fix it
        todo: number of the region that it is about, or None
        line: line in the file that was checked, from 1; it may differ from the student's line
        is_error: whether `seen` is an error of Python, which needs the hint of the step, too
    """

    expected: str
    seen: str
    hint: str
    todo: str | None = None
    line: int | None = None
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
    """The answer about a step: its status, and as in Problem what is wrong.

    Attributes:
        status: PASSED, WRONG, UNFINISHED or WAITING
        expected: what was expected
        seen: what was seen instead
        hint: how to fix it
        file: path relative to the workspace, or None
        line: line in the file, from 1, or None
        seed: with this seed of the stage, the check draws the same arguments again
    """

    status: str
    expected: str = ""
    seen: str = ""
    hint: str = ""
    file: str | None = None
    line: int | None = None
    seed: str = ""

    @property
    def where(self) -> str:
        """The place, for people and editors: "src/sdc_package/scripts/camera.py:20"."""
        return f"{self.file}:{self.line}" if self.file and self.line else self.file or ""


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
