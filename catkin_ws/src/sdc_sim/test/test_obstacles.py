"""Obstacles follow their plans, are added and removed, and never move into the vehicle."""

from __future__ import annotations

import dataclasses
import math

import pytest

from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import FIRST_ID, KINDS, ObstaclePlan, Obstacles

FAR = Rectangle(1000.0, 0.0, 0.0, 4.7, 2.0)
WALKER = ObstaclePlan(
    "pedestrian", ((0.0, -5.0), (0.0, 5.0), (4.0, 5.0)), KINDS["pedestrian"][:3], speed_mps=2.0
)
EGO = Rectangle(0.0, 0.0, 0.0, 4.7, 2.0)


def box(x_m, y_m):
    return ObstaclePlan.stationary("obstacle", x_m, y_m, 0.0)


def run(obstacles, seconds, ego=FAR, step_s=0.05, from_s=0.0):
    events = []
    for tick in range(round(seconds / step_s)):
        events += obstacles.advance(from_s + tick * step_s, step_s, ego)
    return events


@pytest.mark.parametrize(
    ("seconds", "x", "y", "yaw", "speed"),
    [
        (1.0, 0.0, -3.0, math.pi / 2, 2.0),
        (5.0, 0.0, 5.0, math.pi / 2, 2.0),
        (6.0, 2.0, 5.0, 0.0, 2.0),
        (60.0, 4.0, 5.0, 0.0, 0.0),
    ],
)
def test_obstacle_moves_along_its_path_and_stops_at_the_end(seconds, x, y, yaw, speed):
    obstacles = Obstacles([WALKER])
    run(obstacles, seconds)
    body = obstacles.states[0]
    assert (body.x_m, body.y_m, body.yaw_rad, body.speed_mps) == pytest.approx(
        (x, y, yaw, speed), abs=1e-9
    )


def test_obstacle_waits_for_its_start_time():
    obstacles = Obstacles([dataclasses.replace(WALKER, start_s=3.0)])
    run(obstacles, 3.0)
    assert obstacles.states[0].y_m == -5.0
    run(obstacles, 1.0, from_s=3.0)
    assert obstacles.states[0].y_m == pytest.approx(-3.0)


def test_obstacle_waits_for_the_vehicle_and_then_does_not_stop():
    obstacles = Obstacles([dataclasses.replace(WALKER, trigger_m=20.0)])
    run(obstacles, 1.0, ego=FAR._replace(x_m=20.5, y_m=-5.0))
    assert obstacles.states[0].y_m == -5.0
    run(obstacles, 0.5, ego=FAR._replace(x_m=19.5, y_m=-5.0))
    run(obstacles, 0.5)
    assert obstacles.states[0].y_m == pytest.approx(-3.0)


def test_obstacle_stops_at_the_vehicle_with_one_event_and_continues_without_it():
    obstacles = Obstacles([WALKER])
    events = run(obstacles, 10.0, EGO)
    body = obstacles.states[0]
    assert [event.id for event in events] == [FIRST_ID]
    assert events[0].impulse_y_ns == pytest.approx(75.0 * 2.0)
    assert events[0].impulse_x_ns == pytest.approx(0.0, abs=1e-9)
    assert body.y_m == pytest.approx(-1.25, abs=1e-6)
    assert body.speed_mps == 0.0
    assert overlap(body.rectangle, EGO) is None
    run(obstacles, 1.0)
    assert obstacles.states[0].y_m == pytest.approx(0.75)


def test_reset_restores_the_scenario():
    obstacles = Obstacles([WALKER])
    run(obstacles, 2.0)
    obstacles.toggle(box(50.0, 0.0), FAR)
    obstacles.toggle(box(0.0, -1.0), FAR)
    assert [body.x_m for body in obstacles.states] == [50.0]
    obstacles.reset()
    assert [(body.id, body.y_m, body.speed_mps) for body in obstacles.states] == [
        (FIRST_ID, -5.0, 0.0)
    ]


