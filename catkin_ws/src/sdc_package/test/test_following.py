"""On a map: the speeds with which the car keeps its distance to road users on its path."""

import math

import numpy as np
import pytest

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.behaviour.following import Distances, following_caps, nearby
from sdc_package.obstacle_prediction import ObstacleMargins

MARGINS = ObstacleMargins(side_m=0.4, gap_m=5.0, car_front_m=2.35, car_width_m=2.0)
STRAIGHT = Route(np.column_stack([np.arange(201.0), np.zeros(201)]))
DISTANCES = Distances(MARGINS, 1.5, MARGINS.gap_m, braking_mps2=2.5, horizon_m=100.0)
# Centre of a car that stops 5 m behind the rear of a standing car at x = 50.
STOP = 50.0 - 2.35 - 5.0 - 2.35


def car(x=50.0, y=0.0, yaw=0.0, speed=0.0):
    return DetectedObstacle(x, y, yaw, 4.7, 2.0, speed)


def caps(vehicle, from_s=0.0, speed_mps=0.0, offset_m=0.0, distances=DISTANCES):
    s_m = STRAIGHT.s
    return following_caps(STRAIGHT, s_m, from_s, speed_mps, vehicle, lambda _: offset_m, distances)


def test_car_that_is_closer_than_its_time_gap_falls_back():
    far, near = (caps(car(speed=4.0), from_s=s).min() for s in (STOP - 6.0, STOP))
    assert (far, near) == (pytest.approx(4.0), pytest.approx(4.0 - 1.5 * 4.0 / 2.0))
    follows_closely = DISTANCES._replace(follow_gap_m=4.0)
    closer = caps(car(speed=4.0), from_s=STOP, distances=follows_closely).min()
    assert closer == pytest.approx(near + 0.5)


def test_car_falls_back_gently():
    gently = caps(car(speed=9.0), from_s=STOP, speed_mps=9.0).min()
    assert gently == pytest.approx(9.0 - 2.5)


def test_time_gap_does_not_matter_before_a_standing_car():
    np.testing.assert_array_equal(
        caps(car()), caps(car(), distances=DISTANCES._replace(time_gap_s=0.0))
    )


@pytest.mark.parametrize(("offset_m", "blocks"), [(0.0, True), (2.3, True), (2.5, False)])
def test_only_a_car_on_the_path_matters(offset_m, blocks):
    assert np.isfinite(caps(car(), offset_m=offset_m)).any() == blocks
    assert np.isfinite(caps(car(y=3.0), offset_m=3.0 - offset_m)).any() == blocks


def test_late_car_uses_the_gap_rather_than_brakes_hard():
    late, slow = (caps(car(x=80.0), from_s=66.0, speed_mps=v) for v in (8.0, 0.0))
    last_m = [float(STRAIGHT.s[np.flatnonzero(found > 0.0)[-1]]) for found in (slow, late)]
    assert last_m[0] < 80.0 - 2.0 - 5.0 - 2.35 < last_m[1] < 80.0 - 2.0 - 2.35


def test_car_does_not_brake_for_one_before_which_it_passes():
    crossing = car(x=75.0, y=6.0, yaw=-math.pi / 2.0, speed=3.0)
    assert not np.isfinite(caps(crossing, from_s=70.0, speed_mps=25.0)).any()
    assert caps(crossing, from_s=70.0, speed_mps=3.0).min() == 0.0
    # It may be in the way up to half a second before the time at which it is looked at.
    assert caps(crossing, from_s=70.0, speed_mps=15.0).min() == 0.0


@pytest.mark.parametrize(("speed", "is_near"), [(0.0, False), (20.0, True)])
def test_only_those_are_looked_at_that_can_come_near_in_two_seconds(speed, is_near):
    vehicle = car(x=50.0, speed=speed)
    assert (nearby(STRAIGHT, 0.0, [vehicle], 20.0) == [vehicle]) == is_near
