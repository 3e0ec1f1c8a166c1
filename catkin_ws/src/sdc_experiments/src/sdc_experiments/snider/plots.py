"""The pictures of the comparison."""

from __future__ import annotations

import math
import os
from typing import Sequence

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from sdc_experiments.snider.courses import Course  # noqa: E402
from sdc_experiments.snider.methods import OWN_METHODS, own_name  # noqa: E402
from sdc_experiments.snider.study import (  # noqa: E402
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEERING,
    Traces,
)

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
    "figure.dpi": 100,
    "savefig.dpi": 130,
}
_LANE_CHANGE_SPEED_MPS = 15.0
# Larger errors are off the scale of the plot.
_MAX_PEAK_M = 1.5
_PAPER_MARKER = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 9,
    "markerfacecolor": "white",
    "markeredgewidth": 2.0,
}


def draw(traces: Traces, courses: Sequence[Course], folder: str) -> None:
    """Write the three pictures into a folder.

    Args:
        traces: all drives of the study
        courses: the courses, with the lane change first
        folder: an existing folder
    """
    with plt.rc_context(_STYLE):
        _draw_courses(courses, os.path.join(folder, "controllers_courses.png"))
        _draw_speeds(traces, os.path.join(folder, "controllers_speed.png"))
        _draw_lane_change(traces, courses[0], os.path.join(folder, "controllers_lane_change.png"))


def _draw_courses(courses: Sequence[Course], path: str) -> None:
    """Draw the courses from above."""
    figure, axes = plt.subplots(
        1, 3, figsize=(12.0, 3.6), gridspec_kw={"width_ratios": (1.5, 1.0, 1.3)}
    )
    for axis, course in zip(axes, courses):
        axis.plot(*zip(*course.line.points), color="#333333", linewidth=2.0)
        for start, end in course.measured:
            first, last = (course.line.segment_at(s)[0] for s in (start, end))
            axis.plot(
                *zip(*course.line.points[first:last]),
                color=COLOURS["Stanley"],
                linewidth=4.0,
                alpha=0.55,
                solid_capstyle="butt",
            )
        axis.plot(*course.line.points[0], "o", color=COLOURS["pure pursuit"])
        if course.name == "lane change":
            axis.set_ylim(-3.0, 6.5)
        else:
            axis.set_aspect("equal", adjustable="datalim")
        axis.set_title(f"{course.name}, {course.length_m:.0f} m")
        axis.set_xlabel("x [m]")
    axes[0].set_ylabel("y [m]")
    _save(figure, path)


def _draw_speeds(traces: Traces, path: str) -> None:
    """Draw the peak errors over speed, with the values of the paper."""
    figure, axes = plt.subplots(1, 2, figsize=(12.0, 5.4), sharey=True)
    for axis, course in zip(axes, PAPER_M):
        for method, paper in PAPER_M[course].items():
            peaks = [traces[UNDERSTEERING, course, method, v].peak_m for v in SPEEDS_MPS]
            shown = [peak if peak < _MAX_PEAK_M else math.nan for peak in peaks]
            axis.plot(SPEEDS_MPS, shown, color=COLOURS[method], linewidth=2.0, label=method)
            known = [(speed, value) for speed, value in zip(SPEEDS_MPS, paper) if value]
            axis.plot(*zip(*known), **_PAPER_MARKER, color=COLOURS[method])
        for method, colour in OWN_COLOURS.items():
            peaks = [traces[UNDERSTEERING, course, method, v].centre_peak_m for v in SPEEDS_MPS]
            axis.plot(SPEEDS_MPS, peaks, "--", color=colour, linewidth=2.0, label=method)
        axis.plot([], [], **_PAPER_MARKER, color="#777777", label="the paper, from its plots")
        axis.set_yscale("log")
        axis.set_ylim(0.0008, _MAX_PEAK_M)
        axis.set_yticks([0.001, 0.01, 0.1, 1.0])
        axis.set_yticklabels(["1 mm", "1 cm", "10 cm", "1 m"])
        axis.set_xticks(SPEEDS_MPS)
        axis.set_xlabel("speed [m/s]")
        axis.set_title(course)
    axes[0].set_ylabel("peak cross-track error (this project: of the centre)")
    axes[1].legend(loc="lower right", fontsize=9, framealpha=0.95)
    _save(figure, path)


def _draw_lane_change(traces: Traces, course: Course, path: str) -> None:
    """Draw the path of the car's centre through the lane change, and its error."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(12.0, 6.4), sharex=True)
    above.plot(
        *zip(*course.line.points),
        color="#bbbbbb",
        linewidth=7.0,
        label="the course",
        solid_capstyle="butt",
    )
    for method, colour in {**COLOURS, **OWN_COLOURS}.items():
        trace = traces[UNDERSTEERING, course.name, method, _LANE_CHANGE_SPEED_MPS]
        style = "--" if method in OWN_COLOURS else "-"
        above.plot(*trace.xy_m.T, style, color=colour, linewidth=1.8, label=method)
        below.plot(trace.xy_m[:, 0], trace.centre_error_m, style, color=colour, linewidth=1.8)
    above.set_ylabel("y [m]")
    above.set_title(f"double lane change at {_LANE_CHANGE_SPEED_MPS:g} m/s, the car's centre")
    above.legend(fontsize=9, loc="lower center", bbox_to_anchor=(0.41, 0.0))
    below.set_ylabel("cross-track error [m], left +")
    below.set_xlabel("x [m]")
    below.set_xlim(15.0, 160.0)
    _save(figure, path)


def _save(figure: plt.Figure, path: str) -> None:
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
