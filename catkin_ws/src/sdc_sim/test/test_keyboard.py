"""Tests of the keyboard control."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.manual_control.keyboard import HELP, KeyboardControl, KeyboardControlRates
from sdc_sim.physics.vehicle import VehicleCommand

RATES = KeyboardControlRates(
    throttle_per_s=2.0, brake_per_s=4.0, steer_per_s=0.5, steer_return_per_s=2.0, steer_limit=0.7
)
KEYS = ("w", "up", "s", "down", "a", "left", "d", "right", "space", "q", "x")
steps = st.lists(st.tuples(st.sets(st.sampled_from(KEYS)), st.floats(0.0, 3.0)), max_size=20)


def held_for(seconds, *keys, control=None):
    control = control or KeyboardControl(RATES)
    for _ in range(round(seconds / 0.05)):
        control.step(keys, 0.05)
    return control.command


@pytest.mark.parametrize(
    "keys, expected",
    [
        ((), VehicleCommand()),
        (("w",), VehicleCommand(throttle=0.4)),
        (("up",), VehicleCommand(throttle=0.4)),
        (("s",), VehicleCommand(brake=0.8)),
        (("down",), VehicleCommand(brake=0.8)),
        (("a",), VehicleCommand(steer=-0.1)),
        (("left",), VehicleCommand(steer=-0.1)),
        (("d",), VehicleCommand(steer=0.1)),
        (("right",), VehicleCommand(steer=0.1)),
        (("a", "right"), VehicleCommand()),
        (("space",), VehicleCommand(hand_brake=True)),
        (("w", "d", "space"), VehicleCommand(throttle=0.4, steer=0.1, hand_brake=True)),
        (("x", "q", "escape"), VehicleCommand()),
    ],
)
def test_held_keys_change_the_command_at_their_rates(keys, expected):
    command = held_for(0.2, *keys)
    assert (command.throttle, command.steer, command.brake) == pytest.approx(
        (expected.throttle, expected.steer, expected.brake)
    )
    assert (command.hand_brake, command.reverse) == (expected.hand_brake, expected.reverse)


def test_steering_grows_to_its_limit_and_returns_faster():
    control = KeyboardControl(RATES)
    assert held_for(3.0, "d", control=control).steer == 0.7
    assert held_for(0.2, control=control).steer == pytest.approx(0.3)
    assert held_for(0.2, control=control).steer == 0.0


def test_opposite_key_steers_across_zero_within_one_step():
    control = KeyboardControl(RATES)
    held_for(1.0, "d", control=control)  # steer is 0.5
    assert control.step(["a"], 0.45).steer == pytest.approx(-0.1)  # 0.25 s to zero, then 0.2 s


def test_pedals_are_zero_when_their_keys_are_released():
    control = KeyboardControl(RATES)
    held_for(1.0, "w", "s", control=control)
    assert (control.command.throttle, control.command.brake) == (1.0, 1.0)
    assert control.step([], 0.0) == VehicleCommand()


def test_reverse_stays_until_toggled():
    control = KeyboardControl(RATES)
    control.toggle_reverse()
    assert control.command.reverse
    assert control.step(["w"], 1.0) == VehicleCommand(throttle=1.0, reverse=True)
    control.toggle_reverse()
    assert not control.step(["w"], 1.0).reverse


def test_reset_clears_the_command():
    control = KeyboardControl(RATES)
    control.toggle_reverse()
    control.step(["w", "d", "space"], 1.0)
    control.reset()
    assert control.command == control.step([], 0.0) == VehicleCommand()


@given(steps)
def test_command_is_always_in_range(history):
    control = KeyboardControl(RATES)
    for keys, step_s in history:
        command = control.step(keys, step_s)
        assert command.clamped() == (command, False)
        assert abs(command.steer) <= RATES.steer_limit


@given(steps)
def test_steering_returns_to_zero_without_keys(history):
    control = KeyboardControl(RATES)
    for keys, step_s in history:
        control.step(keys, step_s)
    last = abs(control.command.steer)
    for _ in range(8):
        steer = control.step((), 0.05).steer
        assert abs(steer) <= last
        last = abs(steer)
    assert control.step((), 0.0) == VehicleCommand()


@given(steps)
def test_left_and_right_are_symmetric(history):
    swap = {"a": "d", "d": "a", "left": "right", "right": "left"}
    control, mirrored = KeyboardControl(RATES), KeyboardControl(RATES)
    for keys, step_s in history:
        command = control.step(keys, step_s)
        assert mirrored.step({swap.get(key, key) for key in keys}, step_s).steer == -command.steer


@given(steps, st.sets(st.sampled_from(KEYS)), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_one_long_step_equals_two_short_ones(history, keys, first_s, second_s):
    one, two = KeyboardControl(RATES), KeyboardControl(RATES)
    for control in (one, two):
        for earlier, step_s in history:
            control.step(earlier, step_s)
    one.step(keys, first_s + second_s)
    two.step(keys, first_s)
    two.step(keys, second_s)
    assert one.command.steer == pytest.approx(two.command.steer, abs=1e-9)
    assert one.command.throttle == pytest.approx(two.command.throttle, abs=1e-9)


@pytest.mark.parametrize("step_s", [-0.1, math.nan, math.inf])
def test_invalid_time_step_is_refused(step_s):
    with pytest.raises(ValueError, match="time step"):
        KeyboardControl(RATES).step([], step_s)


@pytest.mark.parametrize(
    "name, value",
    [
        ("throttle_per_s", 0.0),
        ("brake_per_s", math.nan),
        ("steer_per_s", -1.0),
        ("steer_return_per_s", math.inf),
        ("steer_limit", 0.0),
        ("steer_limit", 1.1),
    ],
)
def test_invalid_rate_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        KeyboardControlRates(**{**vars(RATES), name: value})


def test_help_lists_every_key():
    named = " ".join(keys for keys, _ in HELP).lower()
    for key in (
        "w",
        "a",
        "s",
        "d",
        "up",
        "down",
        "left",
        "right",
        "q",
        "space",
        "p",
        "tab",
        "backspace",
        "f1",
        "h",
        "esc",
    ):
        assert key in named.replace(",", "").split()
