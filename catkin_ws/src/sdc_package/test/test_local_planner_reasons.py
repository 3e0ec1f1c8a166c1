"""What limits the speed at the first point of a path, and the stops that lower its speeds."""

import dataclasses
import math
import os

import pytest
from planned_roads import SETTINGS, bend, straight

from sdc_common.driving import DetectedObstacle
from sdc_common.planning.stop_line import GREEN, RED, YELLOW, StopLine
from sdc_package.braking import FIRM_MPS2
from sdc_package.local_planner import LocalPlanner
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch

TOWN = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "..", "sdc_common", "data", "waypoints.csv"
)
LIGHT = 7


def planner(points):
    return LocalPlanner(points, SETTINGS)


def lights(line_x_m, state):
    monitor = TrafficLightMonitor(SETTINGS.traffic_lights)
    monitor.lines = {LIGHT: StopLine(line_x_m, 0.0, 1.75)}
    monitor.states = {LIGHT: state}
    return monitor


def reason_at(local, x, y=0.0, yaw=0.0, speed=10.0, obstacles=(), light=None):
    first = WaypointSearch(local.route.points).first_ahead(x, y)
    rows = local.plan(first, x, y, yaw, obstacles)
    local.stop_for(light or TrafficLightMonitor(SETTINGS.traffic_lights), rows, speed)
    return local.reason


def test_reasons_along_a_bend_name_what_limits_the_speed():
    local = planner(bend(12.0, math.pi / 2))
    names = [
        reason_at(local, x, y, yaw, speed)
        for x, y, yaw, speed in (
            (5.0, 0.0, 0.0, 4.0),
            (35.0, 0.0, 0.0, 10.0),
            (50.0, 0.0, 0.0, 8.5),
            (60.0 + 12.0 * math.sin(0.8), 12.0 * (1.0 - math.cos(0.8)), 0.8, 6.0),
            (72.0, 20.0, math.pi / 2, 7.5),
            (72.0, 65.0, math.pi / 2, 6.0),
        )
    ]
    assert names == [
        "accelerating",
        "cruise",
        "braking_ahead",
        "bend",
        "accelerating",
        "end_of_route",
    ]


@pytest.mark.parametrize("speed", [0.0, 4.0])
def test_obstacle_on_the_lane_is_the_reason_from_where_the_car_brakes_for_it(speed):
    local = planner(straight(200.0))
    box = DetectedObstacle(100.0, 0.0, 0.0, 4.0, 2.0, speed)
    assert reason_at(local, 50.0, obstacles=[box]) == "cruise"
    assert reason_at(local, 80.0, speed=6.0, obstacles=[box]) == "obstacle"
    aside = DetectedObstacle(100.0, 8.0, 0.0, 4.0, 2.0, speed)
    assert reason_at(local, 80.0, obstacles=[aside]) == "cruise"


def test_red_light_is_the_reason_until_it_turns_green_and_then_the_car_accelerates():
    local = planner(straight(200.0))
    red = lights(100.0, RED)
    assert reason_at(local, 50.0, light=red) == "cruise"
    assert reason_at(local, 85.0, speed=7.0, light=red) == "traffic_light"
    assert reason_at(local, 96.6, speed=0.0, light=red) == "traffic_light"
    assert reason_at(local, 96.6, speed=0.0, light=lights(100.0, GREEN)) == "accelerating"
    assert reason_at(local, 130.0, speed=9.5, light=lights(100.0, GREEN)) == "cruise"


@pytest.mark.parametrize(("spare_m", "stops"), [(0.05, True), (-0.05, False)])
def test_car_stops_for_yellow_if_firm_braking_is_enough(spare_m, stops):
    # The path reaches beyond the place of the stop.
    local = LocalPlanner(straight(200.0), dataclasses.replace(SETTINGS, lookahead_m=30.0))
    margins, speed_mps = SETTINGS.traffic_lights, 10.0
    braking_m = speed_mps**2 / (2.0 * FIRM_MPS2)
    stop_x_m = 100.0 - margins.gap_m - margins.car_front_m
    x = stop_x_m - braking_m - margins.reaction_s * speed_mps - spare_m
    rows = local.stop_for(lights(100.0, YELLOW), local.plan(int(x) + 1, x, 0.0, 0.0), speed_mps)
    assert (rows[-1, 2] == 0.0) == stops


def test_of_several_limits_the_lowest_is_the_reason():
    local = planner(straight(200.0))
    near = DetectedObstacle(95.0, 0.0, 0.0, 4.0, 2.0, 0.0)
    far = DetectedObstacle(120.0, 0.0, 0.0, 4.0, 2.0, 0.0)
    red = lights(100.0, RED)
    assert reason_at(local, 80.0, speed=5.0, obstacles=[near], light=red) == "obstacle"
    assert reason_at(local, 80.0, speed=5.0, obstacles=[far], light=red) == "traffic_light"
    assert reason_at(local, 199.0, speed=1.0, light=lights(260.0, RED)) == "end_of_route"


@pytest.mark.parametrize(("x", "stop_x_m"), [(80.0, 97.0), (89.2, 97.75)])
def test_car_that_stops_late_stops_between_two_points_of_the_route(x, stop_x_m):
    local, light = planner(straight(200.0)), lights(101.1, RED)
    first = WaypointSearch(local.route.points).first_ahead(x, 0.0)
    rows = local.stop_for(light, local.plan(first, x, 0.0, 0.0, ()), 8.0)
    assert rows[rows[:, 2] == 0.0][0, 0] == pytest.approx(stop_x_m)
