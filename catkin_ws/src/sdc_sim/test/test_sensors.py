"""Odometry noise has its sigma and its seed."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
import pytest

from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.errors import ErrorSizes, OdometryNoise, SensorErrors

TRUE = VehicleState(10.0, -5.0, 0.3, 8.0)


@pytest.mark.parametrize("seed", [0, 7, 2**32 - 1])
def test_seed_determines_the_noise(seed):
    first, second = OdometryNoise(seed, 0.1, 0.01, 0.2), OdometryNoise(seed, 0.1, 0.01, 0.2)
    other = OdometryNoise(seed - 1 if seed else 1, 0.1, 0.01, 0.2)
    rows = [first.apply(TRUE) for _ in range(5)]
    assert rows == [second.apply(TRUE) for _ in range(5)]
    assert rows != [other.apply(TRUE) for _ in range(5)]
    assert rows[0] != rows[1]


def test_one_kind_of_noise_does_not_depend_on_the_others():
    speed_alone, both = OdometryNoise(3, speed_mps=0.5), OdometryNoise(3, 0.1, speed_mps=0.5)
    speeds = [[noise.apply(TRUE).speed_mps for _ in range(3)] for noise in (speed_alone, both)]
    assert speeds[0] == speeds[1]


def test_sensors_of_one_drive_have_different_errors():
    sensors = [SensorErrors(7, number, [ErrorSizes(noise=1.0)], 0.1) for number in (1, 2)]
    first, second = ([sensor.apply([0.0], tick)[0] for tick in range(3)] for sensor in sensors)
    assert not set(first) & set(second)


def test_noise_has_its_sigmas_no_bias_and_no_correlation():
    noise = OdometryNoise(11, position_m=0.2, heading_rad=0.02, speed_mps=0.5)
    states = (noise.apply(TRUE) for _ in range(20000))
    errors = np.array([astuple(state)[:4] for state in states]) - astuple(TRUE)[:4]
    assert errors.std(axis=0) == pytest.approx([0.2, 0.2, 0.02, 0.5], rel=0.03)
    assert np.abs(errors.mean(axis=0) / [0.2, 0.2, 0.02, 0.5]).max() < 0.03
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 0.03
