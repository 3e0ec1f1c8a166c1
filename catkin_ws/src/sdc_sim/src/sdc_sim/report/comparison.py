"""Two reports side by side: the differences of their figures, and both drives in one picture."""

from __future__ import annotations

import csv
import json
import os
from typing import NamedTuple

import numpy as np

from sdc_sim.report.writer import companion

_COLOURS = ("#1f5fa8", "#d1341f")


class ReportReadError(ValueError):
    """A report cannot be read; the message names the file and the mend."""


class Report(NamedTuple):
    """A drive's figures and its trace: column by column, (n,) each; None where the trace is not there."""

    name: str
    figures: dict
    trace: dict


def load_report(path: str) -> Report:
    """Read a report.json, or the one in a folder. Raises ReportReadError."""
    if os.path.isdir(path):
        path = os.path.join(path, "report.json")
    try:
        with open(path, encoding="utf-8") as file:
            figures = json.load(file)
    except OSError as error:
        raise ReportReadError(
            f"{path}: {error.strerror}; name a report.json or its folder"
        ) from error
    except ValueError as error:
        raise ReportReadError(f"{path} is no report: {error}") from error
    if not isinstance(figures, dict) or "status" not in figures:
        raise ReportReadError(f"{path} is no report: it has no status")
    return Report(path, figures, _load_trace(companion(path, ".csv")))


def _load_trace(path: str):
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    try:
        return (
            {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}
            if rows
            else None
        )
    except (TypeError, ValueError) as error:
        raise ReportReadError(f"{path} is no trace of a drive: {error}") from error


def differences(a: dict, b: dict) -> list:
    """Rows (name, a, b, difference) of two reports' figures, as text; infractions count one by one, and a figure that both have
    equal has no difference."""
    a, b = _flat(a), _flat(b)
    return [
        (name, _shown(a.get(name)), _shown(b.get(name)), _difference(a.get(name), b.get(name)))
        for name in [*a, *(name for name in b if name not in a)]
    ]


def _flat(figures: dict) -> dict:
    flat = {}
    for name, value in figures.items():
        flat.update(
            {f"{name}.{key}": count for key, count in value.items()}
            if isinstance(value, dict)
            else {name: value}
        )
    return flat


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _difference(a, b) -> str:
    if a == b:
        return ""
    if not (_is_number(a) and _is_number(b)):
        return "differs"
    share = f" ({100.0 * (b - a) / abs(a):+.1f} %)" if a else ""
    return f"{b - a:+.4g}{share}"


def _shown(value) -> str:
    if _is_number(value):
        return (
            f"{value:.4g}" if isinstance(value, float) and abs(value) < 1000.0 else f"{value:.0f}"
        )
    return "-" if value is None else str(value)


def as_table(rows) -> str:
    """The rows as text, in columns."""
    rows = [("", "A", "B", "B - A"), *rows]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    return "\n".join(
        f"{name:<{widths[0]}}  {a:>{widths[1]}}  {b:>{widths[2]}}  {change}".rstrip()
        for name, a, b, change in rows
    )


def draw_overlay(path: str, a: Report, b: Report) -> None:
    """Both drives on one map, and their speed and errors over the distance. Raises OSError."""
    from sdc_sim.report.plots import new_figure, thinned  # Matplotlib is slow to load

    figure = new_figure(16.0, 9.0, 13.0)
    grid = figure.add_gridspec(
        3,
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
    first = None
    panels = []
    for row, (column, title) in enumerate(
        (
            ("speed_mps", "speed [m/s]"),
            ("cross_track_m", "cross-track error [m], left is positive"),
            ("steer", "steer, right is positive"),
        )
    ):
        axes = figure.add_subplot(grid[row, 1], sharex=first)
        first = first or axes
        axes.set_title(title, loc="left", fontsize="medium", pad=4)
        axes.grid(alpha=0.25)
        panels.append((axes, column))
    first.set_xlim(0.0, max(a.figures["route_length_m"], b.figures["route_length_m"]))
    panels[-1][0].set_xlabel("distance along the route [m]")
    for number, (report, letter, colour) in enumerate(zip((a, b), "AB", _COLOURS)):
        # The first lies wide and pale under the second, so that both are seen where they agree.
        style = {"color": colour, "linewidth": (5.0, 1.8)[number], "alpha": (0.45, 1.0)[number]}
        on_map.plot(report.trace["x_m"], report.trace["y_m"], label=letter, **style)
        for axes, column in panels:
            if column in report.trace:
                axes.plot(*thinned(report.trace["s_m"], report.trace[column]), **style)
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


def _summary(report: Report) -> str:
    figures = report.figures
    name = report.name if len(report.name) <= 60 else "..." + report.name[-57:]
    return (
        f"{name}   {figures['status']}, {figures['route_completion_percent']:.0f} % in {figures['duration_s']:.1f} s, error "
        f"{figures['cross_track_rms_m']:.3f} m RMS, {figures['cross_track_max_m']:.3f} m at worst"
    )
