import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_package.actuation import PedalMap, SteeringMap

STEERING = SteeringMap(0.8, [0.0, 10.0], [1.0, 0.5])
PEDALS = PedalMap(
    throttle_deadband=0.3, throttle_gain_mps2=7.0, brake_gain_mps2=7.3, coast_mps2=0.2
)


def test_positive_steer_is_right_and_grows_with_the_speed():
    assert STEERING.command(0.4, 0.0) == (-0.5, False)
    assert STEERING.command(-0.4, 0.0) == (0.5, False)
    assert STEERING.command(-0.4, 5.0)[0] == pytest.approx(0.4 / 0.6)
    assert STEERING.command(-0.4, 100.0) == (1.0, False)
    assert STEERING.command(-0.41, 100.0) == (1.0, True)
    assert STEERING.command(0.41, 100.0) == (-1.0, True)


@given(st.floats(-50.0, 50.0))
def test_share_of_the_wheel_angle_is_linear_between_the_speeds(speed):
    share = np.interp(abs(speed), STEERING.speeds_mps, STEERING.shares)
    assert STEERING.command(0.1, speed)[0] == pytest.approx(-0.1 / (0.8 * share), rel=1e-12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"max_wheel_angle_rad": 0.0}, "max_wheel_angle_rad"),
        ({"max_wheel_angle_rad": 2.0}, "max_wheel_angle_rad"),
        ({"shares": ["full"]}, r"^steering: 'shares' must be a list of numbers, got \['full'\]$"),
        ({"speeds_mps": 5.0}, r"'speeds_mps' must be a list of numbers, got 5\.0$"),
        (
            {"shares": [1.0]},
            "^steering: 'speeds_mps' and 'shares' must have the same length.* got 2 and 1$",
        ),
        ({"speeds_mps": [], "shares": []}, ".* at least 1; got 0 and 0$"),
        ({"shares": [1.0, 0.0]}, r"'shares' must be positive, got \[1\.0, 0\.0\]$"),
        ({"speeds_mps": [5.0, 5.0]}, r"'speeds_mps' must rise, got \[5\.0, 5\.0\]$"),
    ],
)
def test_invalid_steering_maps_are_refused(wrong, message):
    values = {"max_wheel_angle_rad": 0.8, "speeds_mps": [0.0, 10.0], "shares": [1.0, 0.5]}
    with pytest.raises(ValueError, match=message):
        SteeringMap(**{**values, **wrong})


def test_pedals_have_their_values():
    assert PEDALS.pedals(1.2) == (pytest.approx(0.3 + 1.4 / 7.0), 0.0)
    assert PEDALS.pedals(-0.2) == (0.0, 0.0)
    assert PEDALS.pedals(-3.85) == (0.0, pytest.approx(0.5))
    assert PEDALS.pedals(100.0) == (1.0, 0.0)
    assert PEDALS.pedals(-100.0) == (0.0, 1.0)
    # Between coasting and constant speed: half of the deadband.
    assert PEDALS.pedals(-0.1) == (pytest.approx(0.5 * 0.3 + 0.1 / 7.0), 0.0)


@given(st.floats(-20.0, 20.0), st.floats(0.0, 0.01))
def test_pedals_are_monotonic_and_continuous_and_only_one_is_pressed(acceleration, more):
    throttle, brake = PEDALS.pedals(acceleration)
    assert 0.0 <= throttle <= 1.0
    assert 0.0 <= brake <= 1.0
    assert throttle * brake == 0.0
    next_throttle, next_brake = PEDALS.pedals(acceleration + more)
    assert next_throttle - next_brake >= throttle - brake
    assert next_throttle - next_brake - (throttle - brake) < 0.02


@pytest.mark.parametrize(
    "wrong",
    [
        {"throttle_deadband": 1.0},
        {"throttle_gain_mps2": 0.0},
        {"brake_gain_mps2": math.nan},
        {"coast_mps2": -0.1},
    ],
)
def test_invalid_pedal_maps_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PedalMap(**{**vars(PEDALS), **wrong})
