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
class Answer:
    """The answer about a step, or about a part of it: its status, and what is wrong."""

    status: str  # PASSED, WRONG, UNFINISHED, WAITING or NOT_JUDGED
    expected: str = ""  # what was expected
    seen: str = ""  # what was seen instead
    hint: str = ""  # how to fix it
    file: str | None = None  # path relative to the workspace, or None
    # Line from 1, or None: in the file that was checked, in the end in the student's file
    line: int | None = None
    todo: str | None = None  # number of the region that it is about, or None
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


def mistake(expected: str, seen: str, hint: str, todo: str | None = None) -> Answer:
    """Return the answer about a mistake."""
    return Answer(WRONG, expected, seen, hint, todo=todo)


@lru_cache(maxsize=1)
def _problems() -> dict:
    return yaml.safe_load(Path(__file__).with_name("problems.yaml").read_text(encoding="utf-8"))


def listed(
    key: str,
    /,
    file: str | None = None,
    line: int | None = None,
    todo: str | None = None,
    **values: object,
) -> Answer:
    """Return the answer with this name of problems.yaml; without a status there, it is WRONG."""
    row = _problems()[key]
    texts = [row[part].format(**values) for part in ("expected", "seen", "hint")]
    return Answer(row.get("status", WRONG), *texts, file, line, todo or row.get("todo"))
