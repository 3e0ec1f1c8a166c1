"""Test the car's motion: move, turn and bounce."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from world.car import Car, Field, fold, wrap_angle

PI = math.pi
FIELD = Field(100.0, 60.0)  # with a car of size 10 its centre moves within x +-45, y +-25
angles = st.floats(-1e4, 1e4)
distances = st.floats(0.0, 1e5)
xs, ys = st.floats(-45.0, 45.0), st.floats(-25.0, 25.0)


@pytest.mark.parametrize(
    "angle, wrapped",
    [
        (0.0, 0.0),
        (PI, PI),
        (-PI, PI),
        (3 * PI, PI),
        (-3 * PI, PI),
        (2 * PI, 0.0),
        (PI + 0.1, 0.1 - PI),
        (-PI - 0.1, PI - 0.1),
        (-1e-17, 0.0),
    ],
)
def test_wrap_angle_at_and_beyond_pi(angle, wrapped):
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-12)


@given(angles)
@example(math.nextafter(PI, 4.0) if hasattr(math, "nextafter") else PI * (1 + 2**-52))
@example(-PI)
def test_wrap_angle_stays_in_range_and_keeps_the_direction(angle):
    wrapped = wrap_angle(angle)
    assert -PI < wrapped <= PI
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize(
    "position, folded",
    [
        (0.0, (0.0, False)),
        (45.0, (45.0, False)),
        (-45.0, (-45.0, False)),
        (46.0, (44.0, True)),
        (-47.0, (-43.0, True)),
        (45.0 + 90.0, (-45.0, True)),
        (45.0 + 91.0, (-44.0, False)),
        (-45.0 - 91.0, (44.0, False)),
        (180.0, (0.0, False)),
        (90.0, (0.0, True)),
        (-225.0, (-45.0, False)),
    ],
)
def test_fold_reflects_positions_beyond_the_mirrors(position, folded):
    place, is_back = fold(position, 45.0)
    assert place == pytest.approx(folded[0])
    # After an exact crossing from mirror to mirror, both directions lead to the same next step.
    assert is_back == folded[1] or abs(place) == pytest.approx(45.0)


@given(st.floats(-1e6, 1e6), st.floats(0.1, 1e3))
def test_fold_equals_one_reflection_after_the_other(position, limit):
    place, is_back = position, False
    bounces = 0
    while abs(place) > limit and bounces < 200:
        place, is_back, bounces = math.copysign(2 * limit, place) - place, not is_back, bounces + 1
    if bounces < 200:
        folded, folded_back = fold(position, limit)
        assert folded == pytest.approx(place, abs=1e-6)
        assert folded_back == is_back or abs(abs(place) - limit) < 1e-6


def test_car_far_from_walls_moves_straight():
    car = FIELD.advance(Car(0.0, 0.0, PI / 6), 10.0, 10.0)
    assert car == pytest.approx((10.0 * math.cos(PI / 6), 5.0, PI / 6))


@pytest.mark.parametrize(
    "start, distance, end",
    [
        (Car(40.0, 0.0, 0.0), 10.0, Car(40.0, 0.0, PI)),  # right wall and back
        (Car(-40.0, 0.0, PI), 10.0, Car(-40.0, 0.0, 0.0)),  # left wall
        (Car(0.0, 20.0, PI / 2), 8.0, Car(0.0, 22.0, -PI / 2)),  # upper wall
        (Car(0.0, -20.0, -PI / 2), 8.0, Car(0.0, -22.0, PI / 2)),  # lower wall
        (Car(40.0, 0.0, PI / 4), 10.0 * math.sqrt(2), Car(40.0, 10.0, 3 * PI / 4)),
        (Car(45.0, 0.0, 0.0), 0.0, Car(45.0, 0.0, 0.0)),  # the car touches the wall: no bounce
        (
            Car(40.0, 0.0, 0.0),
            5.0,
            Car(45.0, 0.0, 0.0),
        ),  # the car arrives exactly at the wall: no bounce
        (Car(45.0, 0.0, 0.0), 3.0, Car(42.0, 0.0, PI)),  # the next step bounces
        (Car(0.0, 0.0, 0.0), 180.0, Car(0.0, 0.0, 0.0)),  # both walls in one step
        (Car(0.0, 0.0, 0.0), 270.0, Car(0.0, 0.0, PI)),  # three walls
    ],
)
def test_car_bounces_off_walls(start, distance, end):
    car = FIELD.advance(start, distance, 10.0)
    assert car[:2] == pytest.approx(end[:2])
    assert math.cos(car.direction - end.direction) == pytest.approx(1.0)


@pytest.mark.parametrize("sign_x, sign_y", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_car_that_hits_a_corner_returns_the_same_way(sign_x, sign_y):
    direction = math.atan2(sign_y, sign_x)
    start = Car(sign_x * 40.0, sign_y * 20.0, direction)
    into = FIELD.advance(start, 5.0 * math.sqrt(2), 10.0)  # exactly to the corner
    assert into == pytest.approx((sign_x * 45.0, sign_y * 25.0, direction))
    for car in (
        FIELD.advance(into, 5.0 * math.sqrt(2), 10.0),
        FIELD.advance(start, 10.0 * math.sqrt(2), 10.0),
    ):
        assert car[:2] == pytest.approx(start[:2])
        assert math.cos(car.direction - direction) == pytest.approx(-1.0)


def test_car_that_hits_near_a_corner_bounces_off_both_walls():
    car = FIELD.advance(Car(40.0, 19.0, PI / 4), 10.0 * math.sqrt(2), 10.0)
    assert car[:2] == pytest.approx((40.0, 21.0))
    assert math.cos(car.direction + 3 * PI / 4) == pytest.approx(1.0)


@given(xs, ys, angles, distances)
@example(45.0, 25.0, PI / 4, 1e5)
def test_bounce_keeps_the_car_inside_and_its_angle_to_the_walls(x, y, direction, distance):
    car = FIELD.advance(Car(x, y, direction), distance, 10.0)
    assert abs(car.x) <= 45.0 and abs(car.y) <= 25.0
    assert abs(math.cos(car.direction)) == pytest.approx(abs(math.cos(direction)), abs=1e-9)
    assert abs(math.sin(car.direction)) == pytest.approx(abs(math.sin(direction)), abs=1e-9)
    assert -PI < car.direction <= PI


@given(xs, ys, st.floats(-PI, PI), st.floats(0.0, 500.0), st.floats(0.0, 500.0))
def test_two_steps_equal_one_long_step(x, y, direction, first, second):
    twice = FIELD.advance(FIELD.advance(Car(x, y, direction), first, 10.0), second, 10.0)
    once = FIELD.advance(Car(x, y, direction), first + second, 10.0)
    assert twice[:2] == pytest.approx(once[:2], abs=1e-6)


@given(xs, ys, st.floats(-PI, PI), st.floats(0.0, 500.0))
def test_car_that_reverses_returns_to_its_start(x, y, direction, distance):
    there = FIELD.advance(Car(x, y, direction), distance, 10.0)
    back = FIELD.advance(there.turned(PI), distance, 10.0)
    assert back[:2] == pytest.approx((x, y), abs=1e-6)


@given(angles, angles, angles)
def test_clamp_moves_the_car_inside_and_keeps_one_that_is_inside(x, y, direction):
    car = FIELD.clamp(Car(x, y, direction), 10.0)
    assert abs(car.x) <= 45.0 and abs(car.y) <= 25.0
    assert FIELD.clamp(car, 10.0) == car


def test_field_contains_points_on_its_walls():
    assert (
        FIELD.contains(50.0, -30.0)
        and not FIELD.contains(50.1, 0.0)
        and not FIELD.contains(0.0, -30.1)
    )
