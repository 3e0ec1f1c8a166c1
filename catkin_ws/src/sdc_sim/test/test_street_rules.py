"""What the referee counts on streets: a drive that provokes it, and one that barely does not."""

import math
import sys
from functools import lru_cache

import numpy as np
import pytest

from sdc_map.map_file import map_file
from sdc_map.mirror import mirrored
from sdc_map.network_file import load_network
from sdc_sim.evaluation.lane_rules import ARTICLES
from sdc_sim.evaluation.route_progress import DriveSample
from sdc_sim.evaluation.street_rules import StreetRules
from sdc_sim.physics.collision import Rectangle, overlap
from sdc_testing.street_maps import bridge, needs_maps, town

pytestmark = needs_maps

TICK_S, FRONT_M = 0.05, 2.35
EAST, SOUTH, WEST = 0.0, -0.5 * math.pi, math.pi
_mirrored = lru_cache(mirrored)


class RulesInMirror(StreetRules):
    """The referee in the mirror image of streets, where traffic is on the left."""

    def __init__(self, network, front_m):
        super().__init__(_mirrored(network), front_m)

    def add_car(self, stamp_ns, sample, *height_m):
        sample = sample._replace(y_m=-sample.y_m, yaw_rad=-sample.yaw_rad)
        return super().add_car(stamp_ns, sample, *height_m)

    def add_others(self, stamp_ns, rows):
        rows = [(number, x, -y, -yaw, *others) for number, x, y, yaw, *others in rows]
        return super().add_others(stamp_ns, rows)


@pytest.fixture(autouse=True, params=["right", "left"])
def side(request, monkeypatch):
    if request.param == "left":
        monkeypatch.setattr(sys.modules[__name__], "StreetRules", RulesInMirror)


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    kinds = "priority", "priority_stop"
    return {one: load_network(town(tmp_path_factory.mktemp(one), mid=one)) for one in kinds}


def straight(x, y, yaw, speed):
    """Return a motion: time to x, y, yaw, speed."""
    c, s = math.cos(yaw), math.sin(yaw)
    return lambda t: (x + speed * t * c, y + speed * t * s, yaw, speed)


def stopping(x, y, yaw, speed, until_s, stands_s):
    """Return a motion that stands from a time on for some time."""

    def motion(t):
        driven = straight(x, y, yaw, speed)
        if t < until_s:
            return driven(t)
        if t < until_s + stands_s:
            return (*driven(until_s)[:3], 0.0)
        return driven(t - stands_s)

    return motion


def counted(network, car, duration_s, other=None, late=0, kind="car", others=()):
    """Return the names of what is counted; the other ones are seen some ticks late."""
    rules, found, waiting = StreetRules(network, FRONT_M), [], []
    for tick in range(1, round(duration_s / TICK_S)):
        t = tick * TICK_S
        found += rules.add_car(tick, DriveSample(t, *car(t), 0.0, 0.0, 0.0))
        places = enumerate(one(t) for one in [other or straight(0.0, 900.0, 0.0, 0.0), *others])
        waiting.append((tick, [(7 + i, *at[:3], 4.7, 1.9, at[3], kind) for i, at in places]))
        if len(waiting) > late:
            found += rules.add_others(*waiting.pop(0))
    for one in waiting:
        found += rules.add_others(*one)
    return [name for name, _ in found]


# Street d leads south to the junction in the origin on x = -1.6, with a limit of 8 m/s, and gives
# way to street a, which leads east on y = -1.6.
@pytest.mark.parametrize(
    ("car", "duration_s", "expected"),
    [
        (straight(-1.6, 110.0, SOUTH, 8.9), 4.0, []),
        (straight(-1.6, 110.0, SOUTH, 9.1), 0.9, []),
        (straight(-1.6, 110.0, SOUTH, 9.1), 4.0, ["speeding"]),
        (straight(-30.0, -1.6, WEST, 8.0), 0.9, []),
        (straight(-30.0, 1.6, WEST, 8.0), 4.0, []),
        (straight(-30.0, -1.6, WEST, 8.0), 4.0, ["wrong_lane"]),
        (stopping(-60.0, -1.6, EAST, 10.0, 6.0, 4.7), 14.0, []),
        (stopping(-60.0, -1.6, EAST, 10.0, 6.0, 5.2), 14.0, ["blocking"]),
        (stopping(-60.0, -1.6, EAST, 10.0, 3.0, 9.0), 14.0, []),
    ],
)
def test_alone_on_the_streets(networks, car, duration_s, expected):
    assert counted(networks["priority"], car, duration_s) == expected


