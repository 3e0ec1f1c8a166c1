"""The summary of all grades: tables, also for Moodle and Canvas, and pages."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import NamedTuple

import jinja2
import yaml

from sdc_sim.report import templates
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.grading.grading import Grade
from sdc_workshop.grading.handed_in import lms_columns
from sdc_workshop.grading.record import printable, write_table
from sdc_workshop.grading.rubric import Mark, mark
from sdc_workshop.steps import WORKSHOP, Step, hint_of, load_steps

_OFF_ROUTE = "off_route"
# Pairs of students on the page: at most as many, and at least with this share of equal tokens.
_MOST_COPIES = 20
_LEAST_COPY_PERCENT = 50.0
_COLUMNS = yaml.safe_load(Path(__file__).with_name("columns.yaml").read_text(encoding="utf-8"))
# Of the machine, not of the car: the table is the same at each run.
_OF_THE_MACHINE = ("wall_duration_s", "real_time_factor")

ASSIGNMENT = "Self-driving-car workshop"
# Read by the import of a grading worksheet (Identifier), and of the gradebook (the other three).
_MOODLE = ("Identifier", "Full name", "ID number", "Username", "Email address")
_MOODLE_MARK = ("Grade", "Maximum Grade", "Last modified (grade)", "Feedback comments")
_CANVAS = ("Student", "ID", "SIS User ID", "SIS Login ID", "Section")


class Row(NamedTuple):
    """A student in the table."""

    rank: int
    grade: Grade
    mark: Mark


def ranked(grades: list, rubric: dict) -> list:
    """Return a row for each grade, best first; equal results share a rank.

    The order is by mark, driving scores, steps done and time of the drive; then by name.
    """
    rows = []
    for found in grades:
        made = mark(found, rubric)
        result = (
            *(-made.points, -found.score, -found.unknown_score, -found.steps_done),
            found.report.get("time_ratio") or float("inf"),
        )
        rows.append((result, found.name, found, made))
    rows.sort(key=lambda row: row[:2])
    results = [row[0] for row in rows]
    return [Row(results.index(result) + 1, found, made) for result, _, found, made in rows]


def cells(row: Row) -> dict:
    """Return the texts of a student's row by the names of the columns, without the steps."""
    found, made = row.grade, row.mark
    texts = {
        **dict.fromkeys(_COLUMNS, ""),
        "rank": row.rank,
        "student": found.name,
        "folder": printable(str(found.folder)),
        "mark": f"{made.points:.2f}",
        "phases_percent": f"{100.0 * made.phases:.1f}",
        "late_percent": f"{made.late_percent:g}",
        "steps_done": found.steps_done,
        "steps": len(load_steps(found.lab)),
        "steps_by_solution": len(found.solved),
        "next_step": found.first_open,
        "driving_score": f"{found.score:.1f}" if found.report else "",
        "unknown_driving_score": f"{found.unknown_score:.1f}" if found.unknown else "",
        "unknown_status": found.unknown.get("status", ""),
        "championship": found.championship,
        "note": found.note,
        "contained": "; ".join(found.contained),
    }
    for key, value in found.report.items():
        inner = value.items() if isinstance(value, dict) else [("", value)]
        for name, number in inner if key not in ("driving_score", *_OF_THE_MACHINE) else ():
            texts[f"{key}_{name}".rstrip("_")] = _text(key, number, found.report["status"])
    return {key: str(text) for key, text in texts.items()}


def _text(key: str, value: object, status: str) -> str:
    """Return a value of the report; "" where it says nothing."""
    if value is None or (key == "time_ratio" and status != "completed"):
        return ""
    if key == "comfortable":
        return "" if status == _OFF_ROUTE else "yes" if value else "no"
    _, *form = _COLUMNS.get(key, [key])
    return form[0].format(value) if form else str(value)


def write_csv(path: Path, rows: list, lab: str = WORKSHOP) -> None:
    """Write one row per student: marks, steps, all metrics, and the status of each step."""
    steps = load_steps(lab)
    texts = [cells(row) for row in rows]
    columns = dict.fromkeys(key for found in texts for key in found)
    for row, found in zip(rows, texts):
        for step in steps:
            found[f"step {step.id}"] = row.grade.answers.get(step.id, {}).get("status", "")
    write_table(path, [*columns, *(f"step {step.id}" for step in steps)], texts)


def write_lms(output: Path, rows: list, rubric: dict) -> None:
    """Write moodle.csv and canvas.csv."""
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
    write_table(output / "moodle.csv", (*_MOODLE, *_MOODLE_MARK), moodle)
    write_table(output / "canvas.csv", (*_CANVAS, ASSIGNMENT), canvas)


def write_pages(output: Path, rows: list, pairs: list, lab: str = WORKSHOP) -> None:
    """Write grades.html, and into each student's folder page.html and results.json."""
    environment = templates(Path(__file__).parent, trim_blocks=True, lstrip_blocks=True)
    for row in rows:
        try:
            _write_page(environment, output, row, lab)
        except Exception as error:  # noqa: BLE001  the pages of the others are written
            found = row.grade
            problem = printable(f"no page: {type(error).__name__}: {error}")
            found.note = "; ".join(filter(None, (found.note, problem)))
    copied = [pair for pair in pairs if pair.equal_percent >= _LEAST_COPY_PERCENT]
    page = environment.get_template("grades.html.j2").render(
        students=[(row, cells(row)) for row in rows],
        steps=load_steps(lab),
        columns=_COLUMNS,
        copied=copied[:_MOST_COPIES],
    )
    (output / "grades.html").write_text(page, "utf-8", "backslashreplace")


def _write_page(environment: jinja2.Environment, output: Path, row: Row, lab: str) -> None:
    folder = output / row.grade.name
    picture = folder / "report.png"
    values = {
        "grade": row.grade,
        "mark": row.mark,
        "cells": cells(row),
        "steps": [(step, *_explained(row.grade, step)) for step in load_steps(lab)],
        "picture": base64.b64encode(picture.read_bytes()) if picture.is_file() else b"",
        "drives": {
            title: (folder / f"{name}.html").read_text(encoding="utf-8")
            for name, title in (("report", "in the town"), ("unknown", "on an unknown route"))
            if (folder / f"{name}.html").is_file()
        },
    }
    for name in ("page.html", "results.json"):
        text = environment.get_template(f"{name}.j2").render(values)
        (folder / name).write_text(text, "utf-8", "backslashreplace")


def _explained(found: Grade, step: Step) -> tuple[str, list]:
    """Return the status of a step, and (name, text) of what is wrong."""
    answer = found.answers.get(step.id)
    if answer is None or answer["status"] == PASSED:
        return (PASSED if answer else "unknown"), []
    where = f"{answer['file']}:{answer['line']}" if answer["line"] else answer["file"]
    hint = answer["hint"] or hint_of(step.id).hint
    rows = (("expected", answer["expected"]), ("seen", answer["seen"]), ("where", where))
    return answer["status"], [(name, text) for name, text in (*rows, ("hint", hint)) if text]
