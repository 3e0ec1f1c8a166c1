"""What the car decides on streets: where it stops, for whom, and how it follows."""

import dataclasses

import numpy as np
import pytest
from planned_roads import street_parameters

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.road_line import road_route
from sdc_map.crossings import crossings, places_along
from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network_file import load_network
from sdc_package.behaviour.crosswalks import crosswalks_on
from sdc_package.behaviour.streets import StreetBehaviour, StreetMargins
from sdc_testing.street_maps import needs_maps

pytestmark = needs_maps
PARAMETERS = street_parameters()
MARGINS = StreetMargins(**PARAMETERS["streets"])
FRONT_M, BRAKING_MPS2 = MARGINS.car_front_m, PARAMETERS["braking_mps2"]
HORIZON_M = 60.0


@pytest.fixture(scope="module", name="town")
def _town():
    network = load_network(map_file("town"))
    return network, LaneGraph(network)


def drives(network, graph):
    """Yield routes through the town with their crossings."""
    for seed in range(40):
        start, goal = drawn_places(graph, seed)
        route = road_route(plan_mission(graph, [goal], *start).points_m)
        places = list(places_along(network, route))
        yield route, crossings(network, route, places, np.full(len(route.s), 9.0))


@pytest.fixture(name="crossing", params=["sign", "way"])
def _crossing(request, town):
    """A drive to the first junction with a stop sign, or where another way has right of way."""
    network = town[0]
    for route, found in drives(*town):
        for one in found:
            if one.line_m < 30.0 or not any(way.is_first for way in one.conflicts):
                continue
            if one.has_stop_sign == (request.param == "sign"):
                streets = StreetBehaviour(network, MARGINS)
                streets.follow(route, np.full(len(route.s), 10.0), BRAKING_MPS2)
                return network, streets, route, one
    raise AssertionError("the town has no such junction")


def at_line(streets, crossing, speed_mps, obstacles=(), before_m=0.0, **kwds):
    """Return the decision with the car's front so far before the place at which it stops."""
    s_m = crossing.line_m - FRONT_M - MARGINS.gap_m - before_m
    # Junctions before this one are passed.
    streets.stop(s_m - 0.01, 0.5, (), HORIZON_M)
    return streets.stop(s_m, speed_mps, obstacles, HORIZON_M, **kwds)


def coming(network, crossing, away_m, speed_mps, is_first=True, **changes):
    """Return a car on a lane before the way of another, so far from the junction."""
    other = next(way for way in crossing.conflicts if way.is_first == is_first)
    name = next(name for name, distance in other.lanes.items() if distance == 0.0)
    lane = network.lanes[name]
    s_m = lane.length_m - away_m
    x, y = lane.line.point_at(s_m)
    car = DetectedObstacle(x, y, lane.heading_at(s_m), 4.5, 1.8, speed_mps)
    return dataclasses.replace(car, **changes)


def walker_at(route, s_m):
    """Return a pedestrian who walks across a route."""
    yaw = route.line.heading_at(s_m) + np.pi / 2.0
    return DetectedObstacle(*route.line.point_at(s_m), yaw, 0.5, 0.5, 1.2, 3, "pedestrian")


def test_car_stops_once_at_a_stop_sign(crossing):
    _, streets, _, one = crossing
    reason = "stop_sign" if one.has_stop_sign else None
    decision = at_line(streets, one, 3.0, before_m=10.0)
    assert (decision and decision[1]) == reason
    if decision:
        assert decision[0] == pytest.approx(one.line_m - FRONT_M - MARGINS.gap_m)
    # A car that starts there gets no nearer, where the next point of its path is beyond the line.
    assert at_line(streets, one, 0.0, before_m=2.0) is None


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("away_m", "speed_mps", "changes", "gives_way"),
    [
        (12.0, 8.0, {}, True),
        (190.0, 8.0, {}, False),  # far away
        (12.0, 0.0, {}, False),  # in a queue
        (6.0, 0.0, {}, True),  # waits at the line and may start at any time
        (12.0, 1.2, {"length_m": 0.5, "yaw_rad": 1e9}, False),  # a pedestrian who crosses its lane
    ],
)
def test_car_gives_way_to_those_that_it_would_meet(crossing, away_m, speed_mps, changes, gives_way):
    network, streets, _, one = crossing
    other = coming(network, one, away_m, speed_mps)
    if "yaw_rad" in changes:
        changes = {**changes, "yaw_rad": other.yaw_rad + np.pi / 2.0}
    other = dataclasses.replace(other, **changes)
    at_line(streets, one, 0.0)  # has stopped at the sign
    other = dataclasses.replace(other, id=17, kind="car")
    decision = at_line(streets, one, 0.0, [other])
    assert (decision is not None and decision[1] == "right_of_way") == gives_way
    text = f"yields to car 17 at junction {one.junction}"
    assert streets.details == ({"right_of_way": text} if gives_way else {})
    at_line(streets, one, 0.0)
    assert streets.details == {}


