import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.evaluation.command_matching import CommandMatching, CommandTrace


def counts(events):
    """Return the counters after odometry (o) and commands (c) with these stamps: "o1 c1"."""
    matching = CommandMatching()
    for event in events.split():
        add = matching.add_odometry if event[0] == "o" else matching.add_command
        add(int(event[1:]))
    return matching.answered, matching.by_order, matching.missed, matching.pending


@pytest.mark.parametrize(
    ("events", "answered", "by_order", "missed", "pending"),
    [
        ("c0 o1", 0, 0, 0, False),  # nothing to answer yet
        ("o1", 0, 0, 0, False),
        ("o1 c0 c0", 0, 1, 0, False),
        ("o1 o2 c0 c0 c0", 0, 2, 1, False),  # the last one or the one before
        ("o1 o2 o3 o4 c0 c0 c0", 0, 2, 3, False),
        ("o1 c1", 1, 0, 0, False),
        ("o1 c1 c1 c0", 1, 0, 0, False),
        ("o1 c1 o2", 1, 0, 0, True),  # the command of the last tick can still arrive
        ("o1 c1 o1", 1, 0, 0, False),  # a repeated odometry is not a tick
        ("o1 c1 o2 o3 c3", 2, 0, 1, False),
        ("o1 o2 c2 c0", 1, 1, 1, False),
        ("o1 o2 o3 c2 c3 c0", 2, 0, 1, False),
        ("o1 c2 o2", 1, 0, 1, False),  # early: by order only until its odometry arrives
        ("o1 c2 c3 o2 o3", 2, 0, 1, False),
        ("o1 o2 c99 o3 o4 c98", 0, 2, 3, False),  # the wall clock, at half the rate
    ],
)
def test_commands_answer_by_stamp_or_else_by_order(events, answered, by_order, missed, pending):
    assert counts(events) == (answered, by_order, missed, pending)


def test_command_after_a_thousand_ticks_is_too_late_and_one_before_is_not():
    answers = []
    for last in (1000, 1001):
        matching = CommandMatching()
        for stamp in range(1, last + 1):
            matching.add_odometry(stamp)
        matching.add_command(1)
        answers.append((matching.answered, matching.missed))
    assert answers == [(1, 998), (0, 1000)]


def test_command_a_thousand_commands_early_is_forgotten_and_a_later_one_is_not():
    matching = CommandMatching()
    for stamp in range(1, 1002):
        matching.add_command(stamp)
    matching.add_odometry(1)
    assert matching.answered == 0
    matching.add_odometry(2)
    matching.add_odometry(1001)
    assert matching.answered == 2


@given(st.sets(st.integers(1, 50)), st.randoms())
def test_order_of_arrival_does_not_matter(lost, random):
    matching = CommandMatching()
    events = [("add_odometry", stamp) for stamp in range(1, 52)]
    for stamp in range(1, 51):
        if stamp not in lost:
            tick = events.index(("add_odometry", stamp))
            place = max(0, min(len(events), tick + random.randint(-3, 4)))
            events.insert(place, ("add_command", stamp))
    for kind, stamp in events:
        getattr(matching, kind)(stamp)
    assert matching.ticks == 51
    assert matching.missed == len(lost)
    assert matching.answered == 51 - len(lost) - 1


def test_trace_takes_the_command_with_the_stamp_and_else_the_last_received():
    trace = CommandTrace()
    trace.add_odometry(1)
    trace.add_odometry(2)
    trace.add_command(1, 0.1, 0.0, 0.0)
    trace.add_command(2, 0.2, 0.0, 0.0)
    trace.add_odometry(3)
    trace.add_odometry(4)
    trace.add_command(4, 0.4, 0.0, 0.0)
    trace.add_command(4, 0.5, 0.0, 0.0)
    np.testing.assert_array_equal(trace.as_array(4)[:, 0], [0.1, 0.2, 0.2, 0.4])
    assert trace.as_array(2).shape == (2, 3)


def test_last_received_command_is_that_of_the_current_tick():
    trace = CommandTrace()
    trace.add_odometry(1)
    trace.add_odometry(2)
    trace.add_odometry(3)
    trace.add_command(9, 0.5, 0.25, -1.0)
    np.testing.assert_array_equal(
        trace.as_array(3), [[math.nan] * 3, [math.nan] * 3, [0.5, 0.25, -1.0]]
    )


def test_trace_without_commands_is_nan():
    trace = CommandTrace()
    assert trace.as_array(0).shape == (0, 3)
    trace.add_odometry(1)
    np.testing.assert_array_equal(trace.as_array(1), [[math.nan] * 3])
