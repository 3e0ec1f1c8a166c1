"""The page report.html, one file that needs no other."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from markupsafe import Markup

from sdc_sim.evaluation.drive_evaluation import (
    COLUMNS,
    LIGHTS,
    OBSTACLES,
    PATH,
    PICTURE,
    DriveEvaluation,
)
from sdc_sim.evaluation.route_progress import COMPLETED, DriveEvent
from sdc_sim.report import templates
from sdc_sim.report.plots import EVENT_NAMES, SPEED_REASONS, headline, svg_map, svg_panels
from sdc_sim.road.road_markings import SPEED_COLOURS
from sdc_sim.yaml_document import packaged_config

# The meaning of each metric, in the order of the table.
MEANINGS = packaged_config("report_metrics")
# The page of a drive of ten minutes is smaller than 10 MB with these.
_MAX_TICKS = 30_000
_MAX_ENTRIES = 4000
_MAX_ROUTE_POINTS = 10_000
_MAX_PICTURE_CHARACTERS = 6_000_000


def write_html(path: str, result: DriveEvaluation, title: str = "") -> None:
    """Write the page of a drive, see html_of."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(html_of(result, title))


def html_of(result: DriveEvaluation, title: str = "") -> str:
    """Return the page of an evaluated drive.

    Args:
        result: the drive
        title: what was driven, see title_of; "" if that is not known
    """
    environment = templates(keep_trailing_newline=True)
    metrics = result.metrics
    names = [*MEANINGS, *(name for name in metrics if name not in MEANINGS)]
    return environment.get_template("report.html.jinja").render(
        title=title or "Drive",
        status=metrics["status"].replace("_", " "),
        metrics=metrics,
        refused_commands=result.refused_commands,
        headline=headline(metrics),
        events=_notable_events(result),
        event_names=EVENT_NAMES,
        map_svg=Markup(svg_map(result)),
        panels_svg=Markup(svg_panels(result)),
        snapshots=result.snapshots,
        slider=Markup(slider_data(result)),
        slider_script=Markup(environment.get_template("time_slider.js").render()),
        rows=[(name, _shown(metrics[name])) for name in names if name in metrics],
        meanings=MEANINGS,
    )


def _notable_events(result: DriveEvaluation) -> list[DriveEvent]:
    status, infractions = result.progress.status, result.progress.infractions
    events = [
        event
        for event in result.progress.events
        if event.name in infractions or event.name == status
    ]
    return events if any(event.name != COMPLETED for event in events) else []


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.3f}"
    if isinstance(value, dict):
        return ", ".join(f"{name} {count}" for name, count in value.items() if count) or "none"
    if isinstance(value, list):
        return ", ".join(value) or "none"
    return str(value)


def slider_data(result: DriveEvaluation) -> str:
    """Return the data as JSON that is safe in a script element.

    A drive with more ticks, entries or pictures than the page can hold is thinned evenly.
    """
    rows = result.rows
    step = len(rows) // _MAX_TICKS + 1
    ticks = {name: column[::step] for name, column in zip(COLUMNS, rows.T)}
    time_s = ticks.pop("time_s")
    start_s = float(time_s[0])
    ticks["time_s"] = time_s - start_s
    # The last planned speed at or before each tick, NaN where there is none.
    _, planned_mps, planned_s = np.array([(0.0, np.nan, -np.inf), *result.planned]).T
    ticks["target_mps"] = planned_mps[np.searchsorted(planned_s, time_s, side="right") - 1]
    texts = {}
    for key, words in (("reason", result.reasons[::step]), ("detail", result.details[::step])):
        texts[key] = names = sorted(set(words) - {""}, key=words.index)
        numbers = {name: number for number, name in enumerate(names)}
        ticks[key] = np.array([numbers.get(word, -1) for word in words])

    def entries(kind: str, convert: Any) -> list:
        found = result.scene.get(kind, [])
        return [
            [round(entry_s - start_s, 3), convert(content)]
            for entry_s, content in found[:: len(found) // _MAX_ENTRIES + 1]
        ]

    pictures = result.scene.get(PICTURE, [])
    while sum(len(jpeg) for _, jpeg in pictures) > _MAX_PICTURE_CHARACTERS:
        pictures = pictures[::2] if len(pictures) > 1 else []
    route = result.progress.route.points
    data = {
        "start_s": start_s,
        "ticks": {  # little-endian 32-bit floats
            name: base64.b64encode(column.astype("<f4").tobytes()).decode()
            for name, column in ticks.items()
        },
        "reasons": [[name, SPEED_REASONS.get(name, "")] for name in texts["reason"]],
        "details": texts["detail"],
        "route": _rounded(route[:: len(route) // _MAX_ROUTE_POINTS + 1]),
        "paths": entries(PATH, _rounded),
        "obstacles": entries(OBSTACLES, _rounded),
        "lights": entries(LIGHTS, lambda states: states),
        "lines": {number: _rounded([line[:3]])[0] for number, line in result.stop_lines.items()},
        "speed_colours": SPEED_COLOURS,
        "pictures": [[round(taken_s - start_s, 3), jpeg] for taken_s, jpeg in pictures],
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _rounded(rows: Any) -> list:
    """Return rows of finite numbers with three decimals."""
    return np.asarray(rows, dtype=float).round(3).tolist()