@pytest.mark.parametrize(("speed_mps", "expected"), [(0.0, []), (4.0, []), (14.0, ["wrong_lane"])])
def test_car_that_passes_a_slower_one_may_use_the_other_lane(networks, speed_mps, expected):
    car = straight(-30.0, -1.6, WEST, 8.0)
    assert (
        counted(networks["priority"], car, 4.0, straight(-50.0, 1.6, WEST, speed_mps)) == expected
    )


@pytest.mark.parametrize("kind", ["priority", "priority_stop"])
@pytest.mark.parametrize("gap_m", [None, 0.5, 5.0])
def test_stop_sign_needs_a_stop_before_its_line(networks, kind, gap_m):
    network = networks[kind]
    line_y = network.lanes["d_1"].points_m[-1][1]
    car = straight(-1.6, 60.0, SOUTH, 7.0)
    if gap_m is not None:
        car = stopping(-1.6, 60.0, SOUTH, 7.0, (60.0 - line_y - FRONT_M - gap_m) / 7.0, 1.0)
    ran = kind == "priority_stop" and gap_m != 0.5
    assert counted(network, car, 12.0) == ["stop"] * ran


@pytest.mark.parametrize("late", [0, 1, 7])
@pytest.mark.parametrize(
    ("arrives_s", "expected"), [(1.5, ["right_of_way"]), (3.0, []), (60.0, [])]
)
def test_right_of_way_is_that_of_who_arrives_soon(networks, late, arrives_s, expected):
    network = networks["priority"]
    line_y, line_x = network.lanes["d_1"].points_m[-1][1], network.lanes["a_2"].points_m[-1][0]
    car = straight(-1.6, line_y + FRONT_M + 35.0, SOUTH, 7.0)  # its front is on the line after 5 s
    other = straight(line_x - 2.35 - 12.0 * (5.0 + arrives_s), -1.6, EAST, 12.0)
    names = counted(network, car, 9.0, other, late)
    assert [name for name in names if name != "near_miss"] == expected


@pytest.mark.parametrize(
    ("gap_m", "side_m", "speed_mps", "expected"),
    [
        *((9.9, 0.0, 0.0, ["near_miss"]), (10.1, 0.0, 0.0, []), (9.9, 3.2, 0.0, [])),
        (9.9, 0.0, 10.0, []),
    ],
)
def test_time_to_collision(networks, gap_m, side_m, speed_mps, expected):
    car = stopping(-100.0, -1.6, EAST, 10.0, 3.01, 60.0)  # it stands from -70 m on
    other = straight(-70.0 + 4.7 + gap_m - 3.0 * speed_mps, -1.6 - side_m, EAST, speed_mps)
    assert counted(networks["priority"], car, 4.0, other) == expected


@pytest.mark.parametrize(("behind_s", "expected"), [(0.8, ["near_miss"]), (1.2, [])])
def test_post_encroachment_time(networks, behind_s, expected):
    car = straight(-100.0, -1.6, EAST, 10.0)
    # The back of the car leaves x = -79.05, the near side of the other one, at this time.
    left_s = (-79.05 + FRONT_M + 100.0) / 10.0
    other = straight(-80.0, -0.65 + 2.35 + 6.0 * (left_s + behind_s), SOUTH, 6.0)
    assert counted(networks["priority"], car, 6.0, other) == expected


def shifting(x, speed, to_y, from_y=-1.6):
    """Return a motion that goes over to another lane between 2 and 4 s."""
    return lambda t: (x + speed * t, np.interp(t, [2, 4], [from_y, to_y]), EAST, speed)


