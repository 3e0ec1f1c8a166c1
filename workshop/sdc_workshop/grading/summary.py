"""The summary of all grades: a table for a spreadsheet, and a page for the eye."""

from __future__ import annotations

import base64
import csv
import html
import io
from pathlib import Path
from urllib.parse import quote

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG
from sdc_workshop.grading.grading import Grade
from sdc_workshop.steps import load_steps

_PICTURE_WIDTH = 720
# Figures of the report that a page shows: key, heading, how to write it.
_SHOWN = (
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


def leaderboard(grades: list) -> list:
    """Best first: driving score, then steps done, then the quicker drive, then the name."""
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
    """The report with the counts of its infractions beside the other figures."""
    found = {}
    for key, value in report.items():
        if isinstance(value, dict):
            found.update({f"{key}_{name}": inner for name, inner in value.items()})
        else:
            found[key] = value
    return found


def write_csv(path: Path, ranked: list) -> None:
    """One row a student, best first: steps, the state of each step, and all figures of the report."""
    steps = load_steps()
    figures = list(dict.fromkeys(key for found in ranked for key in flat(found.report)))
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(
            [
                "rank",
                "student",
                "folder",
                "steps_done",
                "steps",
                "next_step",
                "driving_score",
                "note",
                *(key for key in figures if key != "driving_score"),
                *(f"step {step.id}" for step in steps),
            ]
        )
        for rank, found in enumerate(ranked, start=1):
            report = flat(found.report)
            rows.writerow(
                [
                    rank,
                    found.name,
                    found.folder,
                    found.steps_done,
                    len(steps),
                    found.first_open,
                    f"{found.score:.4f}",
                    found.note,
                    *(report.get(key, "") for key in figures if key != "driving_score"),
                    *(found.answers.get(step.id, {}).get("status", "") for step in steps),
                ]
            )


def write_html(path: Path, ranked: list) -> None:
    """A page that needs nothing but itself: the leaderboard, and for each student the steps, the first thing to mend, and the drive."""
    steps = load_steps()
    rows = "\n".join(_row(rank, found, steps) for rank, found in enumerate(ranked, start=1))
    parts = "\n".join(_student(found, steps, path.parent / found.name) for found in ranked)
    headings = "".join(f"<th>{html.escape(heading)}</th>" for _, heading, _ in _SHOWN)
    complete = sum(found.steps_done == len(steps) for found in ranked)
    driven = sum(found.report.get("status") == "completed" for found in ranked)
    path.write_text(
        f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Grades of the self-driving-car workshop</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>Grades of the self-driving-car workshop</h1>
<p class="lead">Students: {len(ranked)}. All {len(steps)} steps right: {complete}. Drives to the end of the road: {driven}.</p>
<div class="scroll"><table>
<thead><tr><th>#</th><th class="name">student</th><th>driving score</th><th class="name">steps</th><th class="name">next step</th>
{headings}</tr></thead>
<tbody>
{rows}
</tbody>
</table></div>
<p class="key">{_key()}</p>
{parts}
</body>
</html>
""",
        encoding="utf-8",
    )


def _key() -> str:
    states = (
        (PASSED, "right"),
        (WRONG, "wrong"),
        (WAITING, "waits for another step"),
        (UNFINISHED, "not written yet"),
        ("unknown", "not checked"),
    )
    return " ".join(f'<span class="step {status}"></span> {text}' for status, text in states)


def _row(rank: int, found: Grade, steps: list) -> str:
    share = 100.0 * found.steps_done / len(steps)
    figures = "".join(
        f'<td class="{_class(key, found.report)}">{html.escape(_figure(found.report, key, how))}</td>'
        for key, _, how in _SHOWN
    )
    return (
        f'<tr><td>{rank}</td><td class="name"><a href="#{html.escape(found.name)}">{html.escape(found.name)}</a></td>'
        f'<td class="score">{f"{found.score:.1f}" if found.report else "–"}</td>'
        f'<td class="name"><span class="bar"><span style="width:{share:.0f}%"></span></span> {found.steps_done}/{len(steps)}</td>'
        f'<td class="name">{html.escape(found.first_open) or "–"}</td>{figures}</tr>'
    )


def _class(key: str, report: dict) -> str:
    if key == "status" and report:
        return "good" if report.get("status") == "completed" else "bad"
    return ""


def _figure(report: dict, key: str, how: str) -> str:
    value = report.get(key)
    if value is None or (key == "time_ratio" and report.get("status") != "completed"):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    try:
        return how.format(value)
    except (ValueError, TypeError):
        return str(value)


def _student(found: Grade, steps: list, folder: Path) -> str:
    strip = []
    for step in steps:
        answer = found.answers.get(step.id)
        status = answer["status"] if answer else "unknown"
        said = f": {answer['seen']}" if answer and answer["seen"] else ""
        strip.append(
            f'<span class="step {status}" title="{html.escape(f"{step.id}: {step.title}{said}", quote=True)}"></span>'
        )
    note = f'<p class="note">{html.escape(found.note)}</p>' if found.note else ""
    picture = _picture(folder / "report.png")
    if (folder / "report.html").is_file():
        picture += (
            f'<p><a href="{quote(found.name)}/report.html">The whole report of the drive</a></p>'
        )
    return (
        f'<section id="{html.escape(found.name)}"><h2>{html.escape(found.name)}</h2>'
        f'<p class="folder">{html.escape(str(found.folder))}</p><div class="strip">{"".join(strip)}</div>'
        f"{note}{_next(found)}{picture}</section>"
    )


def _next(found: Grade) -> str:
    if not found.first_open:
        return ""
    answer = found.answers[found.first_open]
    rows = "".join(
        f"<dt>{name}</dt><dd>{html.escape(text)}</dd>"
        for name, text in (
            ("expected", answer["expected"]),
            ("seen", answer["seen"]),
            ("where", _where(answer)),
            ("hint", answer["hint"]),
        )
        if text
    )
    return (
        f'<div class="next"><b>{html.escape(found.first_open)}</b> comes next<dl>{rows}</dl></div>'
    )


def _where(answer: dict) -> str:
    return (
        f"{answer['file']}:{answer['line']}"
        if answer["file"] and answer["line"]
        else answer["file"] or ""
    )


def _picture(path: Path) -> str:
    """The drive as the referee drew it, within the page and not larger than it is shown."""
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
    return f'<img alt="the drive" src="data:image/png;base64,{base64.b64encode(small.getvalue()).decode()}">'


_STYLE = """
:root { color-scheme: light dark; --ink: #1f2933; --soft: #616e7c; --line: #e4e7eb; --page: #ffffff; --panel: #f5f7fa;
  --good: #2f9e44; --bad: #d9480f; --wait: #e9b949; --none: #cbd2d9; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e7eb; --soft: #9aa5b1; --line: #323f4b; --page: #1f2933;
  --panel: #27333f; --none: #52606d; } }
body { font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: var(--ink); background: var(--page);
  margin: 2rem auto; max-width: 1300px; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.15rem; margin: 0; }
.lead, .folder, .key { color: var(--soft); } .folder { font-size: .8rem; margin: 0 0 .5rem; } .key { font-size: .85rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .88rem; font-variant-numeric: tabular-nums; }
th { font-weight: 600; font-size: .8rem; color: var(--soft); border-bottom: 2px solid var(--line); }
th, td { text-align: right; padding: .4rem .5rem; white-space: nowrap; } td { border-bottom: 1px solid var(--line);
  } .name { text-align: left; }
tbody tr:first-child td.score { color: var(--good); } .score { font-weight: 700; } .good { color: var(--good);
  } .bad { color: var(--bad); }
a { color: inherit; text-decoration-color: var(--none); }
.bar { display: inline-block; width: 90px; height: 8px; background: var(--none); border-radius: 4px; overflow: hidden;
  vertical-align: middle; }
.bar span { display: block; height: 100%; background: var(--good); }
section { background: var(--panel); border-radius: 8px; padding: 1rem 1.2rem; margin: 1.2rem 0; }
.strip { display: flex; flex-wrap: wrap; gap: 3px; }
.step { display: inline-block; width: 14px; height: 14px; border-radius: 3px; background: var(--none); vertical-align: -2px;
  opacity: .55; }
.step.unknown { background: none; box-shadow: inset 0 0 0 1px var(--none); opacity: 1; }
.step.passed { background: var(--good); opacity: 1; } .step.wrong { background: var(--bad); opacity: 1;
  } .step.waiting { background: var(--wait); opacity: 1; }
.note { color: var(--bad); font-weight: 600; } .next { margin-top: .8rem; }
dl { display: grid; grid-template-columns: 5rem 1fr; gap: .1rem .6rem; margin: .3rem 0 0; font-size: .9rem;
  } dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
img { display: block; max-width: 100%; width: 720px; margin-top: 1rem; border-radius: 6px; }
"""
