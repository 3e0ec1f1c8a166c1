"""When the car brakes as hard as it can: for a contact that a firm stop no longer avoids."""

import numpy as np
import pytest
from planned_roads import street_parameters

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.road_line import road_route
from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network_file import load_network
from sdc_package.behaviour.streets import StreetBehaviour, StreetMargins
from sdc_testing.street_maps import needs_maps

pytestmark = needs_maps
PARAMETERS = street_parameters()
MARGINS = StreetMargins(**PARAMETERS["streets"])
BRAKING_MPS2 = PARAMETERS["braking_mps2"]
SPEED_MPS, TICK_S, WIDTH_M = 8.0, 0.05, 3.5
QUARTER = 0.5 * np.pi


@pytest.fixture(scope="module", name="street")
def _street():
    """A network, a route, and where 60 m straight road with an oncoming lane begin on it."""
    network = load_network(map_file("town"))
    graph = LaneGraph(network)
    for seed in range(20):
        start, goal = drawn_places(graph, seed)
        route = road_route(plan_mission(graph, [goal], *start).points_m)
        for s_m in range(20, int(route.length_m) - 60, 10):
            ahead = (route.s > s_m - 20.0) & (route.s < s_m + 60.0)
            (x, y), yaw = route.line.point_at(s_m + 20.0), route.line.heading_at(s_m)
            x, y = x - WIDTH_M * np.sin(yaw), y + WIDTH_M * np.cos(yaw)
            if np.ptp(route.heading[ahead]) < 0.02 and network.nearest(x, y, yaw + np.pi, 1.0):
                return network, route, float(s_m)
    raise AssertionError("the town has no straight road")


def car_at(street, ahead_m, left_m, turned_rad, speed_mps, number=7):
    _, route, s_m = street
    (x, y), yaw = route.line.point_at(s_m), route.line.heading_at(s_m)
    x += ahead_m * np.cos(yaw) - left_m * np.sin(yaw)
    y += ahead_m * np.sin(yaw) + left_m * np.cos(yaw)
    return DetectedObstacle(x, y, yaw + turned_rad, 4.5, 1.8, speed_mps, number, "car")


def decision(street, plans, speed_mps=SPEED_MPS):
    """Return whether our car brakes hard after plans with these obstacles, and for whom."""
    network, route, s_m = street
    streets = StreetBehaviour(network, MARGINS)
    streets.follow(route, np.full(len(route.s), 10.0), BRAKING_MPS2)
    for seen in plans:
        streets.stop(s_m, speed_mps, seen, 60.0)
    return streets.must_brake_hard(s_m, speed_mps, plans[-1], 60.0), streets.details.get("obstacle")


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("place", "speed_mps", "expected"),
    [
        # The car needs 9.8 m for a firm stop. In the first case, 10.4 m are free, then 7.4 m.
        ((15.0, 0.0, 0.0), 0.0, False),
        ((12.0, 0.0, 0.0), 0.0, True),
        ((12.0, 2.3, 0.0), 0.0, False),  # beside its way
        ((12.0, 0.0, 0.0), 4.0, False),  # drives on
        ((8.0, 0.0, 0.0), 0.5, True),
        ((12.0, -4.0, QUARTER), 0.0, False),  # waits to cross the way
        ((8.0, -4.0, QUARTER), 3.0, True),  # crosses it
        ((8.0, 4.0, QUARTER), 3.0, False),  # has crossed it
        ((20.0, 0.0, np.pi), 8.0, True),  # comes on the lane of the car
        ((20.0, WIDTH_M, np.pi), 8.0, False),  # on its own lane
        ((20.0, WIDTH_M, np.pi + 0.25), 8.0, False),  # oblique, but its lane leads past the car
        ((-9.0, 0.0, 0.0), 20.0, False),  # is behind, where braking does not help
    ],
)
def test_car_brakes_hard_only_where_a_firm_stop_ends_in_a_contact(
    street, place, speed_mps, expected
):
    plans = [[car_at(street, *place, speed_mps)]]
    assert decision(street, plans) == (expected, "car 7" if expected else None)
    assert decision(street, plans, speed_mps=0.0) == (False, None)


@pytest.mark.parametrize(("gain_mps2", "expected"), [(3.0, True), (0.0, False)])
def test_car_sees_that_one_beside_its_way_starts(street, gain_mps2, expected):
    speeds_mps = [0.0, 0.0] + [0.5 + gain_mps2 * TICK_S * n for n in range(6)]
    speeds_mps = speeds_mps if gain_mps2 else [0.2] * 8
    plans = [[car_at(street, 7.0, -3.9, QUARTER, mps)] for mps in speeds_mps]
    assert decision(street, plans)[0] is expected


@pytest.mark.parametrize(
    ("turn_radps", "left_m", "expected"),
    [(0.8, -2.4, True), (0.0, -2.4, False), (0.8, -3.6, False)],  # the last may stop turning
)
def test_car_sees_that_one_beside_it_turns_into_its_way(street, turn_radps, left_m, expected):
    turned = [turn_radps * TICK_S * n for n in range(6)]
    plans = [[car_at(street, 4.0, left_m, rad, 5.0)] for rad in turned]
    assert decision(street, plans)[0] is expected


def test_those_without_an_id_are_not_taken_for_each_other(street):
    away = [car_at(street, 7.0, -6.0, 0.0, 9.0, 0), car_at(street, 9.0, 6.0, np.pi, 0.0, 0)]
    assert decision(street, [away, away[::-1], away]) == (False, None)