def of_lanes(networks, *drive, **others):
    """Return what is counted of the rules about lanes."""
    return [name for name in counted(networks["priority"], *drive, **others) if name in ARTICLES]


# The crosswalk is at y from 6.4 to 10.4; the front of the car enters it after 3.7 s, at x = -1.6.
@pytest.mark.parametrize(
    ("x", "yaw", "speed_mps", "y", "expected"),
    [
        (-1.6, EAST, 0.0, 8.4, 1),  # in the strip of the car
        (-1.6, EAST, 0.0, 12.0, 0),  # beside the crosswalk
        (1.3, WEST, 0.0, 8.4, 0),  # beside the strip
        (1.3 + 3.7, WEST, 1.0, 8.4, 1),  # 1.15 m from it, to it
        (1.3 - 3.7, EAST, 1.0, 8.4, 0),  # away from it
        (2.0 + 3.7, WEST, 1.0, 8.4, 0),  # 1.85 m from it
    ],
)
def test_crosswalk_counts_once_for_a_pedestrian(networks, x, yaw, speed_mps, y, expected):
    car, walker = straight(-1.6, 10.4 + FRONT_M + 25.9, SOUTH, 7.0), straight(x, y, yaw, speed_mps)
    assert of_lanes(networks, car, 4.5, walker, kind="pedestrian") == ["crosswalk"] * expected
    assert of_lanes(networks, car, 4.5, walker) == []


@pytest.mark.parametrize(
    ("gap_m", "y", "speed_mps", "duration_s", "expected"),
    [
        *((9.5, -1.6, 10.0, 8.0, 1), (9.5, -1.6, 10.0, 3.0, 0), (10.5, -1.6, 10.0, 8.0, 0)),
        *((9.5, -4.8, 10.0, 8.0, 0), (4.0, -1.6, 4.9, 8.0, 0)),
    ],
)
def test_distance_counts_after_three_seconds(networks, gap_m, y, speed_mps, duration_s, expected):
    car = straight(-145.0, -1.6, EAST, speed_mps)
    ahead = straight(-145.0 + 4.7 + gap_m, y, EAST, speed_mps)
    assert of_lanes(networks, car, duration_s, ahead) == ["distance"] * expected


@pytest.mark.parametrize(("duration_s", "expected"), [(5.5, []), (7.5, ["distance"])])
def test_distance_counts_from_when_another_one_cuts_in(networks, duration_s, expected):
    car, cuts_in = straight(-145.0, -1.6, EAST, 10.0), shifting(-138.0, 10.0, -1.6, -4.8)
    far = straight(-131.0, -1.6, EAST, 10.0)
    assert of_lanes(networks, car, duration_s, far, others=[cuts_in]) == expected


@pytest.mark.parametrize(
    ("to_y", "other", "expected"),
    [
        (1.6, None, ["solid_line"]),
        (-4.8, None, []),
        (0.05, None, []),  # still on the line
        (1.6, straight(-80.0, -1.6, EAST, 0.0), []),
        (1.6, straight(-80.0, -1.6, EAST, 3.0), ["solid_line"]),
        (-4.8, straight(-106.0, -4.8, EAST, 10.0), ["cut_in"]),  # 1.3 m behind
        (-4.8, straight(-109.0, -4.8, EAST, 10.0), []),
        (-4.8, straight(-106.0, -1.6, EAST, 10.0), []),  # behind on the lane that the car leaves
        (-4.8, straight(-128.0, -4.8, EAST, 16.0), ["cut_in"]),  # needs more than 3 m/s^2
        (-4.8, straight(-130.5, -4.8, EAST, 16.0), []),
    ],
)
def test_changes_of_lane(networks, to_y, other, expected):
    assert of_lanes(networks, shifting(-100.0, 10.0, to_y), 6.0, other) == expected


# In our town, the lane m_w4_0 ends at x = 213 on y = -289.25, beside m_w4_1 on y = -292.75.
ENDING, THROUGH = -289.25, -292.75


