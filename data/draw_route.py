#!/usr/bin/env python3
"""Draws a route from a readable list of straights and bends: data/draw_route.py data/town.yaml data/waypoints.csv

A bend is a clothoid, an arc and a clothoid, so that the curvature never jumps and a car can follow it without stopping to steer.
The file lists what a driver would say; data/town.yaml is an example with every word explained.
"""
from __future__ import annotations

import argparse
import math
import sys

import numpy as np
import yaml

_STEP_M = 0.002
_ELEMENT_KEYS = ({"straight_m"}, {"left_deg", "radius_m", "transition_m"}, {"right_deg", "radius_m", "transition_m"})


class RouteSpecError(ValueError):
    """A list of straights and bends that cannot be drawn; the message names the element and the mend."""


def curvature_profile(elements):
    """Knots of the piecewise linear curvature of a list of elements: (s, curvature), metres and 1/m, positive to the left.

    Raises RouteSpecError for an unknown element, a number that is not positive, and transitions that turn more than the bend.
    """
    s, curvature = [0.0], [0.0]

    def go(length_m, end_curvature):
        s.append(s[-1] + length_m)
        curvature.append(end_curvature)

    for number, element in enumerate(elements, start=1):
        where = f"element {number} ({element})"
        if not isinstance(element, dict) or set(element) not in _ELEMENT_KEYS:
            raise RouteSpecError(f"{where}: write {{straight_m: L}}, {{left_deg: A, radius_m: R, transition_m: T}} or right_deg")
        if not all(isinstance(value, (int, float)) and math.isfinite(value) and value > 0 for value in element.values()):
            raise RouteSpecError(f"{where}: every number must be positive")
        if "straight_m" in element:
            go(element["straight_m"], 0.0)
            continue
        side = 1.0 if "left_deg" in element else -1.0
        angle = math.radians(element["left_deg" if side > 0 else "right_deg"])
        radius, transition = element["radius_m"], element["transition_m"]
        arc = radius * angle - transition
        if arc < 0.0:
            raise RouteSpecError(f"{where}: the transitions alone turn {math.degrees(transition / radius):.0f} degrees; "
                                 f"shorten transition_m to {radius * angle:.1f} or less")
        go(transition, side / radius)
        if arc > 0.0:
            go(arc, side / radius)
        go(transition, 0.0)
    if len(s) < 2:
        raise RouteSpecError("the list has no element; add a straight or a bend")
    return np.array(s), np.array(curvature)


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


def _integral(values: np.ndarray, step: float) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1])) * step])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("spec", help="YAML list of straights and bends")
    parser.add_argument("csv", help="where to write x,y,yaw-degrees in CARLA coordinates")
    arguments = parser.parse_args()
    try:
        with open(arguments.spec, encoding="utf-8") as file:
            rows = draw(yaml.safe_load(file))
    except (OSError, yaml.YAMLError, RouteSpecError) as error:
        print(f"{arguments.spec}: {error}", file=sys.stderr)
        return 1
    except (KeyError, TypeError) as error:
        print(f"{arguments.spec}: {error} is missing or wrong; see data/town.yaml for an example", file=sys.stderr)
        return 1
    with open(arguments.csv, "w", encoding="utf-8") as file:
        file.writelines(f"{x:.4f},{y:.4f},{yaw:.3f}\n" for x, y, yaw in rows)
    length = np.hypot(*np.diff(rows[:, :2], axis=0).T).sum()
    print(f"{arguments.csv}: {len(rows)} waypoints, {length:.1f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
