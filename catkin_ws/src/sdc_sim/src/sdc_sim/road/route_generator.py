"""Generates a route from a list of straights and bends.

A bend is a clothoid, an arc and a clothoid: the curvature never jumps, and a car follows it without
stopping to steer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

LONGEST_M = 20_000.0

_STEP_M = 0.002
_ELEMENT_KEYS = (
    {"straight_m"},
    {"left_deg", "radius_m", "transition_m"},
    {"right_deg", "radius_m", "transition_m"},
)


class RouteSpecError(ValueError):
    """A list of straights and bends that is no route; the message names the element and the fix."""


def curvature_profile(elements: Iterable[Mapping]) -> tuple[np.ndarray, np.ndarray]:
    """Return the knots of the piecewise linear curvature of a list of elements.

    Args:
        elements: `{straight_m}`, `{left_deg, radius_m, transition_m}` or `{right_deg, ...}`

    Returns:
        arc lengths [m] and curvatures, positive to the left [1/m]

    Raises:
        RouteSpecError: an element is unknown, a number is not positive, the transitions turn more
            than the bend, or the route is longer than LONGEST_M
    """
    s, curvature = [0.0], [0.0]
    for number, element in enumerate(elements, start=1):
        where = f"element {number} ({element})"
        for length_m, end_curvature in _pieces(element, where):
            s.append(s[-1] + length_m)
            curvature.append(end_curvature)
        if s[-1] > LONGEST_M:
            raise RouteSpecError(
                f"{where}: the route is longer than {LONGEST_M / 1000:g} km here; "
                "shorten or remove elements"
            )
    if len(s) < 2:
        raise RouteSpecError("the list has no element; add a straight or a bend")
    return np.array(s), np.array(curvature)


def _pieces(element: Mapping, where: str) -> list[tuple[float, float]]:
    """Return (length, curvature at the end) of the pieces of an element."""
    if not isinstance(element, dict) or set(element) not in _ELEMENT_KEYS:
        raise RouteSpecError(
            f"{where}: unknown element; write {{straight_m: L}}, "
            "{left_deg: A, radius_m: R, transition_m: T} or right_deg"
        )
    if not all(
        isinstance(value, (int, float)) and math.isfinite(value) and value > 0
        for value in element.values()
    ):
        raise RouteSpecError(f"{where}: every number must be positive")
    if "straight_m" in element:
        return [(element["straight_m"], 0.0)]
    side = 1.0 if "left_deg" in element else -1.0
    angle = math.radians(element["left_deg" if side > 0 else "right_deg"])
    radius, transition = element["radius_m"], element["transition_m"]
    arc = radius * angle - transition
    if arc < 0.0:
        raise RouteSpecError(
            f"{where}: the transitions alone turn {math.degrees(transition / radius):.0f} degrees; "
            f"shorten transition_m to {radius * angle:.1f} or less"
        )
    pieces = [(transition, side / radius), (arc, side / radius), (transition, 0.0)]
    return [piece for piece in pieces if piece[0] > 0.0]


def generate_route(spec: Mapping) -> np.ndarray:
    """Return the points of a route in CARLA coordinates (y to the right, yaw clockwise).

    Args:
        spec: `elements` as for `curvature_profile`, `start` with x_m, y_m and heading_deg, and
            `spacing_m`

    Returns:
        (N, 3) rows of x [m], y [m] and yaw [degrees], `spacing_m` apart
    """
    knots, curvatures = curvature_profile(spec["elements"])
    length = knots[-1]
    s = np.linspace(0.0, length, int(math.ceil(length / _STEP_M)) + 1)
    step = s[1] - s[0]
    curvature = np.interp(s, knots, curvatures)
    heading = math.radians(spec["start"]["heading_deg"]) + _integral(curvature, step)
    x = spec["start"]["x_m"] + _integral(np.cos(heading), step)
    y = spec["start"]["y_m"] + _integral(np.sin(heading), step)
    places_m = np.linspace(0.0, length, int(round(length / spec["spacing_m"])) + 1)
    yaw = (np.degrees(np.interp(places_m, s, heading)) + 180.0) % 360.0 - 180.0
    return np.column_stack([np.interp(places_m, s, x), -np.interp(places_m, s, y), -yaw])


def csv_lines(rows: np.ndarray) -> list[str]:
    """Return the lines of a waypoint file, x,y,yaw, of the rows of `generate_route`."""
    return [f"{x:.4f},{y:.4f},{yaw:.3f}\n" for x, y, yaw in rows]


def _integral(values: np.ndarray, step: float) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1])) * step])
