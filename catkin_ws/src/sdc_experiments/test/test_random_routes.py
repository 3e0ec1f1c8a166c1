"""Drive random routes from random starts: all are completed, and the car stays in its lane.

The nightly profile drives 400 of them: HYPOTHESIS_PROFILE=nightly ./test -k random_routes.
"""

import math
import os

import numpy as np
import pytest

from sdc_experiments.closed_loop import drive, drive_result
from sdc_sim.evaluation.route_progress import COMPLETED

pytestmark = pytest.mark.slow(25)

ROUTES = 400 if os.environ.get("HYPOTHESIS_PROFILE") == "nightly" else 60
HALF_LANE_M = 1.75
HALF_CAR_M = 1.0
JOIN_M = 30.0


def random_route(seed):
    """Return (N, 2) points 1 m apart and whether they are noisy.

    The route has straights and bends of 6 m radius or more. Every third route has no clothoids, and
    every fourth has the noise of a recording.
    """
    random = np.random.default_rng(seed)
    transition_m = 0.0 if seed % 3 == 0 else random.uniform(3.0, 8.0)
    s, curvature = [0.0, 15.0], [0.0, 0.0]
    for _ in range(random.integers(3, 7)):
        radius = 6.0 * (100.0 / 6.0) ** random.uniform()
        bend_m = radius * random.uniform(math.radians(20.0), math.radians(110.0))
        bend = random.choice([-1.0, 1.0]) / radius
        for length, end in (
            (transition_m, bend),
            (1e-6, bend),
            (max(1.0, bend_m - transition_m), bend),
            (transition_m, 0.0),
            (1e-6, 0.0),
            (random.uniform(2.0, 40.0), 0.0),
        ):
            s.append(s[-1] + length)
            curvature.append(end)
    fine = np.arange(0.0, s[-1], 0.01)
    heading = random.uniform(-math.pi, math.pi) + np.cumsum(np.interp(fine, s, curvature)) * 0.01
    points = np.column_stack([np.cumsum(np.cos(heading)), np.cumsum(np.sin(heading))])[::100] * 0.01
    noisy = seed % 4 == 0
    return points + random.normal(0.0, 0.02, points.shape) if noisy else points, noisy


def failure_of(seed):
    """Drive the route of a seed and return what is wrong with the drive, or None."""
    route, noisy = random_route(seed)
    random = np.random.default_rng([seed, 1])
    offset, turned = random.uniform(-2.0, 2.0), math.radians(random.uniform(-30.0, 30.0))
    start = {"left_m": offset, "turned_rad": turned}
    progress = drive_result(route=route, sim_options={"start": start}).progress
    if progress.status != COMPLETED:
        return f"seed {seed}: {progress.status} after {progress.completion_percent:.0f} %"
    joined = progress.column("s_m") > JOIN_M
    worst = float(np.abs(progress.column("cross_track_m")[joined]).max())
    room = HALF_LANE_M - HALF_CAR_M
    if worst < room:
        return None
    return f"seed {seed}: {worst:.2f} m off the centre of the lane (noisy: {noisy}), limit {room} m"


def test_car_completes_all_random_routes_in_its_lane():
    assert [failure for failure in map(failure_of, range(ROUTES)) if failure] == []


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_random_route_has_points_about_one_metre_apart(seed):
    route, noisy = random_route(seed)
    steps = np.hypot(*np.diff(route, axis=0).T)
    assert steps.min() > 0.8
    assert steps.max() < 1.2
    assert len(route) > 60
    assert noisy == (seed == 4)


@pytest.mark.parametrize("vehicle", ["tesla_model3", "ford_escort", "bmw_320i", "vw_vanagon"])
def test_default_gains_control_the_speed_of_every_car(vehicle):
    """The route is straight, because the steering map is that of the default car."""
    route = np.column_stack([np.arange(0.0, 301.0), np.zeros(301)])
    metrics = drive(route=route, sim_options={"vehicle": vehicle})
    assert metrics["status"] == COMPLETED
    assert metrics["time_ratio"] < 1.05
    assert metrics["speed_max_mps"] < 10.5
    assert metrics["jerk_max_mps3"] < 8.37
