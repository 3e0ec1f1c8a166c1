"""Scripted road users: they follow, brake, wait for their trigger, and come again."""

import numpy as np
import pytest

from sdc_sim.physics.collision import Rectangle
from sdc_sim.physics.obstacles import FIRST_TRAFFIC_ID
from sdc_sim.physics.traffic_lights import TrafficLightPlan
from sdc_sim.traffic.actors import Actor, ScriptedTraffic

TICK_S = 0.05
EAST_M = np.column_stack([np.arange(0.0, 301.0), np.zeros(301)])
MISSION_M = np.array([[0.0, -50.0], [300.0, -50.0]])
AWAY = Rectangle(0.0, -50.0, 0.0, 4.7, 2.0)
CAR, WALKER = (4.7, 2.0, 1.45), (0.5, 0.5, 1.75)
FLOW = {"gaps_s": [[1.0, 2.0], [1.0, 2.0], [8.0, 9.0]]}


def car_at(x_m, y_m=0.0, yaw_rad=0.0):
    return Rectangle(x_m, y_m, yaw_rad, 4.7, 2.0)


def drive(actors, seconds, ego=lambda time_s: (AWAY, 0.0), lights=(), seed=1):
    """Return the states by id in each tick."""
    traffic = ScriptedTraffic(actors, MISSION_M, seed, TICK_S, lights)
    seen = [{one.id: one for one in traffic.reset(AWAY)}]
    for tick in range(round(seconds / TICK_S)):
        body, speed_mps = ego(tick * TICK_S)
        seen.append({one.id: one for one in traffic.advance(body, speed_mps, False, set())})
    return seen


def test_followers_keep_their_distance_also_when_the_first_one_brakes_hard():
    first = Actor("car", EAST_M, 80.0, CAR, 12.0, ((4.0, 0.0, 7.0),), at_m=0.0, within_m=1.0)
    others = [Actor("car", EAST_M, 80.0 - 18.0 * n, CAR, 12.0) for n in (1, 2, 3)]
    seen = drive([first, *others], 12.0)
    x = np.array([[tick[FIRST_TRAFFIC_ID + n].x_m for n in range(4)] for tick in seen])
    assert (-np.diff(x, axis=1) - CAR[0]).min() > 0.5
    assert all(one.speed_mps < 0.3 for one in seen[-1].values())


@pytest.mark.parametrize("yaw_rad", [0.0, 0.4, np.pi])
def test_one_that_looks_stops_for_the_car_on_its_way(yaw_rad):
    ego = car_at(120.0, 1.0, yaw_rad)
    last = drive([Actor("car", EAST_M, 10.0, CAR, 12.0)], 20.0, lambda _: (ego, 0.0))[-1]
    (one,) = last.values()
    assert one.speed_mps < 0.1 and 105.0 < one.x_m < 116.0


def test_one_that_does_not_look_drives_on_but_spares_a_car_at_rest():
    blind = Actor("car", EAST_M, 10.0, CAR, 8.0, looks=False)
    (moving,) = drive([blind], 20.0, lambda _: (car_at(120.0), 2.0))[-1].values()
    (resting,) = drive([blind], 20.0, lambda _: (car_at(120.0), 0.0))[-1].values()
    assert moving.x_m > 150.0 and resting.x_m < 116.0


def test_car_beside_the_way_stops_no_one():
    last = drive([Actor("car", EAST_M, 10.0, CAR, 8.0)], 20.0, lambda _: (car_at(120.0, 3.5), 0.0))
    assert last[-1][FIRST_TRAFFIC_ID].x_m == pytest.approx(170.0)


def test_actor_waits_for_its_trigger_in_distance_and_time():
    steps = ((0.0, 1.5, 4.0),)
    for speed_mps, within_m, within_s, at_s in ((10.0, 20.0, 0.0, 8.0), (10.0, 5.0, 2.0, 7.5)):
        trigger = {"at_m": 100.0, "within_m": within_m, "within_s": within_s}
        actor = Actor("pedestrian", EAST_M[:8], 0.0, WALKER, 0.0, steps, **trigger)
        seen = drive([actor], 20.0, lambda t, v=speed_mps: (car_at(v * t, -50.0), v))
        moved = [tick[FIRST_TRAFFIC_ID].x_m > 0.0 for tick in seen]
        assert moved.index(True) * TICK_S == pytest.approx(at_s, abs=0.15)
        assert seen[-1][FIRST_TRAFFIC_ID].x_m == 7.0  # it stays at the end of its way


def test_vehicles_of_a_flow_come_again_with_their_gaps_in_turn():
    flow = [Actor("car", EAST_M, 290.0 - 20.0 * n, CAR, 10.0, **FLOW) for n in range(12)]
    seen = drive(flow, 120.0)
    assert not {*seen[0]} & {*seen[-1]} and max(seen[-1]) > FIRST_TRAFFIC_ID + 12
    passes = [t for t in range(len(seen) - 1) if crossed(seen[t], seen[t + 1], 100.0)]
    gaps_s = np.diff(passes)[11:] * TICK_S
    assert gaps_s.min() > 1.0 and 0.2 < np.mean(gaps_s > 7.0) < 0.45


def crossed(before, after, x_m):
    return any(n in after and before[n].x_m < x_m <= after[n].x_m for n in before)


def test_same_seed_gives_the_same_motion_and_reset_repeats_it():
    flow = [Actor("car", EAST_M, 250.0 - 30.0 * n, CAR, 10.0, **FLOW) for n in range(4)]
    assert drive(flow, 60.0) == drive(flow, 60.0) != drive(flow, 60.0, seed=2)
    traffic = ScriptedTraffic(flow, MISSION_M, 1, TICK_S)
    runs = []
    for _ in range(2):
        traffic.reset(AWAY)
        runs.append([traffic.advance(AWAY, 0.0, False, set()) for _ in range(900)])
    assert runs[0] == runs[1]


@pytest.mark.parametrize("looks", [True, False])
def test_red_light_stops_those_who_look(looks):
    light = TrafficLightPlan(100.0, 0.0, 0.0, (("red", 60.0), ("green", 60.0)))
    seen = drive([Actor("car", EAST_M, 10.0, CAR, 12.0, looks=looks)], 80.0, lights=[light])
    at_red = seen[round(20.0 / TICK_S)].get(FIRST_TRAFFIC_ID)
    assert (at_red.speed_mps < 0.2 and at_red.x_m + 2.35 < 100.0) == looks
    assert seen[-1][FIRST_TRAFFIC_ID].x_m > 110.0  # it is green


def test_one_that_has_met_the_car_is_held():
    traffic = ScriptedTraffic([Actor("car", EAST_M, 10.0, CAR, 8.0)], MISSION_M, 1, TICK_S)
    traffic.reset(AWAY)
    before = traffic.advance(AWAY, 0.0, False, set())
    for _ in range(5):
        held = traffic.advance(AWAY, 0.0, False, {FIRST_TRAFFIC_ID})
    assert held[0].x_m == pytest.approx(before[0].x_m, abs=0.5)
    assert held[0].speed_mps < 0.5
