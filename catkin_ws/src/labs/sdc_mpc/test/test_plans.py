"""The model agrees with its derivatives, plans obey model and limits, and the drives arrive."""

import importlib.util

import numpy as np
import pytest

from sdc_mpc.limits import limits
from sdc_mpc.model import WHEELBASE_M, discretized, linearized, rates
from sdc_mpc.program import changes, cost, dynamics

needs_osqp = pytest.mark.skipif(
    importlib.util.find_spec("osqp") is None, reason="osqp is not installed (docker/prepare mpc)"
)


@pytest.mark.parametrize("curvature", [0.0, 0.05, -0.1])
def test_derivatives_are_those_of_the_rates(curvature):
    wheel, at, h = np.arctan(WHEELBASE_M * curvature), np.array([0.0, 0.0, 12.0]), 1e-6
    a, b = linearized(12.0, curvature)
    for i, d in enumerate(h * np.eye(3)):
        slope = rates(at + d, wheel, 0.0, curvature) - rates(at - d, wheel, 0.0, curvature)
        assert a[:, i] == pytest.approx(slope / (2 * h), abs=1e-6)
    slope = rates(at, wheel + h, 0.0, curvature) - rates(at, wheel - h, 0.0, curvature)
    assert b[:, 0] == pytest.approx(slope / (2 * h), abs=1e-6)
    assert b[:, 1].tolist() == [0.0, 0.0, 1.0]


def test_tick_equals_small_steps():
    a, b = linearized(15.0, 0.08)
    start, inputs, steps = np.array([0.3, -0.1, 14.0]), np.array([0.05, 1.0]), 20000
    state = start
    for _ in range(steps):
        state = state + 0.05 / steps * (a @ state + b @ inputs)
    ad, bd = discretized(a, b, 0.05)
    assert ad @ start + bd @ inputs == pytest.approx(state, abs=1e-4)


def test_cost_and_dynamics_are_those_of_a_plan():
    random = np.random.default_rng(3)
    weights, steady, last = random.random(3), random.random(2), random.random(2)
    references, bends, inputs = random.random((4, 3)), random.random((4, 2)), random.random((4, 2))
    (ad, bd), state = discretized(*linearized(9.0, 0.03), 0.05), np.array([0.2, 0.1, 9.0])
    rows, right = dynamics(ad, bd, state, bends)
    states = []
    for one, bend in zip(inputs, bends):
        state = ad @ state + bd @ (one - bend)
        states.append(state)
    x = np.concatenate([np.ravel(states), inputs.ravel()])
    assert rows @ x == pytest.approx(right)
    p, q = cost(weights, steady, references, last)
    steps = np.diff(inputs, axis=0, prepend=[last])
    wanted = weights * (np.array(states) - references) ** 2
    constant = np.sum(weights * references**2) + np.sum(steady * last**2)
    twice = wanted.sum() + np.sum(steady * steps**2)
    assert x @ p @ x + 2 * q @ x + constant == pytest.approx(twice)


def test_limits_hold_for_inputs_and_changes():
    last, most, change = np.array([0.2, 1.0]), np.array([0.6, 2.0]), np.array([0.1, 0.3])
    lower, upper = limits(-2 * most, most, change, last, 3)
    rows = np.vstack([np.eye(6), changes(3)])
    inputs = np.array([0.3, 1.3, 0.2, 1.6, 0.1, 1.9])
    assert ((lower - 1e-9 <= rows @ inputs) & (rows @ inputs <= upper + 1e-9)).all()
    assert not (rows @ (inputs + 0.2) <= upper).all()


@needs_osqp
@pytest.mark.slow(20)
@pytest.mark.parametrize(
    "seed", (1, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in (9500, 10500)))
)
def test_driver_arrives_within_what_the_check_demands(seed):
    from sdc_mpc.drives import drive_bends

    driven = drive_bends(seed)
    assert driven.arrived
    assert driven.rms_m < 0.05
    assert driven.worst_m < 0.25


@needs_osqp
@pytest.mark.nightly
def test_driver_that_does_not_know_the_delay_loses_the_road():
    from sdc_mpc.drives import VARIANTS, drive_bends

    assert not drive_bends(1, VARIANTS["no-delay"]).arrived
    assert drive_bends(1, VARIANTS["lazy"]).rms_m > 2.0 * drive_bends(1).rms_m
