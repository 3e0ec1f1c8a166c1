"""Files with the marks for Moodle, Canvas and Gradescope."""

from __future__ import annotations

import csv
from pathlib import Path

from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.handed_in import lms_columns
from sdc_workshop.grading.record import write_json
from sdc_workshop.grading.summary import Row
from sdc_workshop.steps import load_steps

ASSIGNMENT = "Self-driving-car workshop"
# Read by the import of a grading worksheet (Identifier), and of the gradebook (the other three).
_MOODLE = ("Identifier", "Full name", "ID number", "Username", "Email address")
_MOODLE_MARK = ("Grade", "Maximum Grade", "Last modified (grade)", "Feedback comments")
_CANVAS = ("Student", "ID", "SIS User ID", "SIS Login ID", "Section")


def write_lms(output: Path, rows: list, rubric: dict) -> None:
    """Write moodle.csv, canvas.csv, and results.json into the folder of each student.

    Args:
        output: folder of the summary
        rows: the students
        rubric: see load_rubric
    """
    moodle, canvas = [], [{"Student": "    Points Possible", ASSIGNMENT: f"{rubric['points']:g}"}]
    for row in rows:
        found, points = row.grade, f"{row.mark.points:.2f}"
        known = {"Username": found.name, "SIS Login ID": found.name}
        known.update({"Full name": found.name, "Student": found.name})
        known.update(lms_columns(found.folder)[1])
        first = f"next: {found.first_open}" if found.first_open else ""
        feedback = "; ".join(filter(None, (f"{found.steps_done} steps", first, found.note)))
        mark = zip(_MOODLE_MARK, (points, f"{rubric['points']:.2f}", "-", feedback))
        moodle.append({**known, **dict(mark)})
        canvas.append({**known, ASSIGNMENT: points})
        write_json(output / found.name / "results.json", _gradescope(row, rubric))
    _write(output / "moodle.csv", (*_MOODLE, *_MOODLE_MARK), moodle)
    _write(output / "canvas.csv", (*_CANVAS, ASSIGNMENT), canvas)


def _write(path: Path, columns: tuple, rows: list) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, columns, extrasaction="ignore")
        table.writeheader()
        table.writerows(rows)


def _gradescope(row: Row, rubric: dict) -> dict:
    """Return what Gradescope reads as results.json: the mark, and a test for each step."""
    found, tests = row.grade, []
    for step in load_steps(found.lab):
        answer = found.answers.get(step.id, {})
        passed = answer.get("status") == PASSED
        texts = (f"{key}: {answer[key]}" for key in ("expected", "seen", "hint") if answer.get(key))
        tests.append(
            {
                "name": f"{step.id}: {step.title}",
                "status": "passed" if passed else "failed",
                "output": "\n".join(texts),
                "visibility": "visible",
            }
        )
    scores = (("Driving score", found.score), ("Unknown route", found.unknown_score))
    return {
        "score": row.mark.points,
        "output": found.note or f"{found.steps_done} steps are right.",
        "visibility": "visible",
        "tests": tests,
        "leaderboard": [{"name": name, "value": round(value, 1)} for name, value in scores],
        "extra_data": {"parts": row.mark._asdict(), "points": rubric["points"]},
    }