@pytest.mark.parametrize(("braking_mps2", "gives_way"), [(0.0, True), (3.0, False)])
def test_car_gives_way_to_one_that_takes_it_without_braking(town, braking_mps2, gives_way):
    network, decisions = town[0], []
    route, found = next(
        one
        for one in drives(*town)
        if one[1] and {way.is_first for way in one[1][0].conflicts} == {False}
    )
    streets = StreetBehaviour(network, MARGINS)
    streets.follow(route, np.full(len(route.s), 9.0), BRAKING_MPS2)
    s_m = found[0].line_m - FRONT_M - MARGINS.gap_m - 6.0
    for tick in range(30):  # it comes from 25 m to 13 m, and needs 3.9 m/s^2 there to stop
        speed_mps = 9.0 + braking_mps2 * (1.5 - 0.05 * tick)
        away_m = 13.0 + 9.0 * (1.5 - 0.05 * tick)
        other = coming(network, found[0], away_m, speed_mps, is_first=False, id=17)
        decisions.append(streets.stop(s_m, 6.0, [other], HORIZON_M))
    assert any(one and one[1] == "right_of_way" for one in decisions[20:]) == gives_way


@pytest.mark.parametrize(("faster_mps2", "gives_way"), [(0.0, False), (2.0, True)])
def test_car_expects_one_that_accelerates_sooner(crossing, faster_mps2, gives_way):
    network, streets, _, one = crossing
    at_line(streets, one, 0.0)  # has stopped at the sign
    for tick in range(20):
        other = coming(network, one, 39.0, 6.0 - faster_mps2 * 0.05 * (19 - tick), id=17)
        s_m = one.line_m - FRONT_M - MARGINS.gap_m
        decision = streets.stop(s_m, 0.0, [other], HORIZON_M)
    assert (decision is not None and decision[1] == "right_of_way") == gives_way


@pytest.mark.parametrize("crossing", ["way"], indirect=True)
@pytest.mark.parametrize(("faster_mps2", "gives_way"), [(0.2, False), (2.0, True)])
def test_one_that_creeps_still_waits(crossing, faster_mps2, gives_way):
    network, streets, _, one = crossing
    at_line(streets, one, 0.0)  # has stopped at the sign
    s_m = one.line_m - FRONT_M
    for tick in range(8):
        speed_mps = 0.5 - faster_mps2 * 0.05 * (7 - tick)
        other = coming(network, one, 3.5, max(speed_mps, 0.0), id=17)
        decision = streets.stop(s_m, 2.5, [other], HORIZON_M)
    assert (decision is not None and decision[1] == "right_of_way") == gives_way


@pytest.mark.parametrize(("ahead_m", "nearer_m"), [(30.0, 0.0), (11.7, 0.5), (11.0, 0.8)])
def test_car_stops_nearer_to_a_crosswalk_rather_than_harder(town, ahead_m, nearer_m):
    network = town[0]
    for route, _ in drives(*town):
        for walk in crosswalks_on(route, network.crosswalks):
            streets = StreetBehaviour(network, MARGINS)
            streets.follow(route, np.full(len(route.s), 9.0), BRAKING_MPS2)
            middle_m = 0.5 * (walk.begin_m + walk.end_m)
            walker = walker_at(route, middle_m)
            stop_m = walk.begin_m - FRONT_M - MARGINS.gap_m
            decision = streets.stop(stop_m - ahead_m, 7.7, [walker], HORIZON_M)
            if decision is not None and decision[1] == "crosswalk":
                assert decision[0] - stop_m == pytest.approx(nearer_m, abs=0.1)
                return
    raise AssertionError("the town has no such crosswalk")


@pytest.mark.parametrize(
    ("turned_rad", "speed_mps", "matters"), [(0.0, 8.0, False), (-0.3, 8.0, True)]
)
def test_one_that_comes_from_the_next_lane_matters(town, turned_rad, speed_mps, matters):
    network, graph = town
    lane, left = network.lanes["avenue_n_1"], network.lanes["avenue_n_2"]
    goal = lane.line.point_at(lane.length_m - 2.0)
    route = road_route(plan_mission(graph, [goal], *lane.line.point_at(2.0)).points_m)
    streets = StreetBehaviour(network, MARGINS)
    streets.follow(route, np.full(len(route.s), 9.0), BRAKING_MPS2)
    yaw = left.heading_at(25.0) + turned_rad
    beside = DetectedObstacle(*left.line.point_at(25.0), yaw, 4.5, 1.8, speed_mps)
    assert bool(streets.relevant(10.0, 8.0, [beside], HORIZON_M)) == matters


