"""What the car decides in the town: where it stops, for whom, why, and how hard."""

import dataclasses

import numpy as np
import pytest
from street_drives import SETTINGS, TICK_NS, WIDTH_M, new_planner

from sdc_common.configuration import node_config
from sdc_common.driving import DetectedObstacle, Observation
from sdc_common.geometry.road_line import road_route
from sdc_map.crossings import crossings, places_along
from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network import Network, RoadLane
from sdc_map.network_file import load_network
from sdc_package.behaviour.predict import STEP_S
from sdc_package.behaviour.road import crosswalks_on, onward, places_on
from sdc_package.behaviour.score import score
from sdc_package.street_settings import StreetSettings
from sdc_testing.street_maps import needs_maps

pytestmark = needs_maps
FRONT_M = SETTINGS.front_m
GAP_M = SETTINGS.streets.gap_m
QUARTER = 0.5 * np.pi


@pytest.fixture(scope="module", name="town")
def _town():
    network = load_network(map_file("town"))
    return network, LaneGraph(network)


def missions(network, graph):
    """Yield missions through the town with their routes and crossings."""
    for seed in range(40):
        start, goal = drawn_places(graph, seed)
        points_m = plan_mission(graph, [goal], *start).points_m
        route = road_route(points_m)
        places = list(places_along(network, route))
        yield points_m, route, crossings(network, route, places, np.full(len(route.s), 9.0))


@pytest.fixture(name="crossing", params=["sign", "way"])
def _crossing(request, town):
    """A drive to the first junction with a stop sign, or where another way has right of way."""
    for points_m, route, found in missions(*town):
        for junction in found:
            crosses = any(way.is_first and not way.merges for way in junction.conflicts)
            has_sign = junction.has_stop_sign == (request.param == "sign")
            if junction.line_m > 30.0 and crosses and has_sign:
                return town[0], new_planner(town[0], points_m), route, junction
    raise AssertionError("the town has no such junction")


def plan(planner, route, s_m, speed_mps, others=(), ticks=1, first=0):
    """Plan for some time with the car at one place, and return the speeds of the path."""
    (x, y), yaw = route.line.point_at(s_m), route.line.heading_at(s_m)
    for tick in range(first, first + ticks):
        seen = Observation(tick * TICK_NS, x, y, yaw, speed_mps, list(others))
        path = planner.plan(seen)
    return [mps for *_, mps in path.points]


def at_line(crossing, before_m=0.0):
    """Return where the centre of the car is, so far before the place at which it stops."""
    return crossing.line_m - FRONT_M - GAP_M - before_m


def coming(network, crossing, away_m, speed_mps, is_first=True, **changes):
    """Return a car on a lane before the way of another, so far from the junction."""
    other = next(way for way in crossing.conflicts if way.is_first == is_first and not way.merges)
    name = next(name for name, distance in other.lanes.items() if distance == 0.0)
    lane = network.lanes[name]
    s_m = lane.length_m - away_m
    x, y = lane.line.point_at(s_m)
    car = DetectedObstacle(x, y, lane.heading_at(s_m), 4.5, 1.8, speed_mps, 17, "car")
    return dataclasses.replace(car, **changes)


def gives_way(planner):
    return planner.decision.reason == "right_of_way"


def test_car_stops_once_at_a_stop_sign(crossing):
    _, planner, route, junction = crossing
    speeds = plan(planner, route, at_line(junction, 8.0), 3.0)
    assert (0.0 in speeds) == junction.has_stop_sign
    plan(planner, route, at_line(junction), 0.0, ticks=3, first=10)
    assert 0.0 not in plan(planner, route, at_line(junction), 0.5, first=20)


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("away_m", "speed_mps", "changes", "expected"),
    [
        (12.0, 8.0, {}, True),
        (190.0, 8.0, {}, False),  # far away
        (16.0, 0.0, {}, False),  # in a queue
        (6.0, 0.0, {}, True),  # waits at the line and may start at any time
        (12.0, 1.2, {"length_m": 0.5, "kind": "pedestrian"}, False),  # crosses its lane
    ],
)
def test_car_gives_way_to_those_that_it_would_meet(crossing, away_m, speed_mps, changes, expected):
    network, planner, route, junction = crossing
    plan(planner, route, at_line(junction), 0.0)  # has stopped at the sign
    other = coming(network, junction, away_m, speed_mps, **changes)
    plan(planner, route, at_line(junction), 0.0, [other], ticks=3, first=1)
    assert gives_way(planner) == expected
    assert ("takes the way of car 17" in planner.decision.detail) == expected
    plan(planner, route, at_line(junction), 0.0, ticks=3, first=4)
    assert planner.decision.detail == ""


def test_car_that_waits_long_enough_starts_before_one_that_does_not_move(crossing):
    network, planner, route, junction = crossing
    waiting = [coming(network, junction, 6.0, 0.0)]
    plan(planner, route, at_line(junction), 0.0, waiting, ticks=4)
    assert gives_way(planner)
    plan(planner, route, at_line(junction), 0.0, waiting, ticks=60, first=4)
    assert not gives_way(planner)