@pytest.mark.parametrize(
    ("ahead", "waits_m", "expected"),
    [
        (straight(240.0, THROUGH, WEST, 4.0), 4.0, ["zip_merge"]),
        (straight(900.0, THROUGH, WEST, 4.0), 4.0, []),  # no queue
        (straight(240.0, THROUGH, WEST, 4.0), 900.0, []),
        (straight(240.0, THROUGH, WEST, 4.0), 8.0, []),  # it is still behind the car at the end
        (lambda t: (240 - 4 * t, ENDING if t < 3.5 else THROUGH, WEST, 4.0), 4.0, []),  # let in
    ],
)
def test_where_a_lane_ends_they_take_turns(ahead, waits_m, expected):
    network, car = load_network(map_file("town")), straight(252.0, THROUGH, WEST, 4.0)
    others = [ahead, straight(213.0 + waits_m, ENDING, WEST, 0.0)]
    assert counted(network, car, 11.0, others=others) == expected


@pytest.mark.parametrize(
    ("car", "other", "expected"),
    [
        (straight(-60.0, -1.6, EAST, 9.0), straight(-40.0, -1.6, EAST, 0.0), True),
        (straight(-60.0, -1.6, EAST, 9.0), straight(-40.0, -1.6, EAST, 4.0), True),
        (straight(-60.0, -1.6, EAST, 9.0), straight(-20.0, -1.6, WEST, 9.0), True),
        (straight(-60.0, -3.2, EAST, 4.0), straight(-80.0, -3.2, EAST, 14.0), False),
        (straight(-60.0, -1.6, EAST, 0.0), straight(-40.0, -1.6, WEST, 9.0), False),
        (
            lambda t: (-60.0 - 3.0 * t, -1.6, EAST, 3.0),  # backwards
            straight(-80.0, -1.6, EAST, 0.0),
            True,
        ),
        # Beside the car: the one that leaves its lane is at fault.
        (straight(-60.0, -1.6, EAST, 9.0), straight(-60.0, -4.8, 0.1, 9.0), False),
        (straight(-60.0, -1.6, -0.1, 9.0), straight(-64.0, -4.8, EAST, 9.0), True),
        # Across the junction: the front of the car, and that of the other one.
        (straight(-20.0, -1.6, EAST, 9.0), straight(-1.6, 15.0, SOUTH, 8.5), True),
        (straight(-20.0, -1.6, EAST, 9.0), straight(-1.6, 24.0, SOUTH, 9.0), False),
    ],
)
def test_fault_for_a_collision(networks, car, other, expected):
    rules = StreetRules(networks["priority"], FRONT_M)
    for tick in range(1, 200):
        t = tick * TICK_S
        here, there = car(t), other(t)
        if overlap(Rectangle(*here[:3], 4.7, 1.9), Rectangle(*there[:3], 4.7, 1.9)):
            break
        rules.add_car(tick, DriveSample(t, *here, 0.0, 0.0, 0.0))
        rules.add_others(tick, [(7, *there[:3], 4.7, 1.9, there[3], "car")])
    assert rules.is_at_fault(7, t) == expected
    assert rules.is_at_fault(0, t) == (here[3] > 0.0), "a building"


@pytest.mark.parametrize(("z_m", "expected"), [(6.0, ["near_miss"]), (0.0, [])])
def test_only_one_on_the_level_of_the_car_counts(tmp_path, z_m, expected):
    rules, found = StreetRules(load_network(bridge(tmp_path)), FRONT_M), []
    car, other = straight(-30.0, -1.75, EAST, 10.0), straight(1.75, -32.0, -SOUTH, 10.0)
    for tick in range(1, 100):
        t = tick * TICK_S
        found += rules.add_car(tick, DriveSample(t, *car(t), 0.0, 0.0, 0.0), 6.0)
        *pose, speed = other(t)
        found += rules.add_others(tick, [(7, *pose, 4.7, 1.9, z_m, speed, "car")])
    assert [name for name, _ in found] == expected
