"""Speed control with the shipped parameters: its limits, its stops and its starts."""

import dataclasses

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits

PARAMETERS = node_config("sdc_package", "simple_controller")
LIMITS, GAINS = SpeedControlLimits(**PARAMETERS["limits"]), PidGains(**PARAMETERS["pid"])
TICK_S = 0.05
# Greatest change of the acceleration in a tick, and in one of an emergency [m/s^2].
CHANGE_MPS2 = LIMITS.jerk_mps3 * TICK_S
EMERGENCY_MPS2 = LIMITS.emergency_jerk_mps3 * TICK_S


def control():
    return SpeedControl(GAINS, LIMITS)


def test_acceleration_and_jerk_stay_within_the_limits():
    speed = control()
    last = 0.0
    for target in [20.0] * 40 + [7.0] * 40 + [20.0] * 40:
        now = speed.acceleration(target, 0.0, 8.0, TICK_S)
        assert -LIMITS.braking_mps2 <= now <= LIMITS.acceleration_mps2
        assert abs(now - last) <= CHANGE_MPS2 + 1e-9
        last = now


@pytest.mark.parametrize(
    ("target_mps", "planned_mps2", "first_mps2"),
    [
        (0.0, 0.0, -EMERGENCY_MPS2),
        (8.0, -3.5, -EMERGENCY_MPS2),
        (7.5, 0.0, -CHANGE_MPS2),
    ],
)
def test_car_that_has_just_seen_something_brakes_at_once(target_mps, planned_mps2, first_mps2):
    speed = control()
    first = speed.acceleration(target_mps, planned_mps2, 8.0, TICK_S)
    assert first == pytest.approx(first_mps2)
    assert speed.acceleration(20.0, 0.0, 8.0, TICK_S) == pytest.approx(first_mps2 + CHANGE_MPS2)


@pytest.mark.parametrize(("target_mps", "hardest_mps2"), [(5.5, -3.9), (4.0, -5.0)])
def test_car_brakes_harder_than_is_comfortable_only_if_it_is_late(target_mps, hardest_mps2):
    limits = dataclasses.replace(LIMITS, braking_mps2=5.0)
    speed = SpeedControl(GAINS, limits)
    now = [speed.acceleration(target_mps, -2.0, 8.0, TICK_S) for _ in range(100)]
    assert min(now) == pytest.approx(hardest_mps2)


@pytest.mark.parametrize(("faster_mps", "is_late"), [(3.0, False), (4.0, True)])
def test_car_that_has_pushed_brakes_comfortably_unless_it_is_late(faster_mps, is_late):
    speed, v, now = control(), 25.0, []
    for tick in range(120):
        target_mps, planned_mps2 = (v + 5.0, 0.0) if tick < 50 else (v - faster_mps, -5.0)
        now.append(speed.acceleration(target_mps, planned_mps2, v, TICK_S))
        v += TICK_S * now[-1]
    time_s = TICK_S * np.arange(31)  # 1.5 s
    jerk_mps3 = min(np.polyfit(time_s, now[n : n + 31], 1)[0] for n in range(90))
    assert (jerk_mps3 < -4.13) == is_late and now[-1] < -3.5


def test_slow_car_that_has_pushed_brakes_at_once_for_an_emergency():
    speed = control()
    for _ in range(20):
        speed.acceleration(3.0, 0.0, 1.5, TICK_S)
    now = [speed.acceleration(0.0, 0.0, 1.5, TICK_S) for _ in range(8)]
    assert now[-1] == pytest.approx(-3.9)


def test_speed_settles_with_little_overshoot():
    speed, v, top = control(), 0.0, 0.0
    for _ in range(600):
        v += TICK_S * speed.acceleration(5.0, 0.0, v, TICK_S)
        top = max(top, v)
    assert v == pytest.approx(5.0, abs=0.02)
    assert top < 5.6


def test_brake_holds_a_waiting_car_and_the_start_is_smooth():
    speed = control()
    assert {speed.acceleration(0.0, 0.0, v, TICK_S) for v in (0.1, 0.0, 0.05, 0.0)} == {-2.0}
    assert speed.acceleration(1.0, 1.8, 0.0, TICK_S) == pytest.approx(CHANGE_MPS2)


def test_car_that_has_just_braked_to_a_stop_stays_for_a_moment():
    speed = control()
    for v in (2.0, 1.0, 0.5, 0.1):
        speed.acceleration(0.0, 0.0, v, TICK_S)
    results = [speed.acceleration(5.0, 1.0, 0.0, TICK_S) for _ in range(30)]
    assert set(results[:10]) == {-2.0} and min(results[12:]) > 0.0


def test_car_that_stands_just_before_its_stop_does_not_start_again():
    control_ = control()
    # 0.1 m before a stop, the planned speed is still 0.3 m/s.
    assert max(control_.acceleration(0.3, -0.45, 0.0, TICK_S) for _ in range(200)) < 0.0
    assert max(control_.acceleration(1.0, -0.45, 0.0, TICK_S) for _ in range(200)) > 0.5


def test_car_that_has_waited_before_a_line_starts_no_faster_than_planned():
    control_, v, top = control(), 0.0, 0.0
    # 0.5 m before a line, between points of the path with 6 m/s and 0.
    assert {control_.acceleration(5.8, -35.0, 0.0, TICK_S) for _ in range(200)} == {-2.0}
    for _ in range(300):
        v += TICK_S * control_.acceleration(8.0, 0.0, v, TICK_S)
        top = max(top, v)
    assert 7.9 < top < 8.8


def test_car_at_rest_starts_where_the_path_behind_it_was_planned_faster():
    control_ = control()
    # From 6.6 m/s at the car to 1.5 m/s after 1 m, which is no stop.
    assert min(control_.acceleration(6.6, -20.7, 0.0, TICK_S) for _ in range(20)) > 0.0


@pytest.mark.parametrize(
    ("speed_mps", "planned_mps2", "expected_mps2"), [(0.6, 0.0, -0.78), (1.3, -2.5, -3.9)]
)
def test_car_that_was_pushed_brakes_at_a_stop(speed_mps, planned_mps2, expected_mps2):
    control_ = control()
    for _ in range(200):  # uphill: the integral grows
        control_.acceleration(speed_mps + 0.3, 0.0, speed_mps, TICK_S)
    for _ in range(20):
        control_.acceleration(speed_mps, planned_mps2, speed_mps, TICK_S)
    results = [control_.acceleration(0.0, 0.0, speed_mps, TICK_S) for _ in range(20)]
    assert results[-1] == pytest.approx(expected_mps2, abs=0.3)