@pytest.mark.parametrize(("horizon_m", "matters"), [(60.0, False), (200.0, True)])
def test_slow_one_far_ahead_matters_within_the_horizon(town, horizon_m, matters):
    network, graph = town
    lane = max(network.driving, key=lambda lane: lane.length_m)
    goal = lane.line.point_at(lane.length_m - 2.0)
    route = road_route(plan_mission(graph, [goal], *lane.line.point_at(2.0)).points_m)
    streets = StreetBehaviour(network, MARGINS)
    streets.follow(route, np.full(len(route.s), 30.0), BRAKING_MPS2)
    slow = DetectedObstacle(*lane.line.point_at(152.0), lane.heading_at(152.0), 4.5, 1.8, 3.0)
    assert bool(streets.relevant(0.0, 30.0, [slow], horizon_m)) == matters


@pytest.mark.parametrize("crossing", ["way"], indirect=True)
@pytest.mark.parametrize(("speed_mps", "matters"), [(8.0, False), (1.5, True)])
def test_a_slow_car_stops_for_one_that_crosses_where_it_is_already(crossing, speed_mps, matters):
    network, streets, _, one = crossing
    at_line(streets, one, 0.0)
    other = next(way for way in one.conflicts if way.is_first and not way.merges)
    lane = network.lanes[min(other.lanes, key=other.lanes.get)]
    x, y = lane.line.point_at(other.its_m[0] - 4.0)
    crosses = DetectedObstacle(x, y, lane.heading_at(other.its_m[0] - 4.0), 4.5, 1.8, 6.0)
    inside_m = other.own_m[0] + 0.5 - FRONT_M
    assert bool(streets.relevant(inside_m, speed_mps, [crosses], HORIZON_M)) == matters


def test_car_that_waits_long_enough_starts_before_one_that_does_not_move(crossing):
    network, streets, _, one = crossing
    waiting = [coming(network, one, 6.0, 0.0)]
    decisions = [at_line(streets, one, 0.0, waiting) for _ in range(60)]
    assert decisions[1][1] == "right_of_way" and decisions[-1] is None


def test_car_enters_no_junction_that_it_could_not_leave(crossing):
    _, streets, route, one = crossing
    at_line(streets, one, 0.0)
    place = route.line.point_at(one.end_m + 3.0)
    heading = route.line.heading_at(one.end_m + 3.0)
    jam = DetectedObstacle(*place, heading, 4.5, 1.8, 0.0)
    assert at_line(streets, one, 0.0, [jam])[1] == "junction_blocked"
    moving = dataclasses.replace(jam, speed_mps=5.0)
    assert at_line(streets, one, 0.0, [moving]) is None


@pytest.mark.slow(4)
def test_one_on_the_way_of_the_car_is_followed_and_not_given_way(town):
    network, seen = town[0], 0
    for route, found in drives(*town):
        streets = StreetBehaviour(network, MARGINS)
        streets.follow(route, np.full(len(route.s), 9.0), BRAKING_MPS2)
        for one in found:
            for way in one.conflicts:
                if not (way.merges and way.is_first):
                    continue
                s_m = one.line_m - FRONT_M - MARGINS.gap_m - 6.0
                for at_m in np.arange(way.own_m[0] + 1.0, way.own_m[1], 1.0):
                    heading = route.line.heading_at(at_m)
                    x, y = route.line.point_at(at_m)
                    for left_m in (-0.5, 0.5):
                        place = x - left_m * np.sin(heading), y + left_m * np.cos(heading)
                        ahead = DetectedObstacle(*place, heading, 4.5, 1.8, 5.0)
                        streets.stop(s_m - 0.01, 6.0, (), HORIZON_M)
                        decision = streets.stop(s_m, 6.0, [ahead], HORIZON_M)
                        assert decision is None or decision[1] != "right_of_way"
                        seen += 1
    assert seen > 50


@pytest.mark.parametrize(("after_m", "gives_way"), [(40.0, True), (-3.0, False)])
def test_red_light_after_a_junction_hides_no_one_with_right_of_way(crossing, after_m, gives_way):
    network, streets, _, one = crossing
    at_line(streets, one, 0.0)  # has stopped at the sign
    other, red_m = coming(network, one, 12.0, 8.0), one.line_m + after_m
    decision = at_line(streets, one, 0.0, [other], red_m=red_m)
    assert (decision is not None and decision[1] == "right_of_way") == gives_way


def test_pedestrian_after_a_junction_hides_no_one_with_right_of_way(town):
    network = town[0]
    for route, found in drives(*town):
        walks = crosswalks_on(route, network.crosswalks)
        for one in found:
            after = [walk for walk in walks if 3.0 < walk.begin_m - one.line_m < 40.0]
            if not after or not any(way.is_first for way in one.conflicts):
                continue
            streets = StreetBehaviour(network, MARGINS)
            streets.follow(route, np.full(len(route.s), 9.0), BRAKING_MPS2)
            walker = walker_at(route, 0.5 * (after[0].begin_m + after[0].end_m))
            assert at_line(streets, one, 3.0, [walker], before_m=3.0)[1] == "crosswalk"
            other = coming(network, one, 12.0, 8.0)
            decision = at_line(streets, one, 3.0, [walker, other], before_m=3.0)
            assert decision[1] == "right_of_way"
            return
    raise AssertionError("the town has no such junction")
