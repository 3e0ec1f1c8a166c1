"""What a drive must keep, and which figures of its report fell short."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass, field
from typing import NamedTuple

STATUSES = ("completed", "collision", "off_route", "blocked", "timeout", "aborted")
INFRACTIONS = ("collision_pedestrian", "collision_vehicle", "collision_static", "red_light", "stop")
# The report's figures that are numbers, and so can have a bound.
FIGURES = (
    "route_length_m",
    "route_completion_percent",
    "duration_s",
    "wall_duration_s",
    "real_time_factor",
    "ticks",
    "missed_ticks",
    "cross_track_rms_m",
    "cross_track_p95_m",
    "cross_track_max_m",
    "heading_rms_rad",
    "speed_mean_mps",
    "speed_max_mps",
    "lateral_acceleration_max_mps2",
    "longitudinal_acceleration_max_mps2",
    "longitudinal_acceleration_min_mps2",
    "jerk_max_mps3",
    "ideal_duration_s",
    "time_ratio",
    "off_lane_percent",
    "driving_score",
)

_STANDSTILL_MPS = 0.05


class RequiredStop(NamedTuple):
    """A place where the car must come to rest on its way: metres along the route, and how exactly."""

    at_m: float
    within_m: float


@dataclass(frozen=True)
class AcceptanceLimits:
    """What a drive must keep: its status, figures of the report that have a bound (`infractions` is the sum of all kinds), and
    places where the car must have stood."""

    status: str = "completed"
    at_most: dict = field(default_factory=dict)
    at_least: dict = field(default_factory=dict)
    stops: tuple = ()


def violations(limits: AcceptanceLimits, report: dict, stood_at_m=()) -> list:
    """One line for each limit that the drive did not keep, with the figure and its bound; none where it kept them all.

    stood_at_m: where along the route the car stood.
    """
    lines = []
    if report.get("status") != limits.status:
        lines.append(f"status is {report.get('status')}, {limits.status} is wanted")
    infractions = report.get("infractions") or {}
    figures = {**report, **infractions, "infractions": sum(infractions.values())}
    for bounds, word, kept in (
        (limits.at_most, "most", lambda value, bound: value <= bound),
        (limits.at_least, "least", lambda value, bound: value >= bound),
    ):
        for name, bound in bounds.items():
            value = figures.get(name)
            if value is None:
                lines.append(f"{name} is not in the report, at {word} {bound:g} is allowed")
            elif not kept(value, bound):
                lines.append(f"{name} is {value:.4g}, at {word} {bound:g} is allowed")
    for stop in limits.stops:
        if not any(abs(place - stop.at_m) <= stop.within_m for place in stood_at_m):
            stood = ", ".join(f"{place:.1f}" for place in stood_at_m) or "nowhere"
            lines.append(
                f"the car did not stop {stop.at_m:g} m along the route (within {stop.within_m:g} m); it stood at: {stood}"
            )
    return lines


def read_report(path: str):
    """(the report's figures, where along the route the car stood in metres) of a report.json and the trace beside it.

    Raises OSError and ValueError where there is none.
    """
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    stood, moved = [], False
    with open(os.path.splitext(path)[0] + ".csv", encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            stands = float(row["speed_mps"]) < _STANDSTILL_MPS
            if stands and moved:
                stood.append(float(row["s_m"]))
            moved = not stands
    return report, stood
