import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_package.waypoint_search import WaypointSearch

STRAIGHT = WaypointSearch(np.column_stack([np.arange(20.0), np.zeros(20)]))
turned = np.arange(0.0, 1.5 * math.pi, 0.05)
BEND = WaypointSearch(np.column_stack([20.0 * np.sin(turned), 20.0 * (1.0 - np.cos(turned))]))


@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_nearest_waypoint_has_the_smallest_distance(x, y):
    distances = np.hypot(*(BEND.waypoints - (x, y)).T)
    assert distances[BEND.nearest(x, y)] == pytest.approx(distances.min())


@pytest.mark.parametrize(
    ("x", "first"),
    [
        (-3.0, 0),
        (0.0, 0),
        (0.4, 1),
        (0.6, 1),
        (4.9, 5),
        (5.0, 5),
        (5.1, 6),
        (18.8, 19),
        (19.0, 19),
        (25.0, 19),
    ],
)
def test_first_waypoint_ahead_on_a_straight(x, first):
    assert STRAIGHT.first_ahead(x, 0.3) == first


@given(st.floats(0.1, 4.5), st.floats(-1.5, 1.5))
def test_first_waypoint_ahead_in_a_bend_is_not_behind_the_car(angle, offset):
    x, y = (20.0 - offset) * math.sin(angle), 20.0 - (20.0 - offset) * math.cos(angle)
    assert turned[BEND.first_ahead(x, y)] == pytest.approx(angle + 0.025, abs=0.03)


def test_car_that_is_moved_back_to_the_start_drives_to_the_first_waypoint():
    search = WaypointSearch(STRAIGHT.waypoints)
    assert search.first_ahead(1.9, 0.0) == 2
    assert search.first_ahead(-0.4, 0.0) == 0


@pytest.mark.parametrize(
    ("index", "x", "y", "behind"),
    [
        (0, 10.5, 10.0, False),
        (0, 9.5, 10.0, True),
        (2, 8.5, 10.0, False),
        (2, 7.5, 10.0, True),
        (2, 8.0, 9.5, False),
        (2, 8.0, 10.5, True),
        (4, 8.0, 11.5, False),
        (4, 8.0, 12.5, True),
    ],
)
def test_waypoint_is_behind_a_car_that_has_passed_it_along_the_route(index, x, y, behind):
    """The route leads to the west and turns to the north at its third waypoint."""
    route = [[10.0, 10.0], [9.0, 10.0], [8.0, 10.0], [8.0, 11.0], [8.0, 12.0]]
    assert WaypointSearch(np.array(route)).is_behind(index, x, y) == behind
