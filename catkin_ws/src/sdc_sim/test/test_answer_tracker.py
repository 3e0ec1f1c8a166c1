"""Commands answer the observation that has their stamp, or without a stamp the last one."""

import pytest

from sdc_sim.simulation.command_mux import AnswerTracker

TICK_NS = 50_000_000
OTHER_CLOCK = 1_700_000_000


def drive(*ticks):
    """Return whether each tick has been answered.

    Args:
        ticks: for each, the ticks whose stamps its commands have; 0 is none
    """
    answers, answered = AnswerTracker(), []
    for tick, stamps in enumerate(ticks, start=1):
        answers.expect()
        for stamp in stamps:
            if not answers.is_repeated(stamp * TICK_NS, tick * TICK_NS):
                answers.record(stamp * TICK_NS, tick * TICK_NS)
        if not answers.answered:
            answers.give_up()
        answered.append(answers.answered)
    return answered


@pytest.mark.parametrize(
    ("ticks", "answered"),
    [
        ([[1], [2], [3]], [1, 1, 1]),
        ([[0], [0], [0]], [1, 1, 1]),
        ([[], [2], []], [0, 1, 0]),
        # An older, a repeated or a later command answers nothing; the next one with the stamp does.
        ([[], [1, 2]], [0, 1]),
        ([[1], [1, 2]], [1, 1]),
        ([[1], [9, 2]], [1, 1]),
        ([[1, 1], [2]], [1, 1]),
        # A brake command without a stamp, as of a controller whose path is missing.
        ([[1], [0], [3]], [1, 1, 1]),
        # Stamps of the wall clock, and stamps that are one tick late, count as none after one tick.
        ([[OTHER_CLOCK], [OTHER_CLOCK], [OTHER_CLOCK]], [0, 1, 1]),
        ([[1], [1], [2], [3]], [1, 0, 1, 1]),
        # A stack that sent nothing for some ticks is still matched by stamp.
        ([[1], [], [], [4], [4, 5]], [1, 0, 0, 1, 1]),
    ],
)
def test_commands_answer_by_stamp_or_else_by_order(ticks, answered):
    assert drive(*ticks) == list(map(bool, answered))