def test_toggle_adds_and_removes_an_obstacle():
    obstacles = Obstacles()
    assert "added" in obstacles.toggle(ObstaclePlan.stationary("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.states[0] == (FIRST_ID, "car", 10.0, 0.0, 0.5, 4.7, 2.0, 1.45, 0.0)
    assert "removed" in obstacles.toggle(ObstaclePlan.stationary("car", 11.0, 0.5, 0.0), FAR)
    assert obstacles.states == ()
    obstacles.toggle(ObstaclePlan.stationary("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.states[0].id == FIRST_ID + 1, "an ID is never used twice"


def test_obstacle_on_the_vehicle_is_refused():
    obstacles = Obstacles()
    with pytest.raises(ValueError, match="ego vehicle is at"):
        obstacles.toggle(box(2.0, 0.0), EGO)
    assert obstacles.states == ()


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ((10.7, 5.0), "removed"),
        ((10.8, 5.0), "added"),
        ((10.0, 5.7), "removed"),
        ((10.0, 5.8), "added"),
    ],
)
def test_toggle_removes_what_is_within_half_a_metre(place, message):
    obstacles = Obstacles([ObstaclePlan.stationary("pedestrian", *place, 0.0)])
    assert obstacles.toggle(box(10.0, 5.0), FAR).startswith(message)


def test_every_obstacle_has_its_own_id():
    obstacles = Obstacles([WALKER, box(20.0, 0.0)])
    obstacles.toggle(box(30.0, 0.0), FAR)
    assert [body.id for body in obstacles.states] == [FIRST_ID, FIRST_ID + 1, FIRST_ID + 2]


@pytest.mark.parametrize(("ego_y_m", "moved_m"), [(11.0, 1.0), (11.5, 0.0)])
def test_trigger_is_the_distance_of_the_centres(ego_y_m, moved_m):
    plan = dataclasses.replace(WALKER, points_m=((3.0, -5.0), (3.0, 5.0)), trigger_m=20.0)
    obstacles = Obstacles([plan])
    obstacles.advance(0.0, 0.5, FAR._replace(x_m=15.0, y_m=ego_y_m))
    assert obstacles.states[0].y_m == -5.0 + moved_m


def test_place_is_taken_by_the_obstacle_that_overlaps_it():
    obstacles = Obstacles([box(0.0, 10.0), box(20.0, 0.0)])
    taken = obstacles.at(EGO._replace(x_m=18.0))
    assert taken is not None and taken.id == FIRST_ID + 1
    assert obstacles.at(EGO) is None


@pytest.mark.parametrize("speed_mps", [2.0, 0.5])
def test_impulse_is_normal_to_the_side_that_is_hit(speed_mps):
    obstacles = Obstacles([dataclasses.replace(WALKER, speed_mps=speed_mps)])
    ego = EGO._replace(yaw_rad=math.radians(30.0))
    for _ in range(200):
        events = obstacles.advance(0.0, 0.05, ego)
        if events:
            break
    # Of the momentum, the share cos(30 deg) is normal to the side.
    momentum = 75.0 * speed_mps * math.cos(math.radians(30.0))
    assert events[0].impulse_x_ns == pytest.approx(-momentum * 0.5)
    assert events[0].impulse_y_ns == pytest.approx(momentum * math.cos(math.radians(30.0)))
    assert obstacles.states[0].speed_mps == 0.0


def test_each_obstacle_that_hits_the_vehicle_is_an_event():
    other = dataclasses.replace(WALKER, points_m=((1.5, 8.0), (1.5, -8.0)))
    obstacles = Obstacles([WALKER, other])
    assert [event.id for event in run(obstacles, 10.0, EGO)] == [FIRST_ID, FIRST_ID + 1]
    obstacles.reset()
    assert [event.id for event in run(obstacles, 10.0, EGO)] == [FIRST_ID, FIRST_ID + 1]


def test_nearest_obstacle_stops_a_motion():
    obstacles = Obstacles([box(14.0, 0.0), box(8.0, 0.0), box(11.0, 0.0), box(5.0, 9.0)])
    stopped = obstacles.first_contact(lambda share: EGO._replace(x_m=20.0 * share))
    assert stopped is not None
    obstacle, contact = stopped
    assert obstacle.id == FIRST_ID + 1
    # From front bumper to box: 8 - 0.5 - 4.7 / 2.
    assert 20.0 * contact.share == pytest.approx(5.15, abs=1e-6)
    assert obstacles.first_contact(lambda share: EGO._replace(x_m=5.0 * share)) is None


def test_contact_is_new_again_when_it_was_over():
    # Gaps to the vehicle: 0.09 m ahead, 0.11 m behind, 0.05 m to the left.
    obstacles = Obstacles([box(2.94, 0.0), box(-2.96, 0.0), box(0.0, 1.55)])
    ahead, behind, left = (body.id for body in obstacles.states)
    assert obstacles.begin_contact(ahead) and obstacles.begin_contact(behind)
    assert not obstacles.begin_contact(ahead)
    obstacles.end_contacts(EGO)
    assert not obstacles.begin_contact(ahead), "a trembling contact is one event"
    assert obstacles.begin_contact(behind)
    assert obstacles.begin_contact(left), "it is near, but did not touch"
