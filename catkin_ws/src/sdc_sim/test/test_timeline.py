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


def test_one_step_may_be_ten_seconds_long():
    assert classified(5.0, 15.0, 25.5) == [NEXT, NEXT, IGNORED]


def test_stamps_after_a_gap_may_be_ten_seconds_apart():
    assert classified(30.0, 100.0, 110.0, 120.0, 130.0, 140.0) == [NEXT, *[IGNORED] * 4, NEXT]


def test_a_stamp_that_is_repeated_does_not_agree_with_itself():
    assert classified(30.0, *[100.0] * 8) == [NEXT, *[IGNORED] * 8]


@pytest.mark.parametrize("first", [28.0, 29.0])
def test_stamps_of_up_to_one_second_before_are_no_restart(first):
    assert classified(30.0, *(first + 0.25 * n for n in range(5))) == [NEXT, *[IGNORED] * 5]


def test_after_a_restart_an_implausible_stamp_is_ignored_and_a_second_restart_accepted():
    restart = (5.0, 5.25, 5.5, 5.75, 6.0)
    steps = classified(30.0, *restart, 500.0, 6.25, *(time - 5.0 for time in restart))
    restarted = [*[IGNORED] * 4, RESTARTED]
    assert steps == [NEXT, *restarted, IGNORED, NEXT, *restarted]
