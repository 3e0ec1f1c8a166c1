"""How the car passes, merges, pulls out and makes room, among others that keep their motion."""

import math

import numpy as np
import pytest
from planned_roads import street_parameters

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.road_line import road_route
from sdc_map.crossings import places_along
from sdc_map.network import BROKEN, SOLID, Network, RoadLane
from sdc_package.behaviour.forecast import Body, forecast
from sdc_package.behaviour.manoeuvres import Manoeuvres
from sdc_package.behaviour.road import Around, around, road_along

WIDTH_M, LENGTH_M, TICK_S, MOST_MPS = 3.5, 700.0, 0.05, 12.0
PARAMETERS = street_parameters()
CAR = Body(
    front_m=PARAMETERS["caution"]["car_front_m"],
    width_m=PARAMETERS["caution"]["car_width_m"],
    acceleration_mps2=PARAMETERS["streets"]["acceleration_mps2"],
    braking_mps2=PARAMETERS["braking_mps2"],
)


def lane(name, y_m, back=False, **changes):
    points = np.array([[-100.0, y_m], [LENGTH_M, y_m]])
    return RoadLane(name, points[::-1] if back else points, WIDTH_M, 14.0, **changes)


def two_way(marking=BROKEN):
    """Return a street with a lane in each direction."""
    own = lane("e_0", 0.0, left_marking=marking)
    return Network("street", [own, lane("w_0", WIDTH_M, back=True, left_marking=marking)])


def two_lanes():
    """Return a road with two lanes of one direction."""
    right = lane("e_0", 0.0, left="e_1", left_marking=BROKEN)
    return Network("road", [right, lane("e_1", WIDTH_M, right="e_0", right_marking=BROKEN)])


class Other:
    """One that keeps its speed and its way, from a place at time 0."""

    def __init__(self, x_m, y_m=0.0, speed_mps=0.0, number=7, kind="car", size=(4.7, 1.9)):
        self.x_m, self.y_m, self.speed_mps, self.number = x_m, y_m, speed_mps, number
        self.kind, self.size = kind, size

    def at(self, time_s):
        yaw = 0.0 if self.speed_mps >= 0.0 else math.pi
        place = self.x_m + time_s * self.speed_mps, self.y_m, yaw, *self.size
        return DetectedObstacle(*place, abs(self.speed_mps), self.number, self.kind)


def road_of(network, points, last_mps=MOST_MPS):
    route = road_route(points)
    speeds = np.linspace(MOST_MPS, last_mps, len(route.s))
    return road_along(network, route, list(places_along(network, route)), speeds)


def drive(network, others, duration_s, points=None, start=(0.0, 0.0, 8.0), lines_m=()):
    """Let a point drive as the manoeuvres demand; return rows of time, x, y and speed.

    It brakes for those in its way, as the planner does, and meets none of them.
    """
    points = [(x, 0.0) for x in range(int(LENGTH_M))] if points is None else points
    road = road_of(network, np.array(points, float))
    plan, route = Manoeuvres(road, np.array(lines_m, float), CAR), road.route
    s, y, v = start
    rows, until_m = [], min(lines_m, default=math.inf) - CAR.front_m
    for tick in range(round(duration_s / TICK_S)):
        seen = [one.at(tick * TICK_S) for one in others]
        plan.decide(s, y, v, seen, math.inf)
        stop_m = min(plan.stop_m, until_m)
        for one in seen:
            beside_m = abs(one.y_m - route_y(route, one.x_m) - plan.way.offset_at(one.x_m))
            if beside_m < 0.5 * one.width_m + 1.2 and one.x_m > s:
                ahead_mps = one.speed_mps * math.cos(one.yaw_rad)
                gap_m = one.x_m - 0.5 * one.length_m - s - CAR.front_m - 4.0
                stop_m = min(stop_m, s + gap_m + max(ahead_mps, 0.0) ** 2 / 5.0)
        wanted = min(MOST_MPS, plan.most_mps, math.sqrt(5.0 * max(stop_m - s, 0.0)))
        v += min(max(wanted - v, -6.0 * TICK_S), 1.8 * TICK_S)
        s, y = s + v * TICK_S, plan.way.offset_at(s)
        rows.append((tick * TICK_S, s, route_y(route, s) + y, v))
        for one in seen:
            is_beside = abs(one.y_m - rows[-1][2]) > 0.5 * (one.width_m + CAR.width_m)
            away_m = abs(one.x_m - s) - 0.5 * one.length_m - CAR.front_m
            assert is_beside or away_m > 0.0, f"meets {one} at {rows[-1]}"
    return np.array(rows)


def route_y(route, x_m):
    return float(np.interp(x_m, *route.points.T))


