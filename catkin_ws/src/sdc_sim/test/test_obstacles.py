"""Obstacles follow their plans, are added and removed, and never move into the vehicle."""

import dataclasses
import math

import pytest

from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import FIRST_ID, KINDS, ObstaclePlan, Obstacles

FAR = Rectangle(1000.0, 0.0, 0.0, 4.7, 2.0)
WALKER = ObstaclePlan(
    "pedestrian", ((0.0, -5.0), (0.0, 5.0), (4.0, 5.0)), KINDS["pedestrian"].size_m, speed_mps=2.0
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
        *((1.0, 0.0, -3.0, math.pi / 2, 2.0), (5.0, 0.0, 5.0, math.pi / 2, 2.0)),
        *((6.0, 2.0, 5.0, 0.0, 2.0), (60.0, 4.0, 5.0, 0.0, 0.0)),
    ],
)
def test_obstacle_moves_along_its_path_and_stops_at_the_end(seconds, x, y, yaw, speed):
    obstacles = Obstacles([WALKER])
    run(obstacles, seconds)
    body = obstacles.states[0]
    assert (body.x_m, body.y_m, body.yaw_rad, body.speed_mps) == pytest.approx(
        (x, y, yaw, speed), abs=1e-9
    )


def test_added_obstacle_moves_straight_on_until_it_is_changed_or_removed():
    obstacles = Obstacles([WALKER])
    number = obstacles.add(box(0.0, 9.0).straight_on(0.0, 2.0), FAR)
    run(obstacles, 1.0)
    obstacles.change(number, (math.pi / 2, 1.0))
    run(obstacles, 2.0)
    obstacles.change(number, (math.pi, 0.0))
    run(obstacles, 1.0)
    body = obstacles.states[1]
    assert (body.id, *body[2:5], body.speed_mps) == pytest.approx((102, 2.0, 11.0, math.pi, 0.0))
    obstacles.change(number, None)
    assert [one.id for one in obstacles.states] == [FIRST_ID]
    with pytest.raises(ValueError, match="no obstacle 102"):
        obstacles.change(number, None)


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


def test_toggle_adds_and_removes_an_obstacle():
    obstacles = Obstacles()
    assert "added" in obstacles.toggle(ObstaclePlan.stationary("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.states[0][:9] == (FIRST_ID, "car", 10.0, 0.0, 0.5, 4.7, 2.0, 1.45, 0.0)
    assert "removed" in obstacles.toggle(ObstaclePlan.stationary("car", 11.0, 0.5, 0.0), FAR)
    assert obstacles.states == ()
    obstacles.toggle(ObstaclePlan.stationary("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.states[0].id == FIRST_ID + 1, "an ID is never used twice"


def test_obstacle_on_the_vehicle_is_refused():
    obstacles = Obstacles()
    with pytest.raises(ValueError, match="ego vehicle is at"):
        obstacles.toggle(box(2.0, 0.0), EGO)
    assert obstacles.states == ()
