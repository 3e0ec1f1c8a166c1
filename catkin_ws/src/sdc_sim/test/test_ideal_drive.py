"""The times of the fastest drive along a route, compared with those worked out by hand."""

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits
from sdc_sim.evaluation.ideal_drive import IdealDrive

# The car drives 10 m/s everywhere; in the last metre its mean is 5 m/s.
LIMITS = SpeedLimits(
    cruise_mps=10.0, lateral_mps2=1e3, acceleration_mps2=1e6, braking_mps2=1e6, start_mps=10.0
)
DURATION_S = 99.0 / 10.0 + 1.0 / 5.0


@pytest.fixture(scope="module")
def straight():
    x = np.arange(101.0)
    return IdealDrive(Route(np.column_stack([x, np.zeros_like(x)])), LIMITS)


def bend(side):
    """Return the drive along half a circle with a radius of 20 m, to the left (1) or right (-1)."""
    angle = np.linspace(0.0, np.pi, 201)
    return IdealDrive(
        Route(20.0 * np.column_stack([np.sin(angle), side * (1.0 - np.cos(angle))])), LIMITS
    )


def test_time_along_a_straight_is_distance_by_speed(straight):
    assert straight.duration_s == pytest.approx(DURATION_S)
    assert straight.time_at(0.0) == 0.0
    assert straight.time_at(50.0) == pytest.approx(5.0)
    assert straight.time_at(100.0) == pytest.approx(DURATION_S)


def test_time_on_roads_with_limits_is_that_at_the_limits(straight):
    road_mps = np.repeat([5.0, 20.0], [51, 50])
    drive = IdealDrive(straight._route, LIMITS, road_mps)
    assert drive.time_at(50.0) == pytest.approx(10.0)
    assert drive.time_at(99.0) - drive.time_at(60.0) == pytest.approx(3.9)


def test_times_up_to_a_place_include_a_standing_start():
    x = np.arange(101.0)
    limits = SpeedLimits(**{**vars(LIMITS), "start_mps": 1.0})
    drive = IdealDrive(Route(np.column_stack([x, np.zeros_like(x)])), limits)
    assert drive.time_at(1.0) == pytest.approx(1.0 / 5.5)


@pytest.mark.parametrize(
    ("s_m", "least_s"),
    [
        *(([0.0, 50.0, 100.0], DURATION_S), ([20.0, 50.0, 100.0], DURATION_S - 2.0)),
        *(([0.0, 50.0, 80.0], DURATION_S - 2.0), ([0.0, 80.0, 50.0], DURATION_S - 2.0)),
        ([100.0], 1e-3),
    ],
)
def test_what_a_drive_leaves_out_takes_no_time(straight, s_m, least_s):
    assert straight.least_time_s(np.array(s_m), np.ones(len(s_m))) == pytest.approx(least_s)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("inside_m", "share_saved"), [(2.0, 0.1), (0.0, 0.0), (-2.0, 0.0), (30.0, 0.9)]
)
def test_inside_of_a_bend_the_way_is_shorter(side, inside_m, share_saved):
    drive = bend(side)
    middle = drive.time_at(40.0) - drive.time_at(20.0)
    s_m = np.linspace(0.0, 20.0 * np.pi, 201)
    cross_track_m = np.where((s_m > 20.0) & (s_m <= 40.0), side * inside_m, 0.0)
    least_s = drive.least_time_s(s_m, cross_track_m)
    assert drive.duration_s - least_s == pytest.approx(share_saved * middle, abs=0.02 * middle)
