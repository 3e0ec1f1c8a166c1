"""The page of the comparison, docs/controllers.md, from the stored peak errors."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Mapping, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sdc_experiments.snider import methods
from sdc_experiments.snider.courses import lane_change
from sdc_experiments.snider.methods import OWN_METHODS, own_name
from sdc_experiments.snider.study import (
    NEUTRAL,
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEER,
    UNDERSTEERING,
    Traces,
)
from sdc_sim.physics.vehicle_dynamics import GRAVITY_MPS2

TEXTBOOK, COMPENSATED = map(own_name, OWN_METHODS)
_GEOMETRIC = ("pure pursuit", "Stanley", "kinematic")
_COURSES = ("lane change", "figure-eight", "road course")


class PeakErrors(NamedTuple):
    """What the page shows of a drive, as in Trace."""

    peak_m: float
    centre_peak_m: float


# By name of the car, name of the course, name of the method, speed [m/s].
Peaks = Mapping[tuple, PeakErrors]


def to_json(traces: Traces) -> str:
    """Return the peak errors of all drives; that of a drive that left the road is null."""
    rows = []
    for key, trace in traces.items():
        errors = (trace.peak_m, trace.centre_peak_m)
        rows.append([*key, *(error if math.isfinite(error) else None for error in errors)])
    return "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n"


def from_json(text: str) -> Peaks:
    """Return the peak errors from the result of `to_json`."""
    return {
        tuple(key): PeakErrors(*(math.inf if error is None else error for error in (peak, centre)))
        for *key, peak, centre in json.loads(text)
    }


def metres(value: float) -> str:
    """Return an error [m] as the tables show it; "lost" for a drive that left the road."""
    if not math.isfinite(value):
        return "lost"
    return f"{value:.3f}" if value >= 0.0095 else f"{value:.4f}"


def page(peaks: Peaks) -> str:
    """Return the page."""

    def paper_table(car: str, course: str) -> str:
        """Return the table of the errors of each method's point, and of those of the paper."""
        rows = {}
        for method, paper in PAPER_M[course].items():
            found = (peaks[car, course, method, speed].peak_m for speed in SPEEDS_MPS)
            cells = zip(map(metres, found), paper)
            rows[method] = [cell + (f" ({value:g})" if value else "") for cell, value in cells]
        return _table(course, rows)

    def centre_table(car: str, course: str) -> str:
        """Return the table of the errors of the car's centre with every method."""
        rows = {}
        for method in [*PAPER_M["figure-eight"], TEXTBOOK, COMPENSATED]:
            found = (peaks[car, course, method, speed].centre_peak_m for speed in SPEEDS_MPS)
            rows[method] = [*map(metres, found)]
        rows[f"**{COMPENSATED}**"] = [f"**{cell}**" for cell in rows.pop(COMPENSATED)]
        return _table(course, rows)

    course = lane_change()
    curvature = max(abs(course.curvature_at(0.1 * i)) for i in range(1800))
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).with_name("templates")),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("controllers.md.jinja").render(
        paper_table=paper_table,
        centre_table=centre_table,
        courses=_COURSES,
        pursuit=f"{methods.PURE_PURSUIT_S:g}",
        stanley=f"{methods.STANLEY_PER_S:g}",
        kinematic=f"{methods.KINEMATIC_PER_M:g}",
        weights={name: f"{value:g}" for name, value in methods.LQR_WEIGHTS.items()},
        lateral=f"{curvature * SPEEDS_MPS[-1] ** 2:.1f}",
        understeer_mrad=f"{1e3 * UNDERSTEER:g}",
        degrees_per_g=f"{math.degrees(UNDERSTEER) * GRAVITY_MPS2:.1f}",
        neutral=agreement(peaks, NEUTRAL),
        understeering=agreement(peaks, UNDERSTEERING),
        factors={
            name: ", ".join(f"{_factor(peaks, name, speed):.1f}" for speed in SPEEDS_MPS)
            for name in PAPER_M
        },
    )


def _table(course: str, rows: Mapping[str, list[str]]) -> str:
    head = [course, *(f"{speed:g} m/s" for speed in SPEEDS_MPS)]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    return "\n".join(lines + [f"| {' | '.join([name, *cells])} |" for name, cells in rows.items()])


def agreement(peaks: Peaks, car: str) -> dict[str, Any]:
    """Compare the peak errors with those of the paper.

    Returns:
        beyond: the cells that differ by more than a factor of two
        cells: the number of all cells
        within: the largest factor of the other cells, as text
    """
    beyond, within = [], []
    for course, table in PAPER_M.items():
        for method, paper in table.items():
            for speed, value in zip(SPEEDS_MPS, paper):
                if value:
                    peak = peaks[car, course, method, speed].peak_m
                    factor = max(peak / value, value / peak)
                    if factor > 2.0:
                        beyond.append(f"{method}, {course}, {speed:g} m/s")
                    else:
                        within.append(factor)
    cells = len(beyond) + len(within)
    return {"beyond": beyond, "cells": cells, "within": f"{max(within):.3g}"}


def _factor(peaks: Peaks, course: str, speed: float) -> float:
    """Return the error of the best geometric method of the paper over that of the default."""
    best = min(peaks[UNDERSTEERING, course, name, speed].centre_peak_m for name in _GEOMETRIC)
    return best / peaks[UNDERSTEERING, course, COMPENSATED, speed].centre_peak_m
