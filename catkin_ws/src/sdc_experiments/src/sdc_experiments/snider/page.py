"""The stored peak errors of the comparison, and the tables and picture of docs/controllers.md."""

from __future__ import annotations

import json
import math
import re
from typing import Any, Iterator, Mapping

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from sdc_experiments.snider.methods import OWN_METHODS, own_name  # noqa: E402
from sdc_experiments.snider.study import (  # noqa: E402
    NEUTRAL,
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEERING,
    PeakErrors,
    Peaks,
)

COURSES = ("lane change", "figure-eight", "road course")
COLOURS = {
    "pure pursuit": "#d95f02",
    "Stanley": "#1b9e77",
    "kinematic": "#7570b3",
    "LQR": "#c2a000",
    "LQR+FF": "#e7298a",
}
OWN_COLOURS = dict(zip(map(own_name, OWN_METHODS), ("#7f7f7f", "#111111")))
_STYLE = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "savefig.dpi": 130,
}
# Larger errors are off the scale of the plot.
_MAX_PEAK_M = 1.5
_TABLE = re.compile(rf"^\| (?:{'|'.join(COURSES)}) (?:\|.*\n)+", re.MULTILINE)


def to_json(peaks: Peaks) -> str:
    """Return the peak errors as text; that of a drive that left the road is null."""
    rows = [
        [*key, *(error if math.isfinite(error) else None for error in errors)]
        for key, errors in peaks.items()
    ]
    return "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n"


def from_json(text: str) -> Peaks:
    """Return the peak errors from the result of `to_json`."""
    return {
        tuple(key): PeakErrors(*(math.inf if error is None else error for error in (point, centre)))
        for *key, point, centre in json.loads(text)
    }


def updated(page: str, peaks: Peaks) -> str:
    """Return the page with the tables of these peak errors."""
    tables = _tables(peaks)
    return _TABLE.sub(lambda _: next(tables), page)


def _tables(peaks: Peaks) -> Iterator[str]:
    """Yield the tables in the order of the page: with the errors of the paper, of the centre."""
    for car in (NEUTRAL, UNDERSTEERING):
        for course, paper in PAPER_M.items():
            rows = {}
            for method, values in paper.items():
                found = (peaks[car, course, method, speed].point_m for speed in SPEEDS_MPS)
                known = (f" ({value:g})" if value else "" for value in values)
                rows[method] = [_metres(error) + note for error, note in zip(found, known)]
            yield _table(course, rows)
    for car in (NEUTRAL, UNDERSTEERING):
        for course in COURSES:
            rows = {
                method: [
                    _metres(peaks[car, course, method, speed].centre_m) for speed in SPEEDS_MPS
                ]
                for method in (*COLOURS, *OWN_COLOURS)
            }
            last = own_name(OWN_METHODS[-1])
            rows[f"**{last}**"] = [f"**{cell}**" for cell in rows.pop(last)]
            yield _table(course, rows)


def _metres(value: float) -> str:
    if not math.isfinite(value):
        return "lost"
    return f"{value:.3f}" if value >= 0.0095 else f"{value:.4f}"


def _table(course: str, rows: Mapping[str, list[str]]) -> str:
    head = [course, *(f"{speed:g} m/s" for speed in SPEEDS_MPS)]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    lines += [f"| {' | '.join([name, *cells])} |" for name, cells in rows.items()]
    return "\n".join(lines) + "\n"


def draw(peaks: Peaks, path: str) -> None:
    """Draw the peak errors over speed, with the values of the paper, into a PNG file."""
    with plt.rc_context(_STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(12.0, 5.4), sharey=True)
        for axis, course in zip(axes, PAPER_M):
            _draw_course(axis, peaks, course)
        axes[0].set_ylabel("peak cross-track error (this project: of the centre)")
        axes[1].legend(loc="lower right", fontsize=9, framealpha=0.95)
        figure.tight_layout()
        figure.savefig(path)
        plt.close(figure)


def _draw_course(axis: plt.Axes, peaks: Peaks, course: str) -> None:
    marker: dict[str, Any] = {"mfc": "white", "mew": 2.0, "ms": 9}
    for method, values in PAPER_M[course].items():
        found = [peaks[UNDERSTEERING, course, method, v].point_m for v in SPEEDS_MPS]
        shown = [peak if peak < _MAX_PEAK_M else math.nan for peak in found]
        axis.plot(SPEEDS_MPS, shown, color=COLOURS[method], linewidth=2.0, label=method)
        known = [math.nan if value is None else value for value in values]
        axis.plot(SPEEDS_MPS, known, "o", **marker, color=COLOURS[method])
    for method, colour in OWN_COLOURS.items():
        found = [peaks[UNDERSTEERING, course, method, v].centre_m for v in SPEEDS_MPS]
        axis.plot(SPEEDS_MPS, found, "--", color=colour, linewidth=2.0, label=method)
    axis.plot([], [], "o", **marker, color="#777777", label="the paper, from its plots")
    axis.set(yscale="log", ylim=(0.0008, _MAX_PEAK_M), xticks=SPEEDS_MPS, title=course)
    axis.set_yticks([0.001, 0.01, 0.1, 1.0], ["1 mm", "1 cm", "10 cm", "1 m"])
    axis.set_xlabel("speed [m/s]")
