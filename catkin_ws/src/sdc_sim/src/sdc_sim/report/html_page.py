"""The page report.html, one file that needs no other."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.evaluation.route_progress import COMPLETED, DriveEvent
from sdc_sim.report.plots import EVENT_NAMES, headline, svg_map, svg_panels
from sdc_sim.report.time_slider import slider_data

# The meaning of each metric, in the order of the table.
MEANINGS = {
    "status": "how the drive ended",
    "route_length_m": "m, length of the route",
    "route_completion_percent": "%, of the route is behind the car",
    "duration_s": "s of simulated time",
    "ideal_duration_s": "s, least time under the planner's own limits",
    "time_ratio": "duration / ideal duration",
    "cross_track_rms_m": "m, distance from the route, root mean square",
    "cross_track_p95_m": "m, 95 % of the drive was closer to the route",
    "cross_track_max_m": "m, greatest distance from the route",
    "heading_rms_rad": "rad, heading error, root mean square",
    "speed_mean_mps": "m/s",
    "speed_max_mps": "m/s",
    "lateral_acceleration_max_mps2": "m/s², comfortable up to 4.89",
    "longitudinal_acceleration_max_mps2": "m/s², comfortable up to 2.40",
    "longitudinal_acceleration_min_mps2": "m/s², braking, comfortable down to -4.05",
    "jerk_max_mps3": "m/s³, comfortable up to 8.37",
    "comfortable": "accelerations and jerk are within nuPlan's thresholds",
    "off_lane_percent": "% of the driven distance with the car's centre off its lane",
    "infractions": "counts",
    "driving_score": "0..100, CARLA leaderboard 2.1",
    "wall_duration_s": "s on the wall clock",
    "real_time_factor": "simulated time / wall time",
    "ticks": "odometry messages",
    "missed_ticks": "odometry messages without a command of the same stamp",
    "ticks_by_stamp": "odometry messages that a command with their stamp answered",
    "ticks_by_order": "odometry messages that the next command, with no such stamp, answered",
    "unseen_s": "s of simulated time without odometry",
    "referee_restarts": "times that the referee restarted and resumed the drive",
    "world_restarts": "times that simulated time and the drive began again",
    "assumed_limits": "limits that /local_planner does not provide, taken from config/referee.yaml",
}


def write_html(path: str, result: DriveResult) -> None:
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
        map_svg=_svg(svg_map, result),
        panels_svg=_svg(svg_panels, result),
        snapshots=result.snapshots,
        slider=Markup(slider_data(result)),
        slider_script=Markup(environment.get_template("time_slider.js").render()),
        rows=[(name, _shown(metrics[name])) for name in names if name in metrics],
        meanings=MEANINGS,
    )
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def _svg(draw: Callable[[io.BytesIO, DriveResult], None], result: DriveResult) -> Markup:
    file = io.BytesIO()
    draw(file, result)
    text = file.getvalue().decode("utf-8")
    text = text[text.index("<svg") :]
    # Matplotlib uses the same ids in every drawing; on one page they must differ.
    for mark in ('id="', 'href="#', "url(#"):
        text = text.replace(mark, f"{mark}{draw.__name__}-")
    return Markup(text)


def _notable_events(result: DriveResult) -> list[DriveEvent]:
    status, infractions = result.metrics["status"], result.progress.infractions
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
