"""Comparison of two reports: the differences of their metrics, and a plot of both drives."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sdc_sim.report.writer import companion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#1f5fa8", "#d1341f")
_PANELS = (
    ("speed_mps", "speed [m/s]"),
    ("cross_track_m", "cross-track error [m], left is positive"),
    ("steer", "steer, right is positive"),
)
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
    except OSError as error:
        raise ReportReadError(
            f"{path}: {error.strerror}; name a report.json or its folder"
        ) from error
    except ValueError as error:
        raise ReportReadError(f"{path} is not a report: {error}") from error
    if not isinstance(metrics, dict) or "status" not in metrics:
        raise ReportReadError(f"{path} is not a report: it has no status")
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
        for name in [*a, *(name for name in b if name not in a)]
    ]


def _flat(metrics: dict) -> dict:
    flat = {}
    for name, value in metrics.items():
        if isinstance(value, dict):
            flat.update({f"{name}.{key}": count for key, count in value.items()})
        else:
            flat[name] = value
    return flat


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _difference(a: Any, b: Any) -> str:
    if a == b:
        return ""
    if not (_is_number(a) and _is_number(b)):
        return "differs"
    share = f" ({100.0 * (b - a) / abs(a):+.1f} %)" if a else ""
    return f"{b - a:+.4g}{share}"


def _shown(value: Any) -> str:
    if _is_number(value):
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
    """Draw both drives on one map, and their speed and errors over the distance.

    Args:
        path: of the image
        a: the first report, with a trace
        b: the second report, with a trace

    Raises:
        OSError: the image cannot be written
    """
    from sdc_sim.report.plots import new_figure, thinned  # Matplotlib is slow to import

    figure = new_figure(16.0, 9.0, 13.0)
    on_map, panels = _overlay_axes(figure)
    panels[0].set_xlim(0.0, max(a.metrics["route_length_m"], b.metrics["route_length_m"]))
    for number, (report, letter, colour) in enumerate(zip((a, b), "AB", _COLOURS)):
        trace = report.trace or {}
        # The first line is wide and pale, so that both are visible where they agree.
        style: dict = {
            "color": colour,
            "linewidth": (5.0, 1.8)[number],
            "alpha": (0.45, 1.0)[number],
        }
        on_map.plot(trace["x_m"], trace["y_m"], label=letter, **style)
        for axes, (column, _) in zip(panels, _PANELS):
            if column in trace:
                axes.plot(*thinned(trace["s_m"], trace[column]), **style)
        figure.text(
            0.06,
            0.955 - 0.045 * number,
            f"{letter}: {_summary(report)}",
            color=colour,
            fontsize=14,
            weight="bold",
            va="center",
        )
    on_map.legend(loc="best")
    figure.savefig(path, dpi=100, facecolor="white")


def _overlay_axes(figure: Figure) -> tuple[Axes, list[Axes]]:
    grid = figure.add_gridspec(
        len(_PANELS),
        2,
        width_ratios=(1.0, 1.2),
        left=0.06,
        right=0.985,
        top=0.87,
        bottom=0.08,
        wspace=0.14,
        hspace=0.3,
    )
    on_map = figure.add_subplot(grid[:, 0])
    on_map.set_aspect("equal", adjustable="datalim")
    on_map.margins(0.06)
    on_map.set_xlabel("x [m]")
    on_map.set_ylabel("y [m]")
    panels: list = []
    for row, (_, title) in enumerate(_PANELS):
        axes = figure.add_subplot(grid[row, 1], sharex=panels[0] if panels else None)
        axes.set_title(title, loc="left", fontsize="medium", pad=4)
        axes.grid(alpha=0.25)
        panels.append(axes)
    panels[-1].set_xlabel("distance along the route [m]")
    return on_map, panels


def _summary(report: Report) -> str:
    metrics, name = report.metrics, report.name
    if len(name) > _MAX_NAME_LENGTH:
        name = "..." + name[3 - _MAX_NAME_LENGTH :]
    return (
        f"{name}   {metrics['status']}, {metrics['route_completion_percent']:.0f} % in "
        f"{metrics['duration_s']:.1f} s, error {metrics['cross_track_rms_m']:.3f} m RMS, "
        f"{metrics['cross_track_max_m']:.3f} m at worst"
    )