def y_at(rows, x_m):
    return float(np.interp(x_m, rows[:, 1], rows[:, 2]))


def test_car_passes_one_at_rest_and_returns():
    rows = drive(two_way(), [Other(100.0)], 25.0)
    assert y_at(rows, 100.0) > 2.4
    assert y_at(rows, 50.0) == pytest.approx(0.0, abs=0.1)
    assert y_at(rows, 150.0) == pytest.approx(0.0, abs=0.01)
    assert rows[:, 3].min() > 7.0  # need not slow down


def test_car_waits_for_the_oncoming_one():
    others = [Other(100.0), *(Other(x, WIDTH_M, -8.0, 8 + x) for x in (150.0, 180.0, 230.0))]
    rows = drive(two_way(), others, 50.0)
    assert rows[-1, 1] > 150.0 and y_at(rows, 100.0) > 2.3
    assert rows[:, 3].min() < 4.0


def test_oncoming_lane_is_known_after_a_bend_behind_the_end_of_the_route():
    bend = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 150.0]])
    beside = np.array([[96.5, 150.0], [96.5, WIDTH_M], [0.0, WIDTH_M]])
    own = RoadLane("e_0", bend, WIDTH_M, 14.0, left_marking=BROKEN)
    network = Network("bend", [own, RoadLane("w_0", beside, WIDTH_M, 14.0)])
    route = road_route(np.array([(x, 0.0) for x in range(90)], float))
    road = road_along(network, route, list(places_along(network, route)), np.full(90, 9.0))
    coming = DetectedObstacle(96.5, 60.0, -0.5 * math.pi, 4.7, 1.9, 9.0, 7, "car")
    others = around(road, 60.0, [coming], 70.0, 190.0, 8.0)
    assert others.y_m == pytest.approx([WIDTH_M], abs=0.1)
    assert others.s_m == pytest.approx([160.0], abs=2.0)
    assert others.along_mps == pytest.approx([-9.0])


def test_car_waits_in_a_queue_before_a_junction():
    queue = [Other(180.0), Other(172.0, number=8)]
    rows = drive(two_way(), queue, 40.0, lines_m=[185.0])
    assert rows[:, 2].max() < 0.1 and rows[-1, 1] < 166.0


@pytest.mark.parametrize(("marking", "passes"), [(BROKEN, True), (SOLID, False)])
def test_car_overtakes_a_slow_one_if_the_line_allows(marking, passes):
    lorry = Other(40.0, speed_mps=4.0, kind="lorry", size=(9.0, 2.5))
    rows = drive(two_way(marking), [lorry], 35.0)
    assert (rows[-1, 1] > 40.0 + 35.0 * 4.0 + 10.0) == passes
    assert rows[-1, 2] == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("length_m", "passes"), [(4.7, True), (40.0, False)])
def test_car_overtakes_only_whom_it_passes_in_a_short_time(length_m, passes):
    rows = drive(two_way(), [Other(40.0, speed_mps=5.0, size=(length_m, 1.8))], 25.0)
    assert (rows[-1, 1] > 40.0 + 25.0 * 5.0 + 10.0) == passes


@pytest.mark.slow(2)
def test_car_that_passes_one_waits_with_room_before_the_next_one():
    def cone(x_m, y_m, number, width_m=0.5):
        return Other(x_m, y_m, number=number, kind="obstacle", size=(0.5, width_m))

    cones = [cone(65.0, -1.2, 1), cone(72.0, -0.4, 2), cone(76.0, -0.2, 3, 2.0)]
    stream = [Other(70.0 + 22.0 * n, WIDTH_M, -6.0, 10 + n) for n in range(12)]
    rows = drive(two_way(), [*cones, *stream], 90.0)
    at_rest = rows[rows[:, 3] < 0.1]
    assert at_rest[0, 1] + CAR.front_m + 8.0 < 72.0 - 0.25
    assert rows[-1, 1] > 150.0


def test_car_overtakes_on_the_next_lane_after_a_faster_one():
    slow, fast = Other(50.0, speed_mps=4.0), Other(-30.0, WIDTH_M, 13.0, 8)
    rows = drive(two_lanes(), [slow, fast], 30.0)
    overtaken = rows[np.searchsorted(rows[:, 1], 50.0 + 4.0 * rows[:, 0] + 0.0).argmax()]
    assert rows[-1, 1] > 50.0 + 4.0 * 30.0 and len(overtaken) == 4


def test_car_with_one_close_behind_it_brakes_no_harder_for_a_slow_one():
    """The one behind would drive through the car in a forecast in which it does not brake."""
    road = road_of(two_way(SOLID), np.column_stack([np.arange(300.0), np.zeros(300)]))
    plan = Manoeuvres(road, np.array([]), CAR)
    others = [Other(52.0, speed_mps=5.0).at(0.0), Other(-13.0, speed_mps=10.0, number=8).at(0.0)]
    for _ in range(100):
        plan.decide(0.0, 0.0, 10.0, others, math.inf)
        assert plan.most_mps > 5.0


