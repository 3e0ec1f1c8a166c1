"""The detector reports each crossed line once, by its kind, on the driven pass only."""

import math

import numpy as np
import pytest

from sdc_common.geometry.road_line import road_route
from sdc_sim.physics.collision import Rectangle
from sdc_sim.road.lane_invasion import BROKEN, SOLID, LaneInvasionDetector

STRAIGHT = road_route(np.column_stack([np.arange(0.0, 300.0), np.zeros(300)]))


def car(x, y, yaw=0.0):
    return Rectangle(x, y, yaw, 4.7, 2.0)


def crossed(road, poses):
    detector = LaneInvasionDetector(road)
    return [line for pose in poses for line in detector.update(car(*pose))]


def test_driving_in_the_lane_crosses_no_line():
    weaving = [(x, 0.7 * math.sin(0.1 * x)) for x in np.arange(0.0, 290.0, 0.5)]
    assert crossed(STRAIGHT, weaving) == []


@pytest.mark.parametrize(
    ("to_y", "lines"), [(1.0, [BROKEN]), (-1.0, [SOLID]), (3.5, [BROKEN]), (5.5, [BROKEN, SOLID])]
)
def test_lane_change_crosses_the_lines_in_between(to_y, lines):
    assert crossed(STRAIGHT, [(20.0 + x, to_y * x / 50.0) for x in range(51)]) == lines


def test_repeated_crossing_counts_only_after_leaving_the_line():
    there_and_back = [(x, 1.5 * math.sin(math.pi * x / 50.0)) for x in np.arange(0.0, 101.0, 0.5)]
    assert crossed(STRAIGHT, there_and_back) == [BROKEN, SOLID]
    vibrating = [(50.0 + 0.1 * n, 0.75 + 0.03 * (-1) ** n) for n in range(200)]
    assert crossed(STRAIGHT, [(50.0, 0.0), *vibrating]) == [BROKEN]


@pytest.mark.parametrize("radius_m", [12.0, 40.0])
def test_bend_driven_in_its_lane_crosses_no_line(radius_m):
    angle = np.arange(0.0, 1.5 * math.pi, 1.0 / radius_m)
    bend = road_route(radius_m * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)]))
    a = np.arange(0.1, 4.5, 0.3 / radius_m)
    places = radius_m * np.sin(a), radius_m * (1.0 - np.cos(a))
    assert crossed(bend, np.column_stack([*places, a]).tolist()) == []


def test_lines_of_a_crossing_road_do_not_count():
    # The route crosses itself at right angles: east, around, and south across the first stretch.
    route = [(x, 0) for x in range(101)] + [(100, y) for y in range(1, 51)]
    route += [(x, 50) for x in range(99, 49, -1)] + [(50, y) for y in range(49, -60, -1)]
    road = road_route(np.array(route, float))
    assert crossed(road, [(x, 0.0) for x in np.arange(5.0, 90.0, 0.5)]) == []


def test_moved_car_crosses_no_line():
    detector = LaneInvasionDetector(STRAIGHT)
    detector.update(car(20.0, 0.0))
    detector.reset()
    assert detector.update(car(200.0, 1.5)) == []
    assert detector.update(car(201.0, 3.5)) == []
