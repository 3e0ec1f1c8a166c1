"""How the car passes, merges, pulls out and makes room, among others that keep their motion."""

import numpy as np
import pytest
from street_drives import (
    MOST_MPS,
    WIDTH_M,
    Other,
    changing,
    drive,
    new_planner,
    seen_at,
    straight,
    two_lanes,
    two_way,
    y_at,
)

from sdc_common.driving import DetectedObstacle
from sdc_map.network import BROKEN, SOLID

pytestmark = pytest.mark.slow(20)


def test_car_passes_one_at_rest_and_returns():
    rows = drive(two_way(), [Other(100.0)], 25.0)
    assert y_at(rows, 100.0) > 2.3
    assert y_at(rows, 40.0) == pytest.approx(0.0, abs=0.1)
    assert y_at(rows, 160.0) == pytest.approx(0.0, abs=0.01)
    assert rows[:, 3].min() > 5.5  # it hardly slows down


def test_car_passes_one_that_stands_partly_in_its_lane_beside_the_oncoming_ones():
    stream = [Other(120.0 + 22.0 * n, WIDTH_M, -6.0, 10 + n) for n in range(25)]
    rows = drive(two_way(), [Other(100.0, 1.65), *stream], 40.0)
    assert y_at(rows, 100.0) == pytest.approx(-0.7, abs=0.05)


def test_car_drives_on_beside_an_oncoming_one_that_waits_with_a_corner_in_its_lane():
    lorry = DetectedObstacle(60.0, 2.43, 0.2 - np.pi, 7.5, 2.3, 0.0, 7, "lorry")
    path = new_planner(two_way(), straight(300.0)).plan(seen_at(45.0, 0.0, 8.0, [lorry]))
    assert min(mps for *_, mps in path.points) > 0.0


def test_car_waits_for_the_oncoming_one():
    others = [Other(100.0), *(Other(x, WIDTH_M, -8.0, 8 + x) for x in (150.0, 180.0, 230.0))]
    rows = drive(two_way(), others, 50.0)
    assert rows[-1, 1] > 150.0 and y_at(rows, 100.0) > 2.3
    assert rows[:, 3].min() < 4.0


@pytest.mark.parametrize(("marking", "passes"), [(BROKEN, True), (SOLID, False)])
def test_car_overtakes_a_slow_one_if_the_line_allows(marking, passes):
    lorry = Other(40.0, speed_mps=4.0, kind="lorry", size=(9.0, 2.5))
    rows = drive(two_way(marking), [lorry], 35.0)
    assert (rows[-1, 1] > 40.0 + 35.0 * 4.0 + 10.0) == passes
    assert rows[-1, 2] == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("length_m", "passes"), [(4.7, True), (60.0, False)])
def test_car_overtakes_only_whom_it_passes_in_a_short_time(length_m, passes):
    rows = drive(two_way(), [Other(50.0, speed_mps=5.0, size=(length_m, 1.8))], 25.0)
    assert (rows[-1, 1] > 50.0 + 25.0 * 5.0 + 10.0) == passes


def test_car_overtakes_on_the_next_lane_after_a_faster_one():
    rows = drive(two_lanes(), [Other(50.0, speed_mps=4.0), Other(-30.0, WIDTH_M, 18.0, 8)], 30.0)
    assert rows[-1, 1] > 50.0 + 4.0 * 30.0


@pytest.mark.parametrize("behind_m", [50.0, 60.0, 70.0, 80.0])
def test_car_makes_room_for_an_ambulance(behind_m):
    ambulance = Other(-behind_m, 0.0, 18.0, kind="ambulance", size=(5.9, 2.0))
    rows = drive(two_lanes(), [ambulance], 20.0)
    beside = rows[np.argmin(np.abs(rows[:, 1] - (-behind_m + 18.0 * rows[:, 0])))]
    assert beside[2] > 2.5


def test_car_makes_room_again_for_the_next_one_that_invades_its_lane():
    invaders = [Other(x, 2.2, -8.0, number) for number, x in enumerate((60.0, 95.0, 130.0), 7)]
    rows = drive(two_way(), invaders, 12.0)
    for invader in invaders:
        meets = np.argmin(np.abs(rows[:, 1] - invader.x_m + 8.0 * rows[:, 0]))
        assert rows[meets, 2] < -0.5


@pytest.mark.parametrize("speed_mps", [8.0, 11.0])
def test_car_lets_those_beside_it_go_first_where_its_route_changes_lanes(speed_mps):
    flow = [Other(x, WIDTH_M, speed_mps, 8 - x) for x in (-14, 4, 22)]
    rows = drive(two_lanes(), flow, 40.0, changing(120.0))
    assert rows[-1, 1] > 250.0 and rows[-1, 2] == pytest.approx(WIDTH_M, abs=0.1)


