"""Acceptance limits of a drive, and the check of its report against them."""

from __future__ import annotations

import csv
import json
import os
from typing import Any, Mapping, Sequence

_STANDSTILL_MPS = 0.05


def violations(limits: Mapping[str, Any], report: dict, stops_m: Sequence[float] = ()) -> list[str]:
    """Return one line for each limit that a drive violates.

    Args:
        limits: `limits` of a scenario: `status` (completed if not given), `at_most` and
            `at_least`, bounds of metrics by name, where `infractions` is the sum of all kinds,
            and `stops`, places where the car must stop
        report: contents of report.json
        stops_m: distances along the route at which the car stopped [m]
    """
    lines = []
    status = limits.get("status", "completed")
    if report.get("status") != status:
        lines.append(f"status is {report.get('status')}, must be {status}")
    infractions = report.get("infractions") or {}
    metrics = {**report, **infractions, "infractions": sum(infractions.values())}
    for word, sign in (("most", 1.0), ("least", -1.0)):
        for name, bound in limits.get("at_" + word, {}).items():
            value = metrics.get(name)
            if value is None:
                lines.append(f"{name} is not in the report, at {word} {bound:g} is allowed")
            elif not sign * value <= sign * bound:
                lines.append(f"{name} is {value:.4g}, at {word} {bound:g} is allowed")
    for stop in limits.get("stops", ()):
        at_m, within_m = stop["at_m"], stop["within_m"]
        if not any(abs(place - at_m) <= within_m for place in stops_m):
            places = ", ".join(f"{place:.1f}" for place in stops_m) or "nowhere"
            lines.append(
                f"the car did not stop {at_m:g} m along the route "
                f"(within {within_m:g} m); it stopped at: {places}"
            )
    return lines


def read_report(path: str) -> tuple[dict, list[float]]:
    """Read a report.json and the trace next to it.

    Returns:
        contents of the report, and distances along the route at which the car stopped [m]

    Raises:
        OSError, ValueError: one of the files is missing or not valid.
    """
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    stops_m, was_moving = [], False
    with open(os.path.splitext(path)[0] + ".csv", encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            is_moving = float(row["speed_mps"]) >= _STANDSTILL_MPS
            if was_moving and not is_moving:
                stops_m.append(float(row["s_m"]))
            was_moving = is_moving
    return report, stops_m
