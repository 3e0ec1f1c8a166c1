"""The page report.html, one file that needs no other."""

from __future__ import annotations

import os
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.evaluation.route_progress import COMPLETED, DriveEvent
from sdc_sim.report.plots import EVENT_NAMES, headline, svg_map, svg_panels
from sdc_sim.report.time_slider import slider_data
from sdc_sim.yaml_document import packaged_config

# The meaning of each metric, in the order of the table.
MEANINGS = packaged_config("report_metrics")


def write_html(path: str, result: DriveEvaluation) -> None:
    """Write the page of a drive.

    Args:
        path: of the page
        result: the evaluated drive

    Raises:
        OSError: the file cannot be written
    """
    environment = Environment(
        loader=FileSystemLoader(os.path.join(os.path.dirname(__file__), "templates")),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    metrics = result.metrics
    names = [*MEANINGS, *(name for name in metrics if name not in MEANINGS)]
    text = environment.get_template("report.html.jinja").render(
        status=metrics["status"].replace("_", " "),
        metrics=metrics,
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
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


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
