"""The planner on a map: one observation comes in, one path goes out."""

from dataclasses import replace

import numpy as np
import pytest
from street_drives import TICK_NS
from street_drives import new_planner as street_planner

from sdc_common.driving import DetectedObstacle, Observation
from sdc_common.planning.stop_line import RED, StopLine
from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network_file import load_network
from sdc_testing.street_maps import bridge, needs_maps

pytestmark = needs_maps


@pytest.fixture(scope="module", name="mission", params=["town", "town_left"])
def _mission(request):
    network = load_network(map_file(request.param))
    graph = LaneGraph(network)
    start, goal = drawn_places(graph, 3)
    return network, plan_mission(graph, [goal], *start)


def new_planner(mission, **options):
    network, way = mission
    return street_planner(network, way.points_m, way.limits_mps, **options)


def observation(mission, s_m, speed_mps, *obstacles, tick=1):
    line = mission[1].points_m
    steps_m = np.hypot(*np.diff(line, axis=0).T)
    index = int(np.searchsorted(np.cumsum(steps_m), s_m))
    (x_m, y_m), (dx_m, dy_m) = line[index], line[index + 1] - line[index]
    yaw_rad = float(np.arctan2(dy_m, dx_m))
    return Observation(tick * TICK_NS, float(x_m), float(y_m), yaw_rad, speed_mps, obstacles)


def standing_car(mission, s_m):
    place = observation(mission, s_m, 0.0)
    return DetectedObstacle(place.x_m, place.y_m, place.yaw_rad, 4.5, 1.8, 0.0, 17, "car")


def test_path_depends_on_the_present_speed_and_not_on_that_of_an_earlier_plan(mission):
    """A car that is fast so near to a standing one uses the gap rather than brakes hard."""
    new, used = new_planner(mission, keeps_route=True), new_planner(mission, keeps_route=True)
    fast = observation(mission, 20.0, 8.0, standing_car(mission, 36.0), tick=2)
    for tick in (0, 1):  # it decides in every second plan
        used.plan(observation(mission, 20.0, 1.0, standing_car(mission, 36.0), tick=tick))
    assert used.plan(fast).points == new.plan(fast).points


def test_car_behind_a_standing_one_stops_and_names_it(mission):
    planner = new_planner(mission, keeps_route=True)
    path = planner.plan(observation(mission, 20.0, 5.0, standing_car(mission, 36.0)))
    assert path.points[-1][2] == 0.0
    assert (planner.reason, planner.detail) == ("obstacle", "car 17")
    for tick in (2, 3):
        planner.plan(observation(mission, 20.2, 5.0, tick=tick))
    assert planner.reason != "obstacle"
    assert planner.detail == ""


def test_car_stops_at_a_red_light_on_its_way(mission):
    line = observation(mission, 36.0, 0.0)
    lines = {1: StopLine(line.x_m, line.y_m, 1.75)}
    planner = new_planner(mission, keeps_route=True, lines=lines)
    seen = replace(observation(mission, 20.0, 5.0), light_states={1: RED})
    assert planner.plan(seen).points[-1][2] == 0.0


def test_mission_that_is_not_on_lanes_is_refused_and_the_last_one_stays(mission):
    planner = new_planner(mission)
    with pytest.raises(ValueError, match="the route is not on lanes of the map town"):
        planner.follow(mission[1].points_m + 5000.0, None)
    assert len(planner.plan(observation(mission, 20.0, 5.0)).points) >= 2


@pytest.fixture(scope="module", name="over_the_bridge")
def _over_the_bridge(tmp_path_factory):
    network = load_network(bridge(tmp_path_factory.mktemp("bridge")))
    return network, plan_mission(LaneGraph(network), [(90.0, -1.75)], -75.0, -1.75)


@pytest.mark.parametrize(("z_m", "stops"), [(6.0, True), (0.0, False), (float("nan"), True)])
def test_car_stops_only_for_what_is_on_the_level_of_its_route(over_the_bridge, z_m, stops):
    seen = observation(over_the_bridge, 55.0, 7.0)
    seen.light_states = {1: RED}
    light = new_planner(over_the_bridge, lines={1: StopLine(0.0, -1.75, 1.75, z_m)}).plan(seen)
    other = DetectedObstacle(0.0, -1.75, 0.5 * np.pi, 4.5, 1.8, 0.0, 17, "car", z_m)
    seen = observation(over_the_bridge, 55.0, 7.0, other)
    obstacle = new_planner(over_the_bridge, keeps_route=True).plan(seen)
    for path in (light, obstacle):
        assert (min(speed_mps for *_, speed_mps in path.points) == 0.0) == stops
