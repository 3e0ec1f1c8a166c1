import dataclasses
import math

import numpy as np
import pytest

from sdc_localization.late_drive import SETTINGS, after, ways
from sdc_localization.late_gnss import LateLocalizer
from sdc_localization.localizer import Localizer, LocalizerSettings

LANE = np.column_stack([np.zeros(101), np.arange(0.0, 101.0)])
STEP_S = 0.05


@pytest.fixture
def localizer(settings):
    """Return a localizer of a car at rest in its lane, which leads north, from an exact start."""
    found = Localizer(settings)
    found.start(0.0, 10.0, 0.01, LANE)
    found.move(0.0, 0.0, 0.0)
    return found


def drive(localizer, seconds, speed=10.0, gyro=0.0, fix=None):
    """Drive north from (0, 10) with fixes of fix(x, y); return the true y."""
    start, y = localizer._motion[0], localizer.state[1]
    for tick in range(1, round(seconds / STEP_S) + 1):
        localizer.move(start + tick * STEP_S, speed, gyro)
        y += speed * STEP_S
        if fix is not None:
            localizer.add_position(*fix(0.0, y), 1.0)
    return y


def test_car_starts_in_its_lane_with_its_direction(settings):
    localizer = Localizer(settings)
    localizer.start(1.5, 30.2, 1.0, LANE)
    x, y, yaw = localizer.state[:3]
    assert (x, y, yaw) == pytest.approx((0.0, 30.2, 0.5 * math.pi))
    across, along = np.diag(localizer.covariance)[:2]
    assert along == pytest.approx(1.0)
    assert across == pytest.approx(settings.initial_across_m**2)


def test_outlier_is_refused_and_changes_nothing(localizer):
    drive(localizer, 1.0)
    state = localizer.state.copy()
    assert not localizer.add_position(30.0, 20.0, 1.0)
    assert (localizer.state == state).all()
    assert not localizer.lost


def test_localizer_is_lost_when_gnss_contradicts_it_for_long(localizer, settings):

    def far(x, y):
        return x + 500.0, y

    drive(localizer, settings.reset_after_s - 1.0, fix=far)
    assert not localizer.lost
    drive(localizer, 2.0, fix=far)
    assert localizer.lost
    localizer.start(500.0, 120.0, 1.0, LANE + (500.0, 0.0))
    assert not localizer.lost


def test_bad_parameter_is_named(settings):
    values = {**dataclasses.asdict(settings), "gate_2": -1.0}
    with pytest.raises(ValueError, match="gate_2 must be a positive number, got -1.0"):
        LocalizerSettings(**values)


@pytest.mark.parametrize("seed", [1, 5])
def test_late_positions_cost_almost_nothing(seed):
    in_time, at_once, late = ways(seed).values()
    assert in_time - 0.05 < late < 0.5
    assert at_once > 1.0


@pytest.mark.parametrize("arrival", [(6, 30.0, 0.0), (30, 0.5, 0.0)])
def test_late_outlier_and_old_position_change_nothing(arrival):
    answers, state = after(LateLocalizer(SETTINGS), {40: arrival})
    assert [used for used, _ in answers] == [False]
    assert (state == after(LateLocalizer(SETTINGS), {})[1]).all()


def test_two_late_positions_are_as_good_as_two_in_time():
    late = after(LateLocalizer(SETTINGS), {36: (6, 1.0, 0.5), 40: (6, -1.0, -0.5)})[1]
    in_time = after(LateLocalizer(SETTINGS), {30: (0, 1.0, 0.5), 34: (0, -1.0, -0.5)})[1]
    assert np.allclose(late, in_time)
