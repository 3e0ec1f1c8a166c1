"""Who drives: every change between the stack, a viewer and the brakes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_cockpit.driving import BRAKING, PERSON, STACK, RemoteDriving
from sdc_sim.manual_control.keyboard import KeyboardControlRates

RATES = KeyboardControlRates(2.0, 4.0, 0.5, 2.0, 0.7)
FORWARD, NOTHING = {"held": {"w"}}, {"held": set()}
TIMEOUT_S, LIMIT_S = 0.3, 5.0


def pedals(throttle, steer, brake):
    return {"throttle": throttle, "steer": steer, "brake": brake}


@pytest.fixture
def driving():
    return RemoteDriving(RATES, TIMEOUT_S, LIMIT_S)


def drive(driving, controls, seconds, start_s=0.0, speed_mps=5.0):
    """Send controls and take steps, 20 a second; return the last command."""
    command = None
    for step in range(round(20 * seconds)):
        driving.control(1, controls, start_s + 0.05 * step)
        command = driving.step(start_s + 0.05 * step, speed_mps)
    return command


def test_held_key_moves_the_pedal(driving):
    driving.take(1, 0.0)
    assert drive(driving, FORWARD, 1.0).throttle == pytest.approx(1.0)
    assert drive(driving, NOTHING, 0.1, 1.0).throttle == 0.0
    assert driving.mode == PERSON


def test_pedals_apply_at_once(driving):
    driving.take(1, 0.0)
    command = drive(driving, pedals(0.4, -0.2, 0.1), 0.1)
    assert (command.throttle, command.steer, command.brake) == (0.4, -0.2, 0.1)


def test_reverse_stays_with_keys_and_pedals(driving):
    driving.take(1, 0.0)
    driving.toggle_reverse(1)
    assert drive(driving, FORWARD, 0.1).reverse
    assert drive(driving, pedals(0.4, 0.0, 0.0), 0.1, 0.1).reverse


def test_car_brakes_with_its_steer_when_controls_stop(driving):
    driving.take(1, 0.0)
    steer = drive(driving, pedals(1.0, 0.3, 0.0), 1.0).steer
    assert driving.step(0.95 + TIMEOUT_S - 0.01, 8.0).throttle == 1.0
    command = driving.step(0.95 + TIMEOUT_S + 0.01, 8.0)
    assert (command.throttle, command.brake, command.steer) == (0.0, 1.0, steer)
    assert driving.mode == BRAKING and driving.overrides


def test_lost_connection_brakes_at_once(driving):
    driving.take(1, 0.0)
    drive(driving, FORWARD, 0.2)
    driving.vanish(1, 0.2)
    assert driving.step(0.2, 8.0).brake == 1.0


@pytest.mark.parametrize(("now_s", "speed_mps"), [(0.5, 0.0), (0.3 + LIMIT_S, 8.0)])
def test_braking_ends_at_standstill_or_after_a_limit(driving, now_s, speed_mps):
    driving.take(1, 0.0)
    driving.vanish(1, 0.2)
    assert driving.step(now_s, speed_mps) is None
    assert driving.mode == STACK and driving.viewer is None


def test_other_viewer_cannot_take_brake_or_steer(driving):
    driving.take(1, 0.0)
    with pytest.raises(ValueError, match="viewer 1 drives"):
        driving.take(2, 0.1)
    driving.control(2, FORWARD, 0.1)
    driving.toggle_reverse(2)
    driving.release(2)
    driving.vanish(2, 0.1)
    assert driving.mode == PERSON
    command = driving.step(0.1, 0.0)
    assert command.throttle == 0.0 and not command.reverse


def test_braking_car_can_be_taken_over(driving):
    driving.take(1, 0.0)
    driving.vanish(1, 0.1)
    driving.take(2, 0.2)
    assert driving.step(0.2, 8.0).brake == 0.0
    assert driving.viewer == 2


NAMES = st.sampled_from(["take", "release", "vanish", "control", "wait"])
STEPS = st.lists(st.tuples(NAMES, st.sampled_from([1, 2]), st.floats(0.0, 1.0)))


@given(STEPS)
def test_throttle_needs_recent_controls(steps):
    driving, now_s, last_s = RemoteDriving(RATES, TIMEOUT_S, LIMIT_S), 0.0, -1.0
    for name, viewer, wait_s in steps:
        now_s += wait_s
        if name == "take":
            if driving.mode == PERSON and driving.viewer != viewer:
                continue
            driving.take(viewer, now_s)
            last_s = now_s
        elif name == "control":
            driving.control(viewer, FORWARD, now_s)
            last_s = now_s if driving.viewer == viewer else last_s
        elif name != "wait":
            getattr(driving, name)(*((viewer,) if name == "release" else (viewer, now_s)))
        command = driving.step(now_s, 5.0)
        assert (command is None) == (not driving.overrides)
        if command is not None and command.throttle > 0.0:
            assert now_s - last_s <= TIMEOUT_S
