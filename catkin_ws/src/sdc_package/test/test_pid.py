"""PID controller: its terms, its limits, and its integral while the output is limited."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_package.pid import Pid, PidGains

finite = st.floats(-1e3, 1e3)


def test_each_term_has_its_value():
    pid = Pid(PidGains(kp=2.0, ki=0.5, kd=0.25), -100.0, 100.0)
    assert pid.update(3.0, 1.0, 0.5) == (2.0 * 2.0 + 0.5 * 2.0 * 0.5, False)
    output, _ = pid.update(3.0, 2.0, 0.5)
    assert output == pytest.approx(2.0 * 1.0 + (0.5 + 0.25) + 0.25 * -2.0)


def test_derivative_ignores_a_step_of_the_setpoint():
    pid = Pid(PidGains(kp=0.0, kd=1.0), -10.0, 10.0)
    pid.update(0.0, 1.0, 0.1)
    assert pid.update(100.0, 1.0, 0.1) == (0.0, False)


def test_integral_does_not_grow_while_the_output_is_limited():
    pid = Pid(PidGains(kp=1.0, ki=1.0), -1.0, 1.0)
    for _ in range(1000):
        assert pid.update(10.0, 0.0, 0.1) == (1.0, True)
    assert pid.integral == 0.0
    output, saturated = pid.update(0.5, 1.0, 0.1)
    assert output < 0.0
    assert not saturated


def test_integral_may_shrink_while_the_output_is_limited():
    pid = Pid(PidGains(kp=0.1, ki=1.0), -1.0, 1.0)
    pid.update(0.9, 0.0, 1.0)
    charged = pid.integral
    pid.update(-0.1, 0.0, 0.5, feed_forward=5.0)
    assert pid.integral < charged


def test_reset_restores_the_initial_state():
    pid, new = (Pid(PidGains(1.0, 1.0, 1.0), -10.0, 10.0) for _ in range(2))
    pid.update(1.0, 0.0, 0.1)
    pid.update(1.0, 0.5, 0.1)
    pid.reset()
    assert pid.update(2.0, 1.0, 0.1) == new.update(2.0, 1.0, 0.1)


def test_step_of_zero_seconds_neither_integrates_nor_differentiates():
    pid = Pid(PidGains(1.0, 1.0, 1.0), -10.0, 10.0)
    pid.update(1.0, 0.0, 0.0)
    assert pid.update(1.0, 0.5, 0.0) == (0.5, False)


@pytest.mark.parametrize("dt", [-0.1, math.nan, math.inf])
def test_invalid_time_step_is_refused(dt):
    with pytest.raises(ValueError, match="time step"):
        Pid(PidGains(1.0), -1.0, 1.0).update(0.0, 0.0, dt)


def test_invalid_limits_and_gains_are_refused():
    with pytest.raises(ValueError, match="below"):
        Pid(PidGains(1.0), 1.0, 1.0)
    with pytest.raises(ValueError, match="finite"):
        Pid(PidGains(math.nan), -1.0, 1.0)


STEPS = st.lists(st.tuples(finite, finite, st.floats(0.0, 1.0)), min_size=1, max_size=30)


@given(finite, finite, st.just(0.0) | finite, STEPS)
def test_output_is_at_a_limit_where_it_is_limited_and_the_sum_of_the_terms_elsewhere(
    kp, ki, kd, steps
):
    pid = Pid(PidGains(kp, ki, kd), -0.5, 2.0)
    for setpoint, measurement, dt in steps:
        output, saturated = pid.update(setpoint, measurement, dt)
        assert -0.5 <= output <= 2.0 and math.isfinite(pid.integral)
        assert output in (-0.5, 2.0) or not saturated
        if not saturated and not kd:
            assert output == pytest.approx(kp * (setpoint - measurement) + pid.integral)
