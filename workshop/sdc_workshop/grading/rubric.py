"""A mark from the result of a student, by a rubric in YAML."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Iterable, NamedTuple

import yaml

from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.grading import Grade
from sdc_workshop.steps import load_steps

PACKAGED = Path(__file__).with_name("rubric.yaml")


class RubricError(ValueError):
    """A rubric that cannot be used; the message is one line with the place and the fix."""


class Mark(NamedTuple):
    """The mark of a student; shares are from 0 to 1."""

    points: float
    phases: float
    drive: float
    unknown_drive: float
    late_percent: float


def load_rubric(path: Path = PACKAGED, students: Iterable[str] = ()) -> dict:
    """Return a rubric, completed by the packaged one.

    Args:
        path: the file
        students: names of the students, one of which each name in late.days must be

    Raises:
        RubricError: the file cannot be read, or a key or a value is wrong
    """
    rubric = yaml.safe_load(PACKAGED.read_text(encoding="utf-8"))
    try:
        own = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RubricError(f"{path}: {' '.join(str(error).split())}") from None
    _complete(rubric, own, str(path))
    for name in sorted(set(map(str, rubric["late"]["days"])) - set(students)):
        raise RubricError(f"{path}: late.days: '{name}' is no name in the table")
    if not sum(rubric["weights"].values()) or not sum(rubric["phases"].values()):
        raise RubricError(f"{path}: weights and phases: one must be positive")
    if rubric["solution_cap"] > 1:
        raise RubricError(f"{path}: solution_cap must be from 0 to 1")
    return rubric


def _complete(known: dict, own: object, where: str) -> None:
    """Replace values of `known` by those of `own`, where these are of the same kind."""
    if not isinstance(own, dict):
        raise RubricError(f"{where}: must be keys with values, got {own!r}")
    for key, value in own.items():
        place = f"{where}: {key}"
        if key not in known and not where.endswith(": days"):
            raise RubricError(f"{place}: unknown; write one of {', '.join(map(str, known))}")
        if isinstance(known.get(key), dict):
            _complete(known[key], value, place)
        elif isinstance(value, bool) or not isinstance(value, (int, float)):
            raise RubricError(f"{place}: must be a number, got {value!r}")
        elif not 0 <= value < math.inf:
            raise RubricError(f"{place}: must not be negative, got {value!r}")
        else:
            known[key] = value


def mark(found: Grade, rubric: dict) -> Mark:
    """Return the mark of a student."""
    steps = [step for step in load_steps(found.lab) if not step.id.endswith("drive")]
    weights = {step.id: rubric["phases"].get(step.phase, 1) for step in steps}
    passed = {step for step, answer in found.answers.items() if answer["status"] == PASSED}
    passed &= set(weights)
    own = sum(weights[step] for step in passed - set(found.solved))
    given = sum(weights[step] for step in passed & set(found.solved))
    total = sum(weights.values()) or 1
    parts = {
        "phases": (own + min(given, rubric["solution_cap"] * total)) / total,
        "drive": found.score / 100.0,
        "unknown_drive": found.unknown_score / 100.0,
    }
    weight = sum(rubric["weights"][name] for name in parts)
    reached = sum(rubric["weights"][name] * share for name, share in parts.items()) / weight
    late = rubric["late"]
    days = max(0.0, late["days"].get(found.name, 0) - late["free_days"])
    percent = min(100.0, days * late["percent_per_day"])
    points = round(rubric["points"] * reached * (100.0 - percent) / 100.0, 2)
    return Mark(points, late_percent=percent, **parts)
