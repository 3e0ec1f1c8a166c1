"""What the referee counts on streets: a drive that provokes it, and one that barely does not."""

import math

import pytest
from street_maps import needs_maps, town

from sdc_sim.evaluation.route_progress import DriveSample
from sdc_sim.evaluation.street_rules import StreetRules

pytestmark = needs_maps

TICK_S, FRONT_M = 0.05, 2.35
EAST, SOUTH, WEST = 0.0, -0.5 * math.pi, math.pi


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    from sdc_sim.road.network_file import load_network

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


def counted(network, car, duration_s, other=None, late=0):
    """Return the names of what is counted; the other one is seen some ticks late."""
    rules, found, waiting = StreetRules(network, FRONT_M), [], []
    for tick in range(1, round(duration_s / TICK_S)):
        t = tick * TICK_S
        found += rules.add_car(tick, DriveSample(t, *car(t), 0.0, 0.0, 0.0))
        x, y, yaw, speed = other(t) if other else (0.0, 900.0, 0.0, 0.0)
        waiting.append((tick, [(7, x, y, yaw, 4.7, 1.9, speed, "car")]))
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
        (9.9, 0.0, 0.0, ["near_miss"]),
        (10.1, 0.0, 0.0, []),
        (9.9, 3.2, 0.0, []),
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