def test_one_beside_a_route_that_changes_lanes_drives_straight_on():
    points = [(x, np.interp(x, [100.0, 140.0], [0.0, WIDTH_M])) for x in range(300)]
    road = road_of(two_lanes(), np.array(points, float))
    others = [Other(x, WIDTH_M, 12.0, int(x)).at(0.0) for x in (90.0, 120.0, 150.0)]
    seen = around(road, 110.0, others, 40.0, 60.0, 10.0)
    assert seen.y_m == pytest.approx([WIDTH_M] * 3, abs=0.1)
    assert seen.left_mps == pytest.approx([0.0] * 3, abs=0.35)  # the route: 1.05 m/s


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    "behind_m",
    [
        50.0,
        pytest.param(
            60.0,
            marks=pytest.mark.xfail(
                raises=AssertionError,
                strict=True,
                reason="the car stops before the ambulance, which does not brake",
            ),
        ),
        70.0,
        80.0,
    ],
)
def test_car_makes_room_for_an_ambulance(behind_m):
    ambulance = Other(-behind_m, 0.0, 18.0, kind="ambulance", size=(5.9, 2.0))
    rows = drive(two_lanes(), [ambulance], 20.0)
    beside = rows[np.argmin(np.abs(rows[:, 1] - (-behind_m + 18.0 * rows[:, 0])))]
    assert beside[2] > 2.5


def test_car_makes_room_again_for_the_next_one_that_invades_its_lane():
    invaders = [Other(x, 2.2, -8.0, number) for number, x in enumerate((60.0, 95.0, 130.0), 7)]
    rows = drive(two_way(), invaders, 12.0)
    for one in invaders:
        meets = np.argmin(np.abs(rows[:, 1] - one.x_m + 8.0 * rows[:, 0]))
        assert rows[meets, 2] < -0.6


def changing(at_m):
    """Return points of a route that changes from the right lane to the left one."""
    t = np.clip((np.arange(LENGTH_M) - at_m) / 40.0, 0.0, 1.0)
    return np.column_stack([np.arange(LENGTH_M), WIDTH_M * t**3 * (10.0 - 15.0 * t + 6.0 * t * t)])


@pytest.mark.parametrize("speed_mps", [8.0, 11.0])
def test_car_lets_those_beside_it_go_first_where_its_route_changes_lanes(speed_mps):
    flow = [Other(x, WIDTH_M, speed_mps, 8 - x) for x in (-14, 4, 22)]
    rows = drive(two_lanes(), flow, 40.0, changing(120.0))
    assert rows[-1, 1] > 250.0 and rows[-1, 2] == pytest.approx(WIDTH_M, abs=0.1)


@pytest.mark.parametrize(("gain_mps2", "waits"), [(0.0, False), (2.4, True)])
def test_car_expects_one_behind_it_that_accelerates_on_the_next_lane(gain_mps2, waits):
    plan = Manoeuvres(road_of(two_lanes(), changing(105.0)), np.array([]), CAR)
    for tick in range(11):
        before_s = 0.05 * (10 - tick)
        other = Other(80.0 - 10.0 * before_s, WIDTH_M, 10.0 - gain_mps2 * before_s)
        plan.decide(100.0 - 10.0 * before_s, 0.0, 10.0, [other.at(0.0)], math.inf)
    assert (plan.most_mps < 10.0 or plan.way.until_m > 0.0) == waits


def test_car_does_not_change_lanes_before_one_that_goes_to_the_next_lane_behind_it():
    plan = Manoeuvres(road_of(two_lanes(), changing(99.0)), np.array([]), CAR)
    for tick in range(-5, 1):
        speed_mps = 5.5 + 0.12 * tick
        other = DetectedObstacle(88.0 + 0.275 * tick, 1.6, 0.4, 4.7, 1.9, speed_mps, 7, "car")
        plan.decide(100.0 + 0.15 * tick, 0.0, 3.0, [other], math.inf)
    assert plan.way.until_m > 150.0  # it changes later


def test_car_stays_at_its_speed_while_one_behind_it_passes_on_the_next_lane():
    plan = Manoeuvres(road_of(two_lanes(), changing(105.0)), np.array([]), CAR)
    for tick in range(16):
        time_s = 0.05 * (tick - 15)
        other = Other(80.0 + 12.0 * time_s, WIDTH_M, 12.0 + 2.2 * time_s)
        plan.decide(100.0 + 10.0 * time_s, 0.0, 10.0, [other.at(0.0)], math.inf)
    assert plan.most_mps > 9.0 and abs(plan.way.offset_at(150.0)) > 3.0