def test_car_beside_a_dense_flow_drives_on_to_where_it_waits_for_a_gap_before_its_lane_ends():
    planner = new_planner(two_lanes(), changing(600.0))
    flow = [Other(x, WIDTH_M, 10.0, x).at(0.0) for x in range(500, 700, 12)]
    path = planner.plan(seen_at(600.0, 0.0, 10.0, flow))
    assert path.points[0][2] > 7.0 and 620.0 < planner.decision.stop_m < 692.0
    # If there is a gap, the car changes lanes as gently as its speed asks for.
    assert np.abs(np.diff(planner.way.offset_m)).max() < 0.25


def test_car_pulls_out_after_the_one_that_comes():
    coming = [Other(-25.0, 0.0, 8.0), Other(-40.0, 0.0, 8.0, 8)]
    rows = drive(two_way(), coming, 30.0, start=(5.0, -2.8, 0.0))
    assert rows[-1, 2] == pytest.approx(0.0, abs=0.1) and rows[-1, 1] > 60.0


def test_way_is_the_route_when_the_road_is_free():
    planner = new_planner(two_way(), straight(300.0))
    planner.plan(seen_at(10.0, 0.0, 8.0, [Other(60.0, WIDTH_M, -8.0).at(0.0)]))
    assert planner.way.until_m == 0.0 and planner.decision.reason == ""


def test_car_alone_changes_lanes_with_its_route_without_braking():
    planner = new_planner(two_lanes(), changing(120.0))
    far = [Other(650.0, WIDTH_M, MOST_MPS).at(0.0)]
    for s_m in range(0, 300, 5):
        y_m = float(np.interp(s_m, *changing(120.0).T))
        path = planner.plan(seen_at(float(s_m), y_m, MOST_MPS, far, s_m))
        assert planner.way.until_m == 0.0 and path.points[0][2] > 11.0


def test_car_that_passes_one_waits_with_room_before_the_next_one():
    def cone(x_m, y_m, number, width_m=0.5):
        return Other(x_m, y_m, number=number, kind="obstacle", size=(0.5, width_m))

    cones = [cone(65.0, -1.2, 1), cone(72.0, -0.4, 2), cone(76.0, -0.2, 3, 2.0)]
    stream = [Other(70.0 + 22.0 * n, WIDTH_M, -6.0, 10 + n) for n in range(12)]
    rows = drive(two_way(), [*cones, *stream], 90.0)
    assert rows[:, 3].min() < 0.5 and rows[-1, 1] > 150.0


def unit_circle(last, count):
    turn = np.linspace(-0.5, last, count, endpoint=False) * np.pi
    return np.column_stack([np.cos(turn), np.sin(turn)])


@pytest.mark.parametrize("beside_m", [0.3, 1.7])
def test_car_stops_behind_one_on_its_pass_where_the_route_leads_past_the_place_again(beside_m):
    circle = unit_circle(0.5, 60)
    right = (70.0, 15.0) + 15.0 * circle
    left = (50.0, 15.0 + 0.5 * beside_m) - (15.0 - 0.5 * beside_m) * circle
    back = np.column_stack([np.arange(70.0, 50.0, -1.0), np.full(20, 30.0)])
    points_m = np.vstack([straight(70.0), right, back, left, straight(70.0) + (50.0, beside_m)])
    planner = new_planner(two_way(), points_m, keeps_route=True)
    path = planner.plan(seen_at(45.0, 0.0, 8.0, [Other(62.0, beside_m).at(0.0)]))
    assert min(mps for *_, mps in path.points) == 0.0 and planner.reason == "obstacle"


@pytest.mark.parametrize(("outside_m", "passes"), [(2.2, False), (3.2, True)])
def test_car_knows_that_its_front_swings_out_in_a_tight_bend(outside_m, passes):
    up = np.column_stack([np.full(50, 34.0), np.arange(4.0, 54.0)])
    points_m = np.vstack([straight(30.0), (30.0, 4.0) + 4.0 * unit_circle(0.0, 8), up])
    planner = new_planner(two_way(), points_m, keeps_route=True)
    away_m = np.sqrt(0.5) * (4.0 + outside_m)
    walker = Other(30.0 + away_m, 4.0 - away_m, kind="pedestrian", size=(0.5, 0.5)).at(0.0)
    path = planner.plan(seen_at(26.0, 0.0, 2.0, [walker]))
    assert (min(mps for *_, mps in path.points) > 0.0) == passes


@pytest.mark.parametrize(("y_m", "starts"), [(0.9, True), (2.3, False)])
def test_car_starts_before_one_behind_it_but_not_before_one_that_passes_it(y_m, starts):
    planner = new_planner(two_lanes(), changing(100.0))
    path = planner.plan(seen_at(*changing(100.0)[112], 0.0, [Other(104.0, y_m, 6.0).at(0.0)]))
    assert (max(mps for *_, mps in path.points[:5]) > 0.0) == starts
