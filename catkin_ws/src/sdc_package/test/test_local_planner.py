"""The path ahead, its stops, and what limits the speed at its first point."""

import dataclasses
import math

import numpy as np
import pytest
from planned_roads import SETTINGS, straight

from sdc_common.driving import DetectedObstacle
from sdc_common.planning.stop_line import GREEN, RED, YELLOW, StopLine
from sdc_package.braking import FIRM_MPS2
from sdc_package.local_planner import LocalPlanner, OffRouteError
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch


def twice_round(radius=20.0, turns=1.2):
    angle = np.arange(0.0, turns * 2.0 * math.pi * radius) / radius
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def planner(points, **changes):
    return LocalPlanner(points, dataclasses.replace(SETTINGS, **changes))


def path_ahead(local, x, y, yaw):
    return local.plan(WaypointSearch(local.route.points).first_ahead(x, y), x, y, yaw)


def test_path_starts_ahead_of_the_car_and_ends_at_the_lookahead_distance():
    plan = path_ahead(planner(straight(200.0)), 50.4, 0.3, 0.0)
    assert plan[0, 0] == 51.0
    assert plan[-1, 0] == 75.0
    assert (np.diff(plan[:, 0]) > 0.0).all()


def test_path_and_horizon_grow_with_the_planned_speed():
    """A car at 36 m/s sees so far that it can stop with its usual braking behind what it sees."""
    road_mps = np.repeat([8.0, 36.0], [301, 1000])
    limits = dataclasses.replace(SETTINGS.limits, cruise_mps=60.0)
    local = LocalPlanner(straight(1300.0), dataclasses.replace(SETTINGS, limits=limits), road_mps)
    found = []
    for x in (100.0, 900.0):
        plan = path_ahead(local, x, 0.0, 0.0)
        found.append((plan[-1, 0] - x, local.horizon_m))
    (slow_m, slow_horizon_m), (fast_m, fast_horizon_m) = found
    assert (slow_m, fast_m) == (25.0, pytest.approx(90.0, abs=1.0))
    assert slow_horizon_m < 50.0
    assert fast_horizon_m > 90.0 + 36.0**2 / (2.0 * limits.braking_mps2)


def test_path_at_the_end_of_the_route_has_two_points_and_ends_with_a_stop():
    local = planner(straight(50.0))
    for x in (0.0, 8.0, 16.0, 24.0, 32.0, 40.0, 48.0, 49.5, 50.0, 52.0):
        plan = path_ahead(local, x, 0.0, 0.0)
        assert len(plan) >= 2
        assert np.isfinite(plan).all()
    assert plan.shape == (2, 3)
    assert plan[-1].tolist() == [50.0, 0.0, 0.0]


@pytest.mark.parametrize(("yaw", "s_m"), [(0.0, 30.0), (math.pi / 2, 150.0)])
def test_car_at_a_crossing_joins_the_pass_in_its_direction(yaw, s_m):
    """The route leads to the east, around a block, and to the north through the same place."""
    corners = np.array([[-30, 0], [30, 0], [30, -30], [0, -30], [0, 30]])
    steps = [np.linspace(a, b, 31)[:-1] for a, b in zip(corners, corners[1:])]
    local = planner(np.vstack([*steps, corners[-1:]]))
    path_ahead(local, 0.0, 0.0, yaw)
    assert local.place.s_m == pytest.approx(s_m, abs=3.0)


def test_place_does_not_jump_where_the_route_passes_itself():
    points = twice_round()
    local = planner(points)
    last = -1.0
    for x, y in points:
        yaw = math.atan2(y, x) + math.pi / 2
        path_ahead(local, x * 0.995, y * 0.995, yaw)
        assert last < local.place.s_m < last + 3.0
        last = local.place.s_m
    assert last > 0.97 * local.route.length_m


def test_planner_finds_a_car_that_is_moved():
    local = planner(straight(200.0))
    path_ahead(local, 10.0, 0.0, 0.0)
    assert path_ahead(local, 150.0, 1.0, 0.0)[0, 0] == 150.0
    assert path_ahead(local, 139.0, 1.0, 0.0)[0, 0] == 139.0, (
        "also if it is moved by less than join_within_m"
    )


def test_pose_too_far_from_the_route_is_refused_and_has_no_effect_later():
    local = planner(straight(200.0))
    with pytest.raises(OffRouteError, match=r"25\.0 m from the route"):
        path_ahead(local, 100.0, 25.0, 0.0)
    assert path_ahead(local, 100.0, 20.0, 0.0)[0, 0] == 100.0
    with pytest.raises(OffRouteError):
        path_ahead(local, 100.0, -30.0, 0.0)
    assert local.place.s_m == pytest.approx(100.0)


@pytest.mark.parametrize("pose", [(math.nan, 0.0, 0.0), (0.0, math.inf, 0.0), (0.0, 0.0, math.nan)])
def test_pose_that_is_not_finite_is_refused(pose):
    with pytest.raises(ValueError, match="not finite"):
        planner(straight(50.0)).plan(0, *pose)


def test_first_waypoint_far_from_the_car_is_refused():
    local = planner(straight(200.0))
    with pytest.raises(
        ValueError, match=r"waypoint 0 .* 100\.0 m away from the car, the route only 0\.5 m"
    ):
        local.plan(0, 100.0, 0.5, 0.0)
    with pytest.raises(ValueError, match="waypoint 201 does not exist, the route has 201"):
        local.plan(201, 100.0, 0.5, 0.0)


def test_first_waypoint_of_another_pass_is_replaced():
    points = twice_round(turns=2.0)
    local = planner(points)
    other = int(round(2.0 * math.pi * 20.0)) + 5
    assert local.plan(other, *points[5], math.pi / 2 + 0.25)[0, :2] == pytest.approx(
        points[5], abs=1.0
    )
    assert local.place.s_m < 10.0


@pytest.mark.parametrize(
    ("left_m", "s_m"),
    [(-1.0, 89.3), (199.5, 215.0), (170.0, 215.0), (60.0, 89.3), (9999.0, 89.3)],
    ids=["unknown", "second pass", "fast car", "first pass", "another route"],
)
def test_planner_resumes_on_the_pass_of_the_route_on_which_it_was(left_m, s_m):
    local = planner(twice_round(turns=2.2))
    local.resume(left_m)
    angle = 215.0 / 20.0
    path_ahead(local, 20.0 * math.cos(angle), 20.0 * math.sin(angle), angle + math.pi / 2)
    assert local.s_m == pytest.approx(s_m, abs=0.5)


def test_resumed_planner_searches_the_whole_route_for_a_car_far_away():
    local = planner(straight(300.0))
    assert local.s_m < 0.0, "unknown"
    local.resume(20.0)
    path_ahead(local, 200.0, 0.0, 0.0)
    assert local.s_m == pytest.approx(200.0)


LIGHT = 7


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
