"""The steps of the workshop, and of each lab, in their order, as their steps.yaml lists them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import yaml

FOLDER = Path(__file__).resolve().parents[1]
# The labs and their packages. Their steps, hints and checks are in labs/NAME.
LABS = {"localization": "sdc_localization", "perception": "sdc_perception"}
# The steps of the workshop itself.
WORKSHOP = ""


class StepError(ValueError):
    """An unknown step; the message lists similar ones."""


@dataclass(frozen=True)
class Step:
    """One step of the workshop or of a lab.

    Attributes:
        id: name of the step on the command line
        title: what the student does
        phase: phase of the guide, 1 to 4
        file: relative to the src folder of a workspace; None: nothing is written in this step
        todo: number of the region in the file; None: the whole file is written
        lab: name of the lab, or WORKSHOP
    """

    id: str
    title: str
    phase: int
    file: str | None = None
    todo: str | None = None
    lab: str = WORKSHOP

    @property
    def place(self) -> str:
        """Where the step is written, for people: "sdc_package/scripts/camera.py, TODO 2"."""
        return f"{self.file}, TODO {self.todo}" if self.todo else self.file or ""


def lesson_folder(lab: str) -> Path:
    """Return the folder of the steps of a lab, or of the workshop."""
    return FOLDER / "labs" / lab if lab else FOLDER


def load_steps(lab: str = WORKSHOP) -> list:
    """Return the steps of a lab, or of the workshop, in order."""
    rows = yaml.safe_load((lesson_folder(lab) / "steps.yaml").read_text(encoding="utf-8"))
    return [
        Step(**{**row, "todo": str(row["todo"]) if row.get("todo") is not None else None}, lab=lab)
        for row in rows
    ]


def all_steps() -> list:
    """Return the steps of the workshop and of all labs."""
    return [step for lab in (WORKSHOP, *LABS) for step in load_steps(lab)]


def find_step(step_id: str) -> Step:
    """Return the step with this id. Raises StepError."""
    steps = all_steps()
    for step in steps:
        if step.id == step_id:
            return step
    stem = step_id.split("-")[0].split(".")[0]
    near = [step.id for step in steps if step.id.startswith(stem)] or [step.id for step in steps]
    raise StepError(f"there is no step '{step_id}'; there are {', '.join(near)}")


class Hint(NamedTuple):
    """The hint of a step, and further help for `./workshop/check --hint`."""

    hint: str
    more: str


@lru_cache(maxsize=1)
def _hints() -> dict:
    found: dict = {}
    for lab in (WORKSHOP, *LABS):
        text = (lesson_folder(lab) / "hints.yaml").read_text(encoding="utf-8")
        found.update(yaml.safe_load(text))
    return found


def hint_of(step_id: str) -> Hint:
    """Return the hint of a step."""
    return Hint(**_hints()[step_id])
