"""Test the car's motion: move, turn and bounce."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from world.car import Car, Field

PI = math.pi
FIELD = Field(100.0, 60.0, car_size=10.0)  # the car's centre moves within x +-45, y +-25
angles = st.floats(-1e4, 1e4)
distances = st.floats(0.0, 1e5)
xs, ys = st.floats(-45.0, 45.0), st.floats(-25.0, 25.0)


@given(angles, st.floats(-PI, PI))
def test_turned_car_has_the_sum_of_the_angles_within_half_a_turn(angle, direction):
    turned = Car(1.0, 2.0, direction).turned(angle)
    assert (turned.x, turned.y) == (1.0, 2.0)
    assert -PI <= turned.direction <= PI
    assert math.cos(turned.direction - direction - angle) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "start, distance, end",
    [
        (Car(0.0, 0.0, PI / 6), 10.0, Car(10.0 * math.cos(PI / 6), 5.0, PI / 6)),  # no wall
        (Car(40.0, 0.0, 0.0), 10.0, Car(40.0, 0.0, PI)),  # right wall and back
        (Car(-40.0, 0.0, PI), 10.0, Car(-40.0, 0.0, 0.0)),  # left wall
        (Car(0.0, 20.0, PI / 2), 8.0, Car(0.0, 22.0, -PI / 2)),  # upper wall
        (Car(0.0, -20.0, -PI / 2), 8.0, Car(0.0, -22.0, PI / 2)),  # lower wall
        (Car(40.0, 0.0, PI / 4), 10.0 * math.sqrt(2), Car(40.0, 10.0, 3 * PI / 4)),
        (Car(45.0, 0.0, 0.0), 0.0, Car(45.0, 0.0, 0.0)),  # the car touches the wall: no bounce
        (Car(40.0, 0.0, 0.0), 5.0, Car(45.0, 0.0, 0.0)),  # it arrives exactly at it: no bounce
        (Car(45.0, 0.0, 0.0), 3.0, Car(42.0, 0.0, PI)),  # the next step bounces
        (Car(0.0, 0.0, 0.0), 180.0, Car(0.0, 0.0, 0.0)),  # both walls in one step
        (Car(0.0, 0.0, 0.0), 270.0, Car(0.0, 0.0, PI)),  # three walls
        (Car(40.0, 19.0, PI / 4), 10.0 * math.sqrt(2), Car(40.0, 21.0, -3 * PI / 4)),  # two walls
    ],
)
def test_car_bounces_off_walls(start, distance, end):
    car = FIELD.advance(start, distance)
    assert car[:2] == pytest.approx(end[:2])
    assert math.cos(car.direction - end.direction) == pytest.approx(1.0)


@given(xs, ys, angles, distances)
@example(45.0, 25.0, PI / 4, 1e5)
def test_bounce_keeps_the_car_inside_and_its_angle_to_the_walls(x, y, direction, distance):
    car = FIELD.advance(Car(x, y, direction), distance)
    assert abs(car.x) <= 45.0 and abs(car.y) <= 25.0
    assert abs(math.cos(car.direction)) == pytest.approx(abs(math.cos(direction)), abs=1e-9)
    assert abs(math.sin(car.direction)) == pytest.approx(abs(math.sin(direction)), abs=1e-9)
    assert -PI <= car.direction <= PI


def test_field_contains_points_on_its_walls():
    assert FIELD.contains(50.0, -30.0)
    assert not FIELD.contains(50.1, 0.0) and not FIELD.contains(0.0, -30.1)
