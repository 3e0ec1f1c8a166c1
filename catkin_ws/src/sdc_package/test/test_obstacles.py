import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planned_roads import SETTINGS

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.obstacles import speed_caps

MARGINS = SETTINGS.obstacles
STRAIGHT = Route(np.column_stack([np.arange(201.0), np.zeros(201)]))
BRAKING = SETTINGS.limits.braking_mps2
# Centre of a car that stops 5 m behind the rear of a standing car at x = 50.
STOP = 50.0 - 2.35 - 5.0 - 2.35


def car(x=50.0, y=0.0, yaw=0.0, speed=0.0):
    return DetectedObstacle(x, y, yaw, 4.7, 2.0, speed)


def caps(*obstacles, from_s=0.0, horizon=100.0):
    return speed_caps(
        STRAIGHT, STRAIGHT.s, from_s, obstacles, MARGINS, BRAKING, horizon, time_gap_s=1.0
    )


def test_car_stops_a_gap_behind_a_standing_car():
    speed = caps(car())
    point = math.floor(STOP)
    assert (speed[STRAIGHT.s >= point] == 0.0).all()
    assert speed[30] == pytest.approx(math.sqrt(2.0 * BRAKING * (point - 30.0)))


def test_car_stops_behind_one_that_is_partly_after_the_end_of_the_route():
    speed = caps(car(x=203.0, y=0.2), from_s=150.0)
    assert speed[193] == 0.0 and speed[192] > 0.0
    assert np.isinf(caps(car(x=203.0, y=3.0), from_s=150.0)).all()


@pytest.mark.parametrize(
    ("offset", "blocks"),
    [(0.0, True), (2.3, True), (-2.3, True), (2.5, False), (-2.5, False), (5.0, False)],
)
def test_obstacle_next_to_the_lane_is_ignored(offset, blocks):
    assert np.isfinite(caps(car(y=offset))).any() == blocks


def test_car_ahead_is_followed_at_its_speed():
    speed = caps(car(speed=4.0))
    assert speed.min() == pytest.approx(4.0)
    assert speed[30] == pytest.approx(math.sqrt(16.0 + 2.0 * BRAKING * (STOP - 4.0 - 30.0)))


def test_car_that_is_closer_than_its_time_gap_falls_back():
    far, near = (caps(car(speed=4.0), from_s=s).min() for s in (STOP - 4.0, STOP))
    assert (far, near) == (pytest.approx(4.0), pytest.approx(4.0 - 1.0 * 4.0 / 2.0))


def test_car_stops_for_an_oncoming_car_on_its_lane():
    assert caps(car(yaw=math.pi, speed=4.0)).min() == 0.0


def test_car_stops_for_a_pedestrian_who_walks_towards_the_lane():
    walking = DetectedObstacle(40.0, -3.5, math.pi / 2, 0.5, 0.5, 1.4)
    standing = DetectedObstacle(40.0, -3.5, math.pi / 2, 0.5, 0.5, 0.0)
    leaving = DetectedObstacle(40.0, 3.5, math.pi / 2, 0.5, 0.5, 1.4)
    assert caps(walking).min() == 0.0
    assert not np.isfinite(caps(standing)).any()
    assert not np.isfinite(caps(leaving)).any()


def test_car_that_changes_to_the_lane_is_followed_from_where_it_is_now():
    """It is on the lane after 1 s; the caps hold for now."""
    speed = caps(car(x=40.0, y=-4.0, yaw=0.3, speed=5.0))
    along = 5.0 * math.cos(0.3)
    half_length = 0.5 * (4.7 * math.cos(0.3) + 2.0 * math.sin(0.3))
    room = 40.0 - half_length - 5.0 - 2.35 - 10.0 - along
    assert speed.min() == pytest.approx(along)
    assert speed[10] == pytest.approx(math.sqrt(along**2 + 2.0 * BRAKING * room))


def test_obstacle_behind_the_car_or_beyond_the_horizon_is_ignored():
    assert not np.isfinite(caps(car(), from_s=60.0)).any()
    assert not np.isfinite(caps(car(x=59.0), from_s=60.0)).any(), "next to the car's rear"
    assert not np.isfinite(caps(car(x=150.0), horizon=60.0)).any()


def test_car_that_follows_does_not_limit_the_speed():
    assert not np.isfinite(caps(car(x=45.0, speed=10.0), from_s=60.0)).any()
    assert not np.isfinite(caps(car(x=57.0, speed=10.0), from_s=60.0)).any(), "just passed"
    assert np.isfinite(caps(car(x=61.0, speed=10.0), from_s=60.0)).all(), "it overtakes"


def test_nearest_of_several_obstacles_limits_the_speed():
    np.testing.assert_array_equal(caps(car(), car(x=80.0), car(x=60.0, y=9.0)), caps(car()))


@pytest.mark.parametrize("number", range(6))
def test_obstacle_with_a_number_that_is_not_finite_is_refused(number):
    values = [0.0, 0.0, 0.0, 4.0, 2.0, 0.0]
    values[number] = math.nan
    with pytest.raises(ValueError, match="finite"):
        DetectedObstacle(*values)


@given(
    st.floats(0.0, 200.0),
    st.floats(-10.0, 10.0),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 15.0),
    st.floats(0.0, 150.0),
)
def test_speed_never_rises_towards_an_obstacle(x, y, yaw, speed, from_s):
    found = caps(car(x, y, yaw, speed), from_s=from_s)
    finite = found[np.isfinite(found)]
    assert (np.diff(finite) <= 1e-9).all()
    assert (finite >= 0.0).all()
