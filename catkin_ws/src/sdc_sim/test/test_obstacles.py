"""Obstacles start, move and stop as their plans say, come and go by a click, and never move into the car."""

from __future__ import annotations

import math

import pytest

from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import FIRST_ID, KINDS, ObstaclePlan, Obstacles

FAR = Rectangle(1000.0, 0.0, 0.0, 4.7, 2.0)
WALKER = ObstaclePlan(
    "pedestrian", ((0.0, -5.0), (0.0, 5.0), (4.0, 5.0)), KINDS["pedestrian"][:3], speed_mps=2.0
)


def run(obstacles, seconds, car=FAR, step_s=0.05, from_s=0.0):
    touches = []
    for tick in range(round(seconds / step_s)):
        touches += obstacles.advance(from_s + tick * step_s, step_s, car)
    return touches


@pytest.mark.parametrize(
    ("seconds", "x", "y", "yaw", "speed"),
    [
        (1.0, 0.0, -3.0, math.pi / 2, 2.0),
        (5.0, 0.0, 5.0, math.pi / 2, 2.0),
        (6.0, 2.0, 5.0, 0.0, 2.0),
        (60.0, 4.0, 5.0, 0.0, 0.0),
    ],
)
def test_walks_along_its_path_and_stays_at_the_end(seconds, x, y, yaw, speed):
    obstacles = Obstacles([WALKER])
    run(obstacles, seconds)
    body = obstacles.bodies[0]
    assert (body.x_m, body.y_m, body.yaw_rad, body.speed_mps) == pytest.approx(
        (x, y, yaw, speed), abs=1e-9
    )


def test_waits_for_its_time():
    obstacles = Obstacles([WALKER.__class__(**{**WALKER.__dict__, "start_s": 3.0})])
    run(obstacles, 3.0)
    assert obstacles.bodies[0].y_m == -5.0
    run(obstacles, 1.0, from_s=3.0)
    assert obstacles.bodies[0].y_m == pytest.approx(-3.0)


def test_waits_for_the_car_and_then_goes_on_whatever_the_car_does():
    obstacles = Obstacles([WALKER.__class__(**{**WALKER.__dict__, "trigger_m": 20.0})])
    run(obstacles, 1.0, car=FAR._replace(x_m=20.5, y_m=-5.0))
    assert obstacles.bodies[0].y_m == -5.0
    run(obstacles, 0.5, car=FAR._replace(x_m=19.5, y_m=-5.0))
    run(obstacles, 0.5)
    assert obstacles.bodies[0].y_m == pytest.approx(-3.0)


def test_stops_at_the_car_with_one_touch_and_goes_on_when_it_has_left():
    obstacles = Obstacles([WALKER])
    car = Rectangle(0.0, 0.0, 0.0, 4.7, 2.0)
    touches = run(obstacles, 10.0, car)
    body = obstacles.bodies[0]
    assert [touch.id for touch in touches] == [FIRST_ID]
    assert touches[0].impulse_y_ns == pytest.approx(75.0 * 2.0)
    assert touches[0].impulse_x_ns == pytest.approx(0.0, abs=1e-9)
    assert body.y_m == pytest.approx(-1.25, abs=1e-6)
    assert body.speed_mps == 0.0
    assert overlap(body.rectangle, car) is None
    run(obstacles, 1.0)
    assert obstacles.bodies[0].y_m == pytest.approx(0.75)


def test_reset_brings_everything_back():
    obstacles = Obstacles([WALKER])
    run(obstacles, 2.0)
    obstacles.toggle(ObstaclePlan.standing("obstacle", 50.0, 0.0, 0.0), FAR)
    obstacles.toggle(ObstaclePlan.standing("obstacle", 0.0, -1.0, 0.0), FAR)
    assert [body.x_m for body in obstacles.bodies] == [50.0]
    obstacles.reset()
    assert [(body.id, body.y_m) for body in obstacles.bodies] == [(FIRST_ID, -5.0)]


def test_click_puts_one_and_takes_it_away():
    obstacles = Obstacles()
    assert "put" in obstacles.toggle(ObstaclePlan.standing("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.bodies[0].kind == "car"
    assert "removed" in obstacles.toggle(ObstaclePlan.standing("car", 11.0, 0.5, 0.0), FAR)
    assert obstacles.bodies == ()
    obstacles.toggle(ObstaclePlan.standing("car", 10.0, 0.0, 0.5), FAR)
    assert obstacles.bodies[0].id == FIRST_ID + 1, "a number is never used twice"


def test_click_on_the_car_is_refused():
    obstacles = Obstacles()
    with pytest.raises(ValueError, match="the car stands"):
        obstacles.toggle(
            ObstaclePlan.standing("obstacle", 2.0, 0.0, 0.0), Rectangle(0.0, 0.0, 0.0, 4.7, 2.0)
        )
    assert obstacles.bodies == ()
