"""Writes a drive for people: report.png, and report.html that needs nothing but itself."""

from __future__ import annotations

import base64
import html
import io

from sdc_sim.evaluation.evaluator import DriveResult
from sdc_sim.report.plots import EVENT_NAMES, draw_glance, headline, svg_map, svg_panels

# What each figure means, in the order of the table.
MEANINGS = {
    "status": "how the drive ended",
    "route_length_m": "m, length of the route",
    "route_completion_percent": "%, of the route lies behind the car",
    "duration_s": "s of simulated time",
    "ideal_duration_s": "s, the least time under the planner's own limits",
    "time_ratio": "duration / ideal duration",
    "cross_track_rms_m": "m, distance from the route, root mean square",
    "cross_track_p95_m": "m, 95 % of the drive was closer to the route",
    "cross_track_max_m": "m, at worst",
    "heading_rms_rad": "rad, error of the heading, root mean square",
    "speed_mean_mps": "m/s",
    "speed_max_mps": "m/s",
    "lateral_acceleration_max_mps2": "m/s², comfortable up to 4.89",
    "longitudinal_acceleration_max_mps2": "m/s², speeding up, comfortable up to 2.40",
    "longitudinal_acceleration_min_mps2": "m/s², slowing down, comfortable down to -4.05",
    "jerk_max_mps3": "m/s³, comfortable up to 8.37",
    "comfortable": "all of them within nuPlan's thresholds",
    "off_lane_percent": "% of the driven distance with the car's centre off its lane",
    "infractions": "counts",
    "driving_score": "0..100, CARLA leaderboard 2.1",
    "wall_duration_s": "s on the wall clock",
    "real_time_factor": "times faster than the wall clock",
    "ticks": "odometry messages",
    "missed_ticks": "of them that no command with their stamp answered",
    "unseen_s": "s of simulated time in which no odometry was heard",
    "referee_restarts": "how often the referee had to go on with the drive",
    "world_restarts": "how often the world began anew, and the drive with it",
    "assumed_limits": "limits that the planner did not tell, taken from config/referee.yaml",
}

_STYLE = """
body { font-family: system-ui, "DejaVu Sans", sans-serif; color: #202124; margin: 0 auto; max-width: 1700px; padding: 1.2rem 2rem 3rem;
       font-size: 1.15rem; background: #fff; }
header { display: flex; flex-wrap: wrap; align-items: baseline; gap: 0.4rem 1.6rem; }
h1 { font-size: 3rem; margin: 0; } h2 { font-size: 1.7rem; margin: 2.2rem 0 0.6rem; }
h1.good { color: #2e8b57; } h1.bad { color: #c0392b; }
.tiles { display: flex; flex-wrap: wrap; gap: 0.8rem; margin: 1.2rem 0; }
.tile { background: #f1f3f4; border-radius: 0.6rem; padding: 0.7rem 1.2rem; flex: 1 1 9rem; }
.tile b { display: block; font-size: 1.9rem; white-space: nowrap; } .tile span { color: #5f6368; }
svg { width: 100%; height: auto; }
.camera { display: flex; flex-wrap: wrap; gap: 0.8rem; } figure { margin: 0; flex: 0 0 calc(33.3% - 0.6rem); }
figure img { width: 100%; border-radius: 0.4rem; display: block; } figcaption { color: #5f6368; }
table { border-collapse: collapse; } td, th { text-align: left; padding: 0.25rem 1.4rem 0.25rem 0; border-bottom: 1px solid #e3e5e8;
        vertical-align: top; }
td.value { font-variant-numeric: tabular-nums; font-weight: 600; }
"""


def write_png(path: str, result: DriveResult) -> None:
    """Draw report.png. Raises OSError."""
    draw_glance(path, result)


def write_html(path: str, result: DriveResult, snapshots) -> None:
    """Write report.html with everything in it. Raises OSError."""
    text = page(result, snapshots)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def page(result: DriveResult, snapshots) -> str:
    """The whole page; snapshots: the camera's Snapshots, or none."""
    figures = result.figures
    status = html.escape(figures["status"].replace("_", " "))
    tiles = "".join(
        f'<div class="tile"><b>{html.escape(value)}</b><span>{html.escape(name)}</span></div>'
        for name, value in headline(figures)
    )
    parts = [
        f'<header><h1 class="{"good" if figures["status"] == "completed" else "bad"}">{status}</h1>'
        f"<p>{figures['route_completion_percent']:.0f} % of {figures['route_length_m']:.0f} m "
        f"in {figures['duration_s']:.0f} s</p></header>",
        f'<div class="tiles">{tiles}</div>',
        _events(result),
        "<h2>The way</h2>",
        _svg(svg_map, result),
        "<h2>Over the distance</h2>",
        _svg(svg_panels, result),
        _camera(snapshots),
        "<h2>All figures</h2>",
        _table(figures),
    ]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>Drive: {status}</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def _svg(draw, result: DriveResult) -> str:
    file = io.BytesIO()
    draw(file, result)
    text = file.getvalue().decode("utf-8")
    # Two drawings on one page: each needs names of its own for what it refers to.
    text = text[text.index("<svg") :]
    for mark in ('id="', 'href="#', "url(#"):
        text = text.replace(mark, f"{mark}{draw.__name__}-")
    return text


def _events(result: DriveResult) -> str:
    events = [
        event
        for event in result.drive.events
        if event.name in result.drive.infractions or event.name == result.figures["status"]
    ]
    if not any(event.name != "completed" for event in events):
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(EVENT_NAMES.get(event.name, event.name))}</td><td>{event.time_s:.2f} s</td>"
        f"<td>{event.s_m:.1f} m</td><td>({event.x_m:.1f}, {event.y_m:.1f})</td></tr>"
        for event in events
    )
    return f"<h2>What happened</h2><table><tr><th></th><th>when</th><th>how far</th><th>where</th></tr>{rows}</table>"


def _camera(snapshots) -> str:
    if not snapshots:
        return ""
    shown = "".join(
        f'<figure><img alt="camera at {snapshot.percent:.0f} %" src="data:image/jpeg;base64,{base64.b64encode(snapshot.jpeg).decode()}">'
        f"<figcaption>{snapshot.percent:.0f} % of the route, {snapshot.time_s:.1f} s</figcaption></figure>"
        for snapshot in snapshots
    )
    return f'<h2>What the camera saw</h2><div class="camera">{shown}</div>'


def _table(figures: dict) -> str:
    names = [
        *(name for name in MEANINGS if name in figures),
        *(name for name in figures if name not in MEANINGS),
    ]
    rows = "".join(
        f'<tr><td>{html.escape(name)}</td><td class="value">{html.escape(_shown(figures[name]))}</td>'
        f"<td>{html.escape(MEANINGS.get(name, ''))}</td></tr>"
        for name in names
    )
    return f"<table>{rows}</table>"


def _shown(value) -> str:
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
