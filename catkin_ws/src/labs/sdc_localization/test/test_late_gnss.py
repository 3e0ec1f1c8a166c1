import numpy as np
import pytest

from sdc_localization.late_drive import SETTINGS, after, ways
from sdc_localization.late_gnss import LateLocalizer


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
