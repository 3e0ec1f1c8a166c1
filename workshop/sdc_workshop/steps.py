"""The steps of the workshop in their order, as steps.yaml lists them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import yaml

STEPS_FILE = Path(__file__).resolve().parents[1] / "steps.yaml"


class StepError(ValueError):
    """A step that does not exist; the message names those that come near."""


@dataclass(frozen=True)
class Step:
    """One step. `file` is relative to the src folder of a workspace; None: nothing is written in this step. `todo` is the number of the
    region in it; None: the whole file is written."""

    id: str
    title: str
    phase: int
    file: str | None = None
    todo: str | None = None

    @property
    def place(self) -> str:
        """Where it is written, for people: "sdc_package/scripts/camera.py, TODO 2"."""
        return f"{self.file}, TODO {self.todo}" if self.todo else self.file or ""


def load_steps() -> list:
    """All steps, in order."""
    with open(STEPS_FILE, encoding="utf-8") as file:
        rows = yaml.safe_load(file)
    return [
        Step(**{**row, "todo": str(row["todo"]) if row.get("todo") is not None else None})
        for row in rows
    ]


def find_step(step_id: str) -> Step:
    """The step with this id. Raises StepError."""
    steps = load_steps()
    for step in steps:
        if step.id == step_id:
            return step
    stem = step_id.split("-")[0].split(".")[0]
    near = [step.id for step in steps if step.id.startswith(stem)] or [step.id for step in steps]
    raise StepError(f"there is no step '{step_id}'; there are {', '.join(near)}")
