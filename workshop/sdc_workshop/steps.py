"""The steps of the workshop, and of each lab, in their order, as their steps.yaml lists them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, Sequence

import yaml

FOLDER = Path(__file__).resolve().parents[1]
# The labs and their packages. Their steps, hints and checks are in labs/NAME.
LABS = {name: f"sdc_{name}" for name in ("localization", "perception", "behaviour", "mpc")}
# The steps of the workshop itself.
WORKSHOP = ""


class StepError(ValueError):
    """An unknown step, or an empty range of steps."""


@dataclass(frozen=True)
class Step:
    """One step of the workshop or of a lab."""

    id: str  # name of the step on the command line
    title: str  # what the student does
    phase: int  # phase of the guide, 1 to 4
    # Relative to the src folder of a workspace; None: nothing is written in this step
    file: str | None = None
    todo: str | None = None  # number of the region in the file; None: the whole file is written
    lab: str = WORKSHOP  # name of the lab, or WORKSHOP
    optional: bool = False  # whether a check or a grade of all steps leaves it out

    @property
    def place(self) -> str:
        """Where the step is written, for people: "sdc_package/scripts/camera.py, TODO 2"."""
        return f"{self.file}, TODO {self.todo}" if self.todo else self.file or ""


def lesson_folder(lab: str) -> Path:
    """Return the folder of the steps of a lab, or of the workshop."""
    return FOLDER / "labs" / lab if lab else FOLDER


@lru_cache
def load_steps(lab: str = WORKSHOP, optional: bool = False) -> list:
    """Return the steps of a lab, or of the workshop, in order; with the optional ones if wanted."""
    rows = yaml.safe_load((lesson_folder(lab) / "steps.yaml").read_text(encoding="utf-8"))
    return [
        Step(**{**row, "todo": str(row["todo"]) if row.get("todo") is not None else None}, lab=lab)
        for row in rows
        if optional or not row.get("optional")
    ]


def all_steps() -> list:
    """Return the steps of the workshop and of all labs, with the optional ones."""
    return [step for lab in (WORKSHOP, *LABS) for step in load_steps(lab, optional=True)]


def find_step(step_id: str) -> Step:
    """Return the step with this id. Raises StepError."""
    return find_steps(step_id)[0]


def find_steps(name: str) -> list:
    """Return the steps with this id, or with ids that begin with it: "camera", "controller-2".

    Raises:
        StepError: there is none
    """
    steps = all_steps()
    beginnings = tuple(name.rstrip("-.") + end for end in "-.")
    found = [step for step in steps if step.id == name]
    found = found or [step for step in steps if name and step.id.startswith(beginnings)]
    if not found:
        raise StepError(f"there is no step '{name}'; ./workshop/check --list prints them")
    return found


def chosen(names: Sequence[str], lab: str = WORKSHOP, optional: bool = False) -> list:
    """Return the steps that names mean, in order; without names, those of a lab.

    Names are ids, beginnings of ids, or ranges of them: "messages-7..messages-10".

    Raises:
        StepError: there is no such step
    """
    if not names:
        return load_steps(lab, optional)
    steps = all_steps()
    meant: set = set()
    for name in names:
        first, is_range, last = name.partition("..")
        found = find_steps(first)
        if is_range:
            begin, end = steps.index(found[0]), steps.index(find_steps(last)[-1])
            found = steps[begin : end + 1]
            if not found:
                raise StepError(f"'{name}' is empty: {last} comes before {first}")
        meant.update(step.id for step in found)
    return [step for step in steps if step.id in meant]


class Hint(NamedTuple):
    """The hint of a step, and further help for `./workshop/check --hint`."""

    hint: str
    more: str


def language() -> str:
    """Return the language of the environment, as gettext finds it, if hints are in it; else ""."""
    variables = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
    wanted = next(filter(None, map(os.environ.get, variables)), "")
    code = re.split(r"[_.:@]", wanted)[0]
    return code if code.isalpha() and (FOLDER / code / "hints.yaml").is_file() else ""


@lru_cache
def hints(code: str = "") -> dict:
    """Return the hints of all lessons in a language, by the id of the step; "": in English."""
    folders = [FOLDER / code] if code else [lesson_folder(lab) for lab in (WORKSHOP, *LABS)]
    found: dict = {}
    for folder in folders:
        found.update(yaml.safe_load((folder / "hints.yaml").read_text(encoding="utf-8")))
    return found


def hint_of(step_id: str) -> Hint:
    """Return the hint of a step in the language of the environment, or in English."""
    row = hints(language()).get(step_id) or hints()[step_id]
    return Hint(row["hint"], row["more"])
