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


def test_nearest_obstacle_stops_a_motion():
    obstacles = Obstacles([box(14.0, 0.0), box(8.0, 0.0), box(11.0, 0.0), box(5.0, 9.0)])
    stopped = obstacles.first_contact(lambda share: EGO._replace(x_m=20.0 * share))
    assert stopped is not None
    obstacle, contact = stopped
    assert obstacle.id == FIRST_ID + 1
    # From front bumper to box: 8 - 0.5 - 4.7 / 2.
    assert 20.0 * contact.share == pytest.approx(5.15, abs=1e-6)
    assert obstacles.first_contact(lambda share: EGO._replace(x_m=5.0 * share)) is None
