import math

import pytest

from sdc_sim.evaluation.timeline import IGNORED, NEXT, RESTARTED, Timeline


def classified(*times):
    timeline = Timeline()
    return [timeline.advance(time) for time in times]


def test_time_advances_and_a_repeated_stamp_is_ignored():
    assert classified(0.05, 0.05, 0.1, 4.0) == [NEXT, IGNORED, NEXT, NEXT]


@pytest.mark.parametrize("strange", [0.02, 4.5, -10.0, 1e9, math.nan, math.inf])
def test_one_implausible_stamp_is_ignored(strange):
    assert classified(5.0, strange, 5.05, 5.1) == [NEXT, IGNORED, NEXT, NEXT]


def test_stamps_of_a_second_publisher_are_ignored():
    times = (time for tick in range(10) for time in (10.0 + 0.05 * tick, 9.9 + 0.05 * tick))
    assert classified(*times)[1::2] == [IGNORED] * 10


def test_restart_is_accepted_after_some_ticks():
    assert classified(30.0, *(0.05 * tick for tick in range(1, 9))) == [
        NEXT,
        *[IGNORED] * 4,
        RESTARTED,
        NEXT,
        NEXT,
        NEXT,
    ]


def test_long_gap_is_accepted_after_some_ticks():
    steps = classified(30.0, *(100.0 + 0.05 * tick for tick in range(8)))
    assert steps == [NEXT, *[IGNORED] * 4, NEXT, NEXT, NEXT, NEXT]


def test_implausible_stamps_that_do_not_agree_are_never_accepted():
    assert set(classified(30.0, *(1000.0 - 20.0 * n for n in range(20)))[1:]) == {IGNORED}
