"""A mark from the result of a student, by a rubric in YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Iterable, NamedTuple

import yaml

from sdc_sim.yaml_document import load_yaml, validate
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.grading import Grade
from sdc_workshop.steps import load_steps

PACKAGED = Path(__file__).with_name("rubric.yaml")


class Mark(NamedTuple):
    """The mark of a student, and the shares of its parts from 0 to 1."""

    points: float
    phases: float
    drive: float
    unknown_drive: float
    my_car: float
    late_percent: float


def load_rubric(path: Path = PACKAGED, students: Iterable[str] = ()) -> dict:
    """Return a rubric, completed by the packaged one.

    Each name in late.days must be one of the students.

    Raises:
        DocumentError: the file cannot be read, or a line is wrong
    """
    document = load_yaml(str(path), "name a readable file with --rubric")
    document.values = document.values or {}
    schema = PACKAGED.with_name("rubric_schema.yaml").read_text(encoding="utf-8")
    validate(document, yaml.safe_load(schema))
    packaged = yaml.safe_load(PACKAGED.read_text(encoding="utf-8"))
    rubric = {**packaged, **document.values}
    for key in ("weights", "late"):
        rubric[key] = {**packaged[key], **rubric[key]}
    for name in sorted(set(rubric["late"]["days"]) - set(students), key=str):
        raise document.error(["late", "days", name], f"'{name}' is no name in the table")
    for key, weights in (("weights", rubric["weights"].values()), ("phases", rubric["phases"])):
        if not sum(weights):
            raise document.error([key], f"'{key}' must have a number above 0")
    return rubric


def mark(found: Grade, rubric: dict) -> Mark:
    """Return the mark of a student."""
    every = load_steps(found.lab)
    steps = [step for step in every if not step.id.endswith("drive")]
    parts = rubric["weights"] if len(steps) < len(every) else {"phases": 1.0}  # without a drive
    weights = {step.id: rubric["phases"][step.phase - 1] for step in steps}
    passed = [step for step in weights if found.answers.get(step, {}).get("status") == PASSED]
    given = sum(weights[step] for step in passed if step in found.solved)
    own = sum(weights[step] for step in passed) - given
    total = sum(weights.values()) or 1
    shares = {
        "phases": (own + min(given, rubric["solution_cap"] * total)) / total,
        "drive": found.score / 100.0,
        "unknown_drive": found.unknown_score / 100.0,
        "my_car": float(found.championship or 0.0) / 100.0,
    }
    reached = sum(weight * shares[name] for name, weight in parts.items()) / sum(parts.values())
    late = rubric["late"]
    days = max(0.0, late["days"].get(found.name, 0) - late["free_days"])
    percent = min(100.0, days * late["percent_per_day"])
    points = round(rubric["points"] * reached * (100.0 - percent) / 100.0, 2)
    return Mark(points, late_percent=percent, **shares)
