"""A stop line counts as crossed on red by what the light showed then, in whatever order both are heard."""

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.physics.traffic_lights import GREEN, RED, YELLOW

ROUTE = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))
FRONT_M = 2.0
LINE_M = 50.0
# The front is on the line with the centre at 48 m: crossed at the stamp 49 of a car that drives a metre a stamp.
CROSSING = 49


def watch(x=LINE_M, y=0.0):
    lights = RedLightDetector(FRONT_M)
    lights.place({7: (x, y, 1.75)})
    return lights


def drive(lights, states, first=1, last=100, late=0):
    """The sum of the crossings on red of a car that drives a metre a stamp; `states` come `late` stamps after their odometry, or
    before it."""
    count = 0
    for stamp in range(first, last):
        for said in (stamp,) if late <= 0 else ():
            count += lights.show(said, {7: states(said)})
        count += lights.move(stamp, ROUTE, float(stamp) - 0.5)
        if late > 0 and stamp > late:
            count += lights.show(stamp - late, {7: states(stamp - late)})
    return count


@pytest.mark.parametrize("late", [0, 1, 5])
@pytest.mark.parametrize(
    ("red", "count"),
    [((0, 200), 1), ((0, CROSSING), 0), ((CROSSING, 200), 1), ((CROSSING + 1, 200), 0)],
)
def test_the_state_at_the_crossing_counts(red, count, late):
    assert (
        drive(watch(), lambda stamp: RED if red[0] <= stamp < red[1] else GREEN, late=late) == count
    )


@pytest.mark.parametrize("state", [YELLOW, GREEN, 3, 4])
def test_only_red_counts(state):
    assert drive(watch(), lambda stamp: state) == 0


def test_line_on_another_lane_or_beyond_the_drive_does_not_count():
    assert drive(watch(y=3.5), lambda stamp: RED) == 0
    assert drive(watch(), lambda stamp: RED, last=40) == 0


def test_who_stands_on_the_line_and_rolls_back_crosses_it_once():
    lights = watch()
    lights.show(1, {7: RED})
    count = sum(
        lights.move(stamp, ROUTE, s)
        for stamp, s in enumerate((47.0, 48.5, 47.5, 48.5, 47.0, 49.0), start=2)
    )
    assert count + lights.show(9, {7: RED}) == 1


def test_without_stamps_what_was_heard_last_counts():
    lights = watch()
    assert lights.show(0, {7: RED}) == 0
    assert sum(lights.move(stamp, ROUTE, float(stamp)) for stamp in range(40, 60)) == 1
    lights.begin()
    lights.show(0, {7: GREEN})
    assert sum(lights.move(stamp, ROUTE, float(stamp - 20)) for stamp in range(60, 80)) == 0


def test_states_without_stamps_are_not_heard_beside_those_with():
    lights = watch()
    lights.show(1, {7: RED})
    lights.show(0, {7: GREEN})
    assert drive(lights, lambda stamp: RED, first=2) == 1


def test_where_the_car_was_not_seen_nothing_is_judged():
    lights = watch()
    lights.show(1, {7: RED})
    lights.move(2, ROUTE, 20.0)
    lights.begin()
    assert lights.move(3, ROUTE, 60.0) + lights.show(3, {7: RED}) == 0
