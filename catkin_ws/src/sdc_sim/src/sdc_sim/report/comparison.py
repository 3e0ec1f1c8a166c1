"""Comparison of two reports: the differences of their metrics, and a plot of both drives."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from sdc_common.validation import is_number
from sdc_sim.report.writer import companion

# The first line is wide and pale, so that both are visible where they agree.
_STYLES: tuple[dict, ...] = (
    {"color": "#1f5fa8", "linewidth": 5.0, "alpha": 0.45},
    {"color": "#d1341f", "linewidth": 1.8},
)
# The columns of the panels.
_SHOWN = {"speed": "speed_mps", "cross-track error": "cross_track_m", "steer": "steer"}
_MAX_NAME_LENGTH = 60


class ReportReadError(ValueError):
    """A report cannot be read; the message names the file and what is wrong with it."""


class Report(NamedTuple):
    """The metrics of a drive and the columns of its trace, (n,) each; no trace: None."""

    name: str
    metrics: dict
    trace: dict | None


def load_report(path: str) -> Report:
    """Read a report.json, or the one in a folder.

    Raises:
        ReportReadError: the report or its trace cannot be read
    """
    if os.path.isdir(path):
        path = os.path.join(path, "report.json")
    try:
        with open(path, encoding="utf-8") as file:
            metrics = json.load(file)
        if not isinstance(metrics, dict) or "status" not in metrics:
            raise ValueError("it has no status")
    except OSError as error:
        raise ReportReadError(
            f"{path}: {error.strerror}; name a report.json or its folder"
        ) from error
    except ValueError as error:
        raise ReportReadError(f"{path} is not a report: {error}") from error
    return Report(path, metrics, _load_trace(companion(path, ".csv")))


def _load_trace(path: str) -> dict | None:
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        return None
    try:
        return {
            name: np.array([float(row[name] or "nan") for row in rows])
            for name in rows[0]
            if name != "reason"
        }
    except (TypeError, ValueError) as error:
        raise ReportReadError(f"{path} is not a trace of a drive: {error}") from error


def differences(a: dict, b: dict) -> list:
    """Return rows (name, a, b, difference) of the metrics of two reports, as text.

    Each infraction has a row. The difference of equal values is empty.
    """
    a, b = _flat(a), _flat(b)
    return [
        (name, _shown(a.get(name)), _shown(b.get(name)), _difference(a.get(name), b.get(name)))
        for name in {**a, **b}
    ]


def _flat(metrics: dict) -> dict:
    flat = {}
    for name, value in metrics.items():
        if isinstance(value, dict):
            flat.update({f"{name}.{key}": count for key, count in value.items()})
        else:
            flat[name] = value
    return flat


def _difference(a: Any, b: Any) -> str:
    if a == b:
        return ""
    if not (is_number(a) and is_number(b)):
        return "differs"
    share = f" ({100.0 * (b - a) / abs(a):+.1f} %)" if a else ""
    return f"{b - a:+.4g}{share}"


def _shown(value: Any) -> str:
    if is_number(value):
        small = isinstance(value, float) and abs(value) < 1000.0
        return f"{value:.4g}" if small else f"{value:.0f}"
    return "-" if value is None else str(value)


def as_table(rows: Iterable) -> str:
    """Return the rows of `differences` as text in columns."""
    rows = [("", "A", "B", "B - A"), *rows]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    return "\n".join(
        f"{name:<{widths[0]}}  {a:>{widths[1]}}  {b:>{widths[2]}}  {change}".rstrip()
        for name, a, b, change in rows
    )


def draw_overlay(path: str, a: Report, b: Report) -> None:
    """Draw two drives with a trace on one map, and their speed and errors over the distance.

    Raises:
        OSError: the image cannot be written
    """
    from sdc_sim.report.plots import PANELS, map_and_panels, new_figure, thinned  # slow to import

    figure = new_figure(16.0, 9.0, 13.0)
    shown = {title: panel for title, panel in PANELS.items() if title.startswith(tuple(_SHOWN))}
    on_map, panels = map_and_panels(figure, shown, 0.87)
    panels[0].set_xlim(0.0, max(a.metrics["route_length_m"], b.metrics["route_length_m"]))
    for number, (report, letter, style) in enumerate(zip((a, b), "AB", _STYLES)):
        trace = report.trace or {}
        on_map.plot(trace["x_m"], trace["y_m"], label=letter, **style)
        for axes, column in zip(panels, _SHOWN.values()):
            if column in trace:
                axes.plot(*thinned(trace["s_m"], trace[column]), **style)
        text = {"color": style["color"], "fontsize": 14, "weight": "bold", "va": "center"}
        figure.text(0.06, 0.955 - 0.045 * number, f"{letter}: {_summary(report)}", **text)
    on_map.legend(loc="best")
    figure.savefig(path, dpi=100, facecolor="white")


def _summary(report: Report) -> str:
    metrics, name = report.metrics, report.name
    if len(name) > _MAX_NAME_LENGTH:
        name = "..." + name[3 - _MAX_NAME_LENGTH :]
    return (
        f"{name}   {metrics['status']}, {metrics['route_completion_percent']:.0f} % in "
        f"{metrics['duration_s']:.1f} s, error {metrics['cross_track_rms_m']:.3f} m RMS, "
        f"{metrics['cross_track_max_m']:.3f} m at worst"
    )