@pytest.mark.slow(2)
@pytest.mark.parametrize(("speed_mps", "expected"), [(9.0, True), (6.0, False)])
def test_car_gives_way_to_one_that_could_only_brake_hard_for_it(town, speed_mps, expected):
    points_m, route, found = next(
        (points_m, route, found)
        for points_m, route, found in missions(*town)
        if found and not any(way.is_first for way in found[0].conflicts)
        if not all(way.merges for way in found[0].conflicts)
    )
    planner = new_planner(town[0], points_m)
    other = coming(town[0], found[0], 13.0, speed_mps, is_first=False)
    plan(planner, route, at_line(found[0], 6.0), 6.0, [other])
    assert gives_way(planner) == expected


@pytest.mark.parametrize(("faster_mps2", "expected"), [(0.0, False), (2.0, True)])
def test_car_expects_one_that_accelerates_sooner(crossing, faster_mps2, expected):
    network, planner, route, junction = crossing
    plan(planner, route, at_line(junction), 0.0)  # has stopped at the sign
    for tick in range(20):
        other = coming(network, junction, 65.0, 6.0 - faster_mps2 * 0.05 * (19 - tick))
        plan(planner, route, at_line(junction), 0.0, [other], first=tick + 1)
    assert gives_way(planner) == expected


def test_car_enters_no_junction_that_it_could_not_leave(crossing):
    _, planner, route, junction = crossing
    plan(planner, route, at_line(junction), 0.0)
    behind_m = junction.end_m + 3.0
    place = *route.line.point_at(behind_m), route.line.heading_at(behind_m)
    jam = DetectedObstacle(*place, 4.5, 1.8, 0.0, 17, "car")
    plan(planner, route, at_line(junction), 0.0, [jam], ticks=3, first=1)
    assert planner.decision.reason == "junction_blocked"
    assert planner.decision.stop_m < junction.line_m


def test_car_stops_before_a_crosswalk_in_use(town):
    for points_m, route, _ in missions(*town):
        for walk in crosswalks_on(route, town[0].crosswalks):
            middle_m, stop_m = 0.5 * (walk.begin_m + walk.end_m), walk.begin_m - FRONT_M - GAP_M
            yaw = route.line.heading_at(middle_m) + QUARTER
            place = *route.line.point_at(middle_m), yaw
            walker = DetectedObstacle(*place, 0.5, 0.5, 1.2, 3, "pedestrian")
            planner = new_planner(town[0], points_m)
            plan(planner, route, stop_m - 25.0, 7.7, [walker])
            stop = planner.decision.proposal and planner.decision.proposal.stop
            if stop and stop.reason == planner.decision.reason == "crosswalk":
                assert planner.decision.stop_m == pytest.approx(stop_m)
                plan(planner, route, stop_m - 9.5, 7.7, [walker], first=2)
                assert stop_m < planner.decision.stop_m < stop_m + GAP_M
                return
    raise AssertionError("the town has no such crosswalk")


@pytest.fixture(scope="module", name="street")
def _street(town):
    """A mission, its route, and where 60 m straight road with an oncoming lane begin on it."""
    network = town[0]
    for points_m, route, _ in missions(*town):
        for s_m in range(20, int(route.length_m) - 60, 10):
            ahead = (route.s > s_m - 20.0) & (route.s < s_m + 60.0)
            (x, y), yaw = route.line.point_at(s_m + 20.0), route.line.heading_at(s_m)
            x, y = x - WIDTH_M * np.sin(yaw), y + WIDTH_M * np.cos(yaw)
            if np.ptp(route.heading[ahead]) < 0.02 and network.nearest(x, y, yaw + np.pi, 1.0):
                return points_m, route, float(s_m)
    raise AssertionError("the town has no straight road")


def car_at(street, ahead_m, left_m, turned_rad, speed_mps):
    _, route, s_m = street
    (x, y), yaw = route.line.point_at(s_m), route.line.heading_at(s_m)
    x += ahead_m * np.cos(yaw) - left_m * np.sin(yaw)
    y += ahead_m * np.sin(yaw) + left_m * np.cos(yaw)
    return DetectedObstacle(x, y, yaw + turned_rad, 4.5, 1.8, speed_mps, 7, "car")


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("place", "speed_mps", "expected"),
    [
        ((20.0, 0.0, 0.0), 0.0, False),  # the usual deceleration avoids it
        ((7.0, 0.0, 0.0), 0.0, True),
        ((12.0, 2.5, 0.0), 0.0, False),  # beside its way
        ((12.0, 0.0, 0.0), 6.0, False),  # drives on
        ((12.0, -4.0, QUARTER), 0.0, False),  # waits to cross the way
        ((8.0, -4.0, QUARTER), 3.0, True),  # crosses it
        ((8.0, 4.0, QUARTER), 3.0, False),  # has crossed it
        ((20.0, 0.0, np.pi), 8.0, True),  # comes on the lane of the car
        ((20.0, WIDTH_M, np.pi), 8.0, False),  # on its own lane
        ((20.0, WIDTH_M + 0.8, 1.1 * np.pi), 14.0, False),  # comes to the middle of that
        ((-9.0, 0.0, 0.0), 20.0, False),  # is behind, where braking does not help
        ((-60.0, -WIDTH_M, 0.05), 39.0, False),  # comes from behind into the lane of the car
        ((-7.0, -2.5, 0.15), 14.0, False),  # the same, beside the car by then
        ((-8.0, 1.5, np.pi), 8.0, False),  # has passed the car
    ],
)
def test_car_brakes_as_hard_as_it_can_only_where_its_best_proposal_meets_someone(
    town, street, place, speed_mps, expected
):
    points_m, route, s_m = street
    planner = new_planner(town[0], points_m)
    speeds = plan(planner, route, s_m, 8.0, [car_at(street, *place, speed_mps)])
    assert planner.decision.brakes_hard == expected == (max(speeds) == 0.0)
    if expected:
        assert (planner.reason, planner.detail) == ("obstacle", "brakes hard for car 7")


