"""For which pedestrians the car stops at a crosswalk."""

import math

import numpy as np
import pytest

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.road_line import road_route
from sdc_package.behaviour.road import crosswalks_on

ROUTE = road_route(np.column_stack([np.arange(100.0), np.zeros(100)]))
STRIPES = np.array([(48.0, -6.0), (52.0, -6.0), (52.0, 6.0), (48.0, 6.0)])
UP, DOWN = math.pi / 2.0, -math.pi / 2.0


@pytest.mark.parametrize(
    ("x_m", "y_m", "yaw_rad", "speed_mps", "kind", "stops"),
    [
        (50.0, 5.0, DOWN, 1.2, "pedestrian", True),
        (50.0, -7.0, UP, 1.2, "pedestrian", True),  # about to step on it
        (56.0, 9.0, 1.25 * math.pi, 1.5, "pedestrian", False),  # is on the way to it
        (54.8, 7.0, 1.25 * math.pi, 1.5, "pedestrian", True),  # is there in a second
        (50.0, 1.0, UP, 0.0, "pedestrian", True),  # stands before the car
        (50.0, 3.0, UP, 1.2, "pedestrian", False),  # has crossed
        (50.0, 7.0, UP, 0.0, "pedestrian", False),  # waits for something else
        (70.0, 5.0, DOWN, 1.2, "pedestrian", False),
        (50.0, 5.0, DOWN, 1.2, "car", False),
    ],
)
def test_car_stops_for_those_who_will_cross_its_lane(x_m, y_m, yaw_rad, speed_mps, kind, stops):
    (crosswalk,) = crosswalks_on(ROUTE, [STRIPES, STRIPES + (0.0, 40.0)])
    assert crosswalk.begin_m == pytest.approx(48.0) and crosswalk.end_m == pytest.approx(52.0)
    person = DetectedObstacle(x_m, y_m, yaw_rad, 0.5, 0.5, speed_mps, 1, kind)
    assert (crosswalk.user(ROUTE, [person]) is person) == stops
