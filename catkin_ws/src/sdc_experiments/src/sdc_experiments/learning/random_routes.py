"""Random routes of straights and bends."""

from __future__ import annotations

import math

import numpy as np

_STEP_M = 0.1
_SPACING_M = 1.0


def random_route(random: np.random.Generator, length_m: float = 300.0) -> np.ndarray:
    """Return the waypoints of a random route, 1 m apart.

    It starts with a straight of 15 m. Then follow straights of 5 to 40 m and bends of 8 to 100 m
    radius that turn by 20 to 110 degrees, with clothoids of 5 to 10 m. It may cross itself.

    Args:
        random: source of the random numbers
        length_m: length of the route [m]

    Returns:
        (N, 2) points [m]
    """
    s, curvature = [0.0, 15.0], [0.0, 0.0]
    while s[-1] < length_m:
        radius = 8.0 * (100.0 / 8.0) ** random.uniform()
        bend = random.choice((-1.0, 1.0)) / radius
        transition = random.uniform(5.0, 10.0)
        turn_m = radius * random.uniform(math.radians(20.0), math.radians(110.0))
        for length, end in (
            (transition, bend),
            (max(1.0, turn_m - transition), bend),
            (transition, 0.0),
            (random.uniform(5.0, 40.0), 0.0),
        ):
            s.append(s[-1] + length)
            curvature.append(end)
    fine = np.arange(0.0, length_m + 0.5 * _STEP_M, _STEP_M)
    turns = np.interp(fine[:-1] + 0.5 * _STEP_M, s, curvature) * _STEP_M
    heading = random.uniform(-math.pi, math.pi) + np.append(0.0, np.cumsum(turns))
    middle = 0.5 * (heading[:-1] + heading[1:])
    steps = _STEP_M * np.column_stack([np.cos(middle), np.sin(middle)])
    points = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    return points[:: round(_SPACING_M / _STEP_M)]