def test_way_of_others_leads_on_after_a_long_lane_without_a_kink_where_lanes_meet():
    corners_m = [(0, 0), (400, 0), (400, 0.05), (500, 0.05), (500, 0), (500, 99)]
    ends = zip("012", np.reshape(corners_m, (3, 2, 2)), ("1", "2", ()))
    lanes = [RoadLane(name, line, 3.5, 10.0, successors=tuple(after)) for name, line, after in ends]
    line = onward(Network("test", lanes), "0", 150.0)
    assert np.abs(line[line[:, 0] < 499.0, 3]).max() < 0.01
    assert places_on(line, np.array([550.0]))[0, 1] == pytest.approx(50.0, abs=0.1)
    short = RoadLane("0", np.array([[0.0, 0.0], [0.1, 0.0]]), 3.5, 10.0)
    ahead = places_on(onward(Network("test", [short]), "0", 150.0), np.array([150.0]))
    assert ahead[0] == pytest.approx([150.0, 0.0, 0.0, 0.0])


def test_car_does_not_start_before_one_has_crossed_its_way(town, street):
    points_m, route, s_m = street
    planner = new_planner(town[0], points_m)
    speeds = plan(planner, route, s_m, 0.0, [car_at(street, 5.5, -1.0, QUARTER, 1.4)])
    assert max(speeds) == 0.0 and planner.decision.s_m[-1] > s_m + 10.0


def test_car_that_is_too_fast_does_not_brake_for_that_and_for_the_one_ahead_in_sum(town, street):
    points_m, route, s_m = street
    planner = new_planner(town[0], points_m)
    plan(planner, route, s_m, 14.0, [car_at(street, 45.0, 0.0, 0.0, 9.0)])
    assert planner.detail == "car 7"
    first_mps, second_mps = planner.decision.speed_mps[:2]
    assert first_mps - second_mps == pytest.approx(SETTINGS.braking_mps2 * STEP_S)


def test_decision_keeps_each_proposal_with_the_terms_of_its_score(town, street):
    points_m, route, s_m = street
    planner = new_planner(town[0], points_m)
    plan(planner, route, s_m, 8.0, [car_at(street, 25.0, 0.0, 0.0, 0.0)], ticks=40)
    options = planner.decision.options
    assert {"go", "slowly", "brake", "pass, go"} <= {name for name, _, _ in options}
    assert all(set(terms) == set(SETTINGS.weights_m) for _, _, terms in options)
    assert max(value for _, value, _ in options) == options[0][1] or planner.way.until_m


def test_own_score_takes_the_place_of_that_of_the_product(town, street):
    def timid(scene, proposals, *known):
        scored = score(scene, proposals, *known)
        brakes = np.array([proposal.share > 0.0 for proposal in proposals])
        return dataclasses.replace(scored, terms={**scored.terms, "timid": 1e6 * brakes})

    points_m, route, s_m = street
    planner = new_planner(town[0], points_m, score_function=timid)
    plan(planner, route, s_m, 8.0, [car_at(street, 60.0, 0.0, 0.0, 8.0)])
    assert planner.decision.proposal.share == 0.0


@pytest.mark.parametrize(
    ("named", "message"),
    [
        ("no_such_module:Score", "'no_such_module:Score' cannot be loaded: No module named"),
        ("math", "'math' cannot be loaded"),
        ("math:pi", "'math:pi' is not a function"),
    ],
)
def test_score_that_cannot_be_loaded_is_one_line(town, street, named, message):
    with pytest.raises(ValueError, match=f"score_function {message}") as error:
        new_planner(town[0], street[0], score_function=named)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("section", "changes", "message"),
    [
        ("streets", {"clear": 1.0}, "streets/clear: did you mean 'clear_s'?"),
        ("score", {"contact": -1.0}, "score/contact must be a number that is not negative"),
        ("prediction", {"weights": {"goes_on": 1.0}}, "prediction/weights/.*: add it"),
    ],
)
def test_bad_parameter_is_named(section, changes, message):
    configs = [node_config("sdc_package", name) for name in ("local_planner", "street_planner")]
    parameters = {**configs[0], **configs[1]}
    parameters[section] = {**parameters[section], **changes}
    with pytest.raises((TypeError, ValueError), match=message):
        StreetSettings.read(parameters.__getitem__)
