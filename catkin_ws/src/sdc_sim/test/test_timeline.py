import math

import pytest

from sdc_sim.evaluation.timeline import LEFT_OUT, NEXT, RESTARTED, Timeline


def judged(*times):
    timeline = Timeline()
    return [timeline.take(time) for time in times]


def test_time_moves_on_and_repeats():
    assert judged(0.05, 0.05, 0.1, 4.0) == [NEXT, LEFT_OUT, NEXT, NEXT]


@pytest.mark.parametrize("strange", [0.02, 4.5, -10.0, 1e9, math.nan, math.inf])
def test_one_strange_stamp_is_left_out(strange):
    assert judged(5.0, strange, 5.05, 5.1) == [NEXT, LEFT_OUT, NEXT, NEXT]


def test_two_publishers_between_each_other():
    assert (
        judged(*(time for tick in range(10) for time in (10.0 + 0.05 * tick, 9.9 + 0.05 * tick)))[
            1::2
        ]
        == [LEFT_OUT] * 10
    )


def test_a_world_that_begins_anew_is_believed_after_some_ticks():
    verdicts = judged(30.0, *(0.05 * tick for tick in range(1, 9)))
    assert verdicts == [NEXT, *[LEFT_OUT] * 4, RESTARTED, NEXT, NEXT, NEXT]


def test_a_long_silence_is_believed_after_some_ticks():
    verdicts = judged(30.0, *(100.0 + 0.05 * tick for tick in range(8)))
    assert verdicts == [NEXT, *[LEFT_OUT] * 4, NEXT, NEXT, NEXT, NEXT]


def test_strange_stamps_that_do_not_agree_are_never_believed():
    assert set(judged(30.0, *(1000.0 - 20.0 * n for n in range(20)))[1:]) == {LEFT_OUT}
