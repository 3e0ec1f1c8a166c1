"""Draws a route from a list of straights and bends.

A bend is a clothoid, an arc and a clothoid, so that the curvature never jumps and a car can follow it without stopping to steer.
"""

from __future__ import annotations

import math

import numpy as np

# What may stand in an element, and its range.
ELEMENTS = {
    "straight_m": (0.01, 20_000.0),
    "left_deg": (0.1, 3600.0),
    "right_deg": (0.1, 3600.0),
    "radius_m": (0.5, 10_000.0),
    "transition_m": (0.01, 5_000.0),
}
LONGEST_M = 20_000.0

_STEP_M = 0.002
_ELEMENT_KEYS = (
    {"straight_m"},
    {"left_deg", "radius_m", "transition_m"},
    {"right_deg", "radius_m", "transition_m"},
)


class RouteSpecError(ValueError):
    """A list of straights and bends that cannot be drawn; the message names the element and the mend."""


def curvature_profile(elements):
    """Knots of the piecewise linear curvature of a list of elements: (s, curvature), metres and 1/m, positive to the left.

    Raises RouteSpecError for an unknown element, a number that is not positive, transitions that turn more than the bend, and a
    route longer than LONGEST_M.
    """
    s, curvature = [0.0], [0.0]

    def go(length_m, end_curvature):
        s.append(s[-1] + length_m)
        curvature.append(end_curvature)

    for number, element in enumerate(elements, start=1):
        where = f"element {number} ({element})"
        if not isinstance(element, dict) or set(element) not in _ELEMENT_KEYS:
            raise RouteSpecError(
                f"{where}: write {{straight_m: L}}, {{left_deg: A, radius_m: R, transition_m: T}} or right_deg"
            )
        if not all(
            isinstance(value, (int, float)) and math.isfinite(value) and value > 0
            for value in element.values()
        ):
            raise RouteSpecError(f"{where}: every number must be positive")
        if "straight_m" in element:
            go(element["straight_m"], 0.0)
        else:
            side = 1.0 if "left_deg" in element else -1.0
            angle = math.radians(element["left_deg" if side > 0 else "right_deg"])
            radius, transition = element["radius_m"], element["transition_m"]
            arc = radius * angle - transition
            if arc < 0.0:
                raise RouteSpecError(
                    f"{where}: the transitions alone turn {math.degrees(transition / radius):.0f} degrees; "
                    f"shorten transition_m to {radius * angle:.1f} or less"
                )
            go(transition, side / radius)
            if arc > 0.0:
                go(arc, side / radius)
            go(transition, 0.0)
        if s[-1] > LONGEST_M:
            raise RouteSpecError(
                f"{where}: the route is longer than {LONGEST_M / 1000:g} km here; draw a shorter one"
            )
    if len(s) < 2:
        raise RouteSpecError("the list has no element; add a straight or a bend")
    return np.array(s), np.array(curvature)


def check(elements) -> None:
    """Raises RouteSpecError where curvature_profile does, with the last element only in its message."""
    curvature_profile(elements)


def draw(spec) -> np.ndarray:
    """Rows of x, y (metres) and yaw (degrees) in CARLA coordinates (y to the right, yaw clockwise), `spacing_m` apart: (N, 3)."""
    knots, curvatures = curvature_profile(spec["elements"])
    length = knots[-1]
    s = np.linspace(0.0, length, int(math.ceil(length / _STEP_M)) + 1)
    step = s[1] - s[0]
    curvature = np.interp(s, knots, curvatures)
    heading = math.radians(spec["start"]["heading_deg"]) + _integral(curvature, step)
    x = spec["start"]["x_m"] + _integral(np.cos(heading), step)
    y = spec["start"]["y_m"] + _integral(np.sin(heading), step)
    at = np.linspace(0.0, length, int(round(length / spec["spacing_m"])) + 1)
    yaw = (np.degrees(np.interp(at, s, heading)) + 180.0) % 360.0 - 180.0
    return np.column_stack([np.interp(at, s, x), -np.interp(at, s, y), -yaw])


def csv_lines(rows) -> list:
    """The lines of a waypoint file, x,y,yaw-degrees, of what `draw` returned."""
    return [f"{x:.4f},{y:.4f},{yaw:.3f}\n" for x, y, yaw in rows]


def _integral(values: np.ndarray, step: float) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1])) * step])
