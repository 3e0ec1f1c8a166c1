"""Tables with the marks for Moodle and Canvas."""

from __future__ import annotations

from pathlib import Path

from sdc_workshop.grading.handed_in import lms_columns
from sdc_workshop.grading.record import write_table

ASSIGNMENT = "Self-driving-car workshop"
# Read by the import of a grading worksheet (Identifier), and of the gradebook (the other three).
_MOODLE = ("Identifier", "Full name", "ID number", "Username", "Email address")
_MOODLE_MARK = ("Grade", "Maximum Grade", "Last modified (grade)", "Feedback comments")
_CANVAS = ("Student", "ID", "SIS User ID", "SIS Login ID", "Section")


def write_lms(output: Path, rows: list, rubric: dict) -> None:
    """Write moodle.csv and canvas.csv.

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
    write_table(output / "moodle.csv", (*_MOODLE, *_MOODLE_MARK), moodle)
    write_table(output / "canvas.csv", (*_CANVAS, ASSIGNMENT), canvas)
