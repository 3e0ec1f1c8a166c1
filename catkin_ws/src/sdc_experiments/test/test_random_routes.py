"""Drive random routes from random starts: all are completed, and the car stays in its lane.

The nightly profile drives 400 of them: HYPOTHESIS_PROFILE=nightly ./test -k random_routes.
"""

import math
import os

import numpy as np
import pytest

from sdc_experiments.closed_loop import drive, drive_result
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.road.random_routes import random_route

pytestmark = pytest.mark.slow(25)

ROUTES = 400 if os.environ.get("HYPOTHESIS_PROFILE") == "nightly" else 10
HALF_LANE_M = 1.75
HALF_CAR_M = 1.0
JOIN_M = 30.0


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


@pytest.mark.parametrize("vehicle", ["tesla_model3", "ford_escort", "bmw_320i", "vw_vanagon"])
def test_default_gains_control_the_speed_of_every_car(vehicle):
    """The route is straight, because the steering map is that of the default car."""
    route = np.column_stack([np.arange(0.0, 301.0), np.zeros(301)])
    metrics = drive(route=route, sim_options={"vehicle": vehicle})
    assert metrics["status"] == COMPLETED
    assert metrics["time_ratio"] < 1.05
    assert metrics["speed_max_mps"] < 10.5
    assert metrics["jerk_max_mps3"] < 8.37
