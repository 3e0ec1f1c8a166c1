"""The steps of the workshop in their order, as steps.yaml lists them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import yaml

STEPS_FILE = Path(__file__).resolve().parents[1] / "steps.yaml"


class StepError(ValueError):
    """An unknown step; the message lists similar ones."""


@dataclass(frozen=True)
class Step:
    """One step of the workshop.

    Attributes:
        id: name of the step on the command line
        title: what the student does
        phase: phase of the guide, 1 to 4
        file: relative to the src folder of a workspace; None: nothing is written in this step
        todo: number of the region in the file; None: the whole file is written
    """

    id: str
    title: str
    phase: int
    file: str | None = None
    todo: str | None = None

    @property
    def place(self) -> str:
        """Where the step is written, for people: "sdc_package/scripts/camera.py, TODO 2"."""
        return f"{self.file}, TODO {self.todo}" if self.todo else self.file or ""


def load_steps() -> list:
    """Return all steps, in order."""
    with open(STEPS_FILE, encoding="utf-8") as file:
        rows = yaml.safe_load(file)
    return [
        Step(**{**row, "todo": str(row["todo"]) if row.get("todo") is not None else None})
        for row in rows
    ]


def find_step(step_id: str) -> Step:
    """Return the step with this id. Raises StepError."""
    steps = load_steps()
    for step in steps:
        if step.id == step_id:
            return step
    stem = step_id.split("-")[0].split(".")[0]
    near = [step.id for step in steps if step.id.startswith(stem)] or [step.id for step in steps]
    raise StepError(f"there is no step '{step_id}'; there are {', '.join(near)}")
