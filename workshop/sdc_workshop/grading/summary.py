"""The summary of all grades: a table for spreadsheets, and an HTML page."""

from __future__ import annotations

import base64
import csv
import io
from pathlib import Path

import jinja2

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG
from sdc_workshop.grading.grading import Grade
from sdc_workshop.steps import WORKSHOP, load_steps

_PICTURE_WIDTH = 720
_TEMPLATE = Path(__file__).with_name("grades.html.j2")
# Metrics on the page: key of the report, heading, format.
_METRICS = (
    ("status", "drive", "{}"),
    ("route_completion_percent", "route %", "{:.0f}"),
    ("duration_s", "time s", "{:.1f}"),
    ("time_ratio", "time ratio", "{:.2f}"),
    ("cross_track_rms_m", "error RMS m", "{:.3f}"),
    ("cross_track_max_m", "worst m", "{:.2f}"),
    ("lateral_acceleration_max_mps2", "lateral m/s²", "{:.1f}"),
    ("jerk_max_mps3", "jerk m/s³", "{:.1f}"),
    ("comfortable", "comfortable", "{}"),
)
_KEY = (
    (PASSED, "right"),
    (WRONG, "wrong"),
    (WAITING, "waits for another step"),
    (UNFINISHED, "not written yet"),
    ("unknown", "not checked"),
)


def leaderboard(grades: list) -> list:
    """Return grades, best first: by driving score, steps done, faster drive, and name."""
    return sorted(
        grades,
        key=lambda found: (
            -found.score,
            -found.steps_done,
            found.report.get("time_ratio") or float("inf"),
            found.name,
        ),
    )


def flat(report: dict) -> dict:
    """Return the report with the counts of its infractions as keys of their own."""
    found = {}
    for key, value in report.items():
        if isinstance(value, dict):
            found.update({f"{key}_{name}": inner for name, inner in value.items()})
        else:
            found[key] = value
    return found


def write_csv(path: Path, ranked: list, lab: str = WORKSHOP) -> None:
    """Write one row per student: steps, the status of each step, and all metrics."""
    steps = load_steps(lab)
    keys = dict.fromkeys(key for found in ranked for key in flat(found.report))
    metrics = [key for key in keys if key != "driving_score"]
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(
            [
                *("rank", "student", "folder", "steps_done", "steps", "next_step"),
                *("driving_score", "note", "contained"),
                *metrics,
                *(f"step {step.id}" for step in steps),
            ]
        )
        for rank, found in enumerate(ranked, start=1):
            report = flat(found.report)
            rows.writerow(
                [
                    *(rank, found.name, found.folder, found.steps_done, len(steps)),
                    *(found.first_open, f"{found.score:.4f}", found.note),
                    "; ".join(found.contained),
                    *(report.get(key, "") for key in metrics),
                    *(found.answers.get(step.id, {}).get("status", "") for step in steps),
                ]
            )


def write_html(path: Path, ranked: list, lab: str = WORKSHOP) -> None:
    """Write a self-contained page: the leaderboard, and each student's steps and drive."""
    steps = load_steps(lab)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATE.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template(_TEMPLATE.name).render(
        students=[_student(found, steps, path.parent / found.name) for found in ranked],
        step_count=len(steps),
        complete=sum(found.steps_done == len(steps) for found in ranked),
        driven=sum(found.report.get("status") == "completed" for found in ranked),
        headings=[heading for _, heading, _ in _METRICS],
        key=_KEY,
    )
    path.write_text(page, encoding="utf-8")


def _student(found: Grade, steps: list, folder: Path) -> dict:
    """Return what the page shows of a student."""
    strip = []
    for step in steps:
        answer = found.answers.get(step.id)
        seen = f": {answer['seen']}" if answer and answer["seen"] else ""
        status = answer["status"] if answer else "unknown"
        strip.append((status, f"{step.id}: {step.title}{seen}"))
    return {
        "grade": found,
        "share": 100.0 * found.steps_done / len(steps),
        "metrics": [
            (_class(key, found.report), _metric(found.report, key, form))
            for key, _, form in _METRICS
        ],
        "strip": strip,
        "next": _next(found),
        "picture": _picture(folder / "report.png"),
        "has_report": (folder / "report.html").is_file(),
    }


def _class(key: str, report: dict) -> str:
    if key == "status" and report:
        return "good" if report.get("status") == "completed" else "bad"
    return ""


def _metric(report: dict, key: str, form: str) -> str:
    value = report.get(key)
    if value is None or (key == "time_ratio" and report.get("status") != "completed"):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    try:
        return form.format(value)
    except (ValueError, TypeError):
        return str(value)


def _next(found: Grade) -> list:
    """Return (name, text) of the answer about the next step."""
    if not found.first_open:
        return []
    answer = found.answers[found.first_open]
    where = answer["file"] or ""
    if answer["file"] and answer["line"]:
        where = f"{answer['file']}:{answer['line']}"
    rows = (
        ("expected", answer["expected"]),
        ("seen", answer["seen"]),
        ("where", where),
        ("hint", answer["hint"]),
    )
    return [(name, text) for name, text in rows if text]


def _picture(path: Path) -> str:
    """Return the referee's picture of the drive as base64, not larger than shown; else empty."""
    if not path.is_file():
        return ""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import image

    try:
        pixels = image.imread(path)
    except (OSError, SyntaxError, ValueError):
        return ""
    step = max(1, round(pixels.shape[1] / _PICTURE_WIDTH / 1.5))
    small = io.BytesIO()
    image.imsave(small, pixels[::step, ::step], format="png")
    return base64.b64encode(small.getvalue()).decode()
