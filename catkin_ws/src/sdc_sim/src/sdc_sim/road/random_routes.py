"""Random routes of straights and bends.

python3 -m sdc_sim.road.random_routes SEED FILE writes one of 1 km as a waypoint file.
"""

from __future__ import annotations

import math
import sys

import numpy as np


def random_route(seed: int) -> tuple[np.ndarray, bool]:
    """Return (N, 2) points 1 m apart and whether they are noisy.

    The route has straights and bends of 6 m radius or more. Every third route has no clothoids, and
    every fourth has the noise of a recording.
    """
    random = np.random.default_rng(seed)
    transition_m = 0.0 if seed % 3 == 0 else random.uniform(3.0, 8.0)
    pieces = [(15.0, 0.0)]
    for _ in range(random.integers(3, 7)):
        pieces += _bend(random, 6.0, transition_m) + [(random.uniform(2.0, 40.0), 0.0)]
    points = _points(random, pieces)
    noisy = seed % 4 == 0
    return points + random.normal(0.0, 0.02, points.shape) if noisy else points, noisy


def long_route(
    seed: int | np.random.Generator, length_m: float = 1000.0, least_radius_m: float = 8.0
) -> np.ndarray:
    """Return (N, 2) points 1 m apart of a route of at least this length, with clothoids.

    It starts with a straight of 15 m. Then follow bends and straights of 10 to 80 m. The radii of
    the bends are from `least_radius_m` to 100 m. It may cross itself.
    """
    random = np.random.default_rng(seed)
    pieces = [(15.0, 0.0)]
    while sum(length for length, _ in pieces) < length_m:
        bend = _bend(random, least_radius_m, random.uniform(3.0, 8.0))
        pieces += [*bend, (random.uniform(10.0, 80.0), 0.0)]
    return _points(random, pieces)


def _bend(random: np.random.Generator, least_radius_m: float, transition_m: float) -> list:
    """Return (length, curvature at the end) of the pieces of a bend."""
    radius = least_radius_m * (100.0 / least_radius_m) ** random.uniform()
    bend_m = radius * random.uniform(math.radians(20.0), math.radians(110.0))
    bend = random.choice([-1.0, 1.0]) / radius
    return [
        (transition_m, bend),
        (1e-6, bend),
        (max(1.0, bend_m - transition_m), bend),
        (transition_m, 0.0),
        (1e-6, 0.0),
    ]


def _points(random: np.random.Generator, pieces: list) -> np.ndarray:
    s = np.cumsum([0.0] + [length for length, _ in pieces])
    curvature = [0.0] + [end for _, end in pieces]
    fine = np.arange(0.0, s[-1], 0.01)
    heading = random.uniform(-math.pi, math.pi) + np.cumsum(np.interp(fine, s, curvature)) * 0.01
    return np.column_stack([np.cumsum(np.cos(heading)), np.cumsum(np.sin(heading))])[::100] * 0.01


def main() -> None:
    """Write a route of 1 km to a file."""
    if len(sys.argv) != 3 or not sys.argv[1].isdecimal():
        sys.exit("Usage: python3 -m sdc_sim.road.random_routes SEED FILE")
    # The y axis of a waypoint file points to the right.
    points = long_route(int(sys.argv[1])) * (1.0, -1.0)
    try:
        np.savetxt(sys.argv[2], points, fmt="%.4f", delimiter=",")
    except OSError as error:
        sys.exit(f"random_routes: {error}")


if __name__ == "__main__":
    main()