def test_car_beside_a_dense_flow_drives_on_to_where_it_waits_for_a_gap_before_its_lane_ends():
    plan = Manoeuvres(road_of(two_lanes(), changing(600.0)), np.array([]), CAR)
    flow = [Other(x, WIDTH_M, 10.0, x).at(0.0) for x in range(500, 700, 12)]
    plan.decide(600.0, 0.0, 10.0, flow, math.inf)
    assert plan.most_mps > 9.0 and 640.0 < plan.stop_m < LENGTH_M - 8.0


@pytest.mark.parametrize(("place_m", "lane_y_m"), [(114.0, 0.0), (126.0, WIDTH_M)])
def test_change_of_lanes_that_has_begun_is_taken_back_or_completed(place_m, lane_y_m):
    points = changing(100.0)
    plan = Manoeuvres(road_of(two_lanes(), points), np.array([]), CAR)
    other = Other(place_m - 14.0, WIDTH_M - lane_y_m, 14.0).at(0.0)
    plan.decide(place_m, 0.0, 8.0, [other], math.inf)
    ends_m = place_m + 30.0
    y_m = plan.way.offset_at(ends_m) + np.interp(ends_m, *points.T)
    assert y_m == pytest.approx(lane_y_m, abs=0.1)


def test_car_pulls_out_after_the_one_that_comes():
    coming = [Other(-25.0, 0.0, 8.0), Other(-40.0, 0.0, 8.0, 8)]
    rows = drive(two_way(), coming, 30.0, start=(5.0, -2.8, 0.0))
    assert rows[-1, 2] == pytest.approx(0.0, abs=0.1) and rows[-1, 1] > 60.0


def test_way_is_the_route_when_the_road_is_free():
    road = road_of(two_way(), np.column_stack([np.arange(300.0), np.zeros(300)]))
    plan = Manoeuvres(road, np.array([]), CAR)
    rows = np.column_stack([road.route.points, np.full(300, MOST_MPS)])
    plan.decide(10.0, 0.0, 8.0, [Other(60.0, WIDTH_M, -8.0).at(0.0)], math.inf)
    assert plan.way.moved(rows, slice(0, 300)) is rows and plan.most_mps == math.inf


def test_car_alone_changes_lanes_with_its_route_without_braking():
    road = road_of(two_lanes(), changing(120.0), last_mps=2.0)
    plan = Manoeuvres(road, np.array([]), CAR)
    for s in range(400):
        plan.decide(float(s), 0.0, MOST_MPS, (), math.inf)
        assert plan.way.until_m == 0.0 and plan.most_mps == math.inf


def seen_car(s_m, y_m, along_mps, left_mps=0.0):
    """Return a car of 4.6 x 1.8 m, the only road user near ours."""
    return Around(
        rows=np.array([0]),
        s_m=np.array([s_m]),
        y_m=np.array([y_m]),
        along_mps=np.array([along_mps]),
        left_mps=np.array([left_mps]),
        half_length_m=np.array([2.3]),
        half_width_m=np.array([0.9]),
    )


def first_contact_s(way_m, from_m, speed_mps, others):
    """Return the time of the first contact of our car, at s 0, on a way of 100 places [s]."""
    result = forecast(
        ways_m=way_m[None],
        most_mps=np.full((1, 100), speed_mps),
        from_m=from_m,
        s_m=0.0,
        speed_mps=speed_mps,
        others=others,
        stop_m=np.array([math.inf]),
        margin=np.array([[1.0]]),
        car=CAR,
        line_m=np.full(100, math.inf),
    )
    return result.contact_s[0]


@pytest.mark.parametrize(("behind_m", "meets"), [(0.5, True), (6.0, False)])
def test_front_corner_of_a_car_that_stands_oblique_counts_for_one_beside_it(behind_m, meets):
    way_m = np.clip(0.25 * (np.arange(100.0) - 20.0), 0.0, 0.7)
    beside = seen_car(s_m=-behind_m, y_m=2.4, along_mps=1.0)
    assert (first_contact_s(way_m, -20.0, 1.0, beside) == 0.0) == meets


@pytest.mark.parametrize(("aside", "cuts_in"), [(0.0, False), (0.25, True)])
def test_car_in_its_lane_does_not_cut_in_before_one_behind_that_leaves_the_lane(aside, cuts_in):
    way_m = np.clip(aside * (np.arange(100.0) - 30.0), 0.0, 1.0)
    behind = seen_car(s_m=-25.0, y_m=0.3, along_mps=15.0, left_mps=2.0)
    assert np.isfinite(first_contact_s(way_m, -30.0, 5.0, behind)) == cuts_in
