import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.evaluation.command_matching import CommandTrace


def trace_of(events):
    """Return the trace of odometry (o) and commands (c) with these stamps: "o1 c1"."""
    trace = CommandTrace()
    for number, event in enumerate(events.split()):
        stamp = int(event[1:])
        if event[0] == "o":
            trace.stamps.append(stamp)
        else:
            trace.add_command(stamp, float(number), 0.25, -1.0)
    return trace


@pytest.mark.parametrize(
    ("events", "answered", "by_order", "missed"),
    [
        ("c0 o1", 0, 0, 0),  # nothing to answer yet
        ("o1", 0, 0, 0),
        ("o1 c0 c0", 0, 1, 0),
        ("o1 o2 c0 c0 c0", 0, 2, 1),  # the last one or the one before
        ("o1 o2 o3 o4 c0 c0 c0", 0, 2, 3),
        ("o1 c1 c1 c0", 1, 0, 0),
        ("o1 c1 o2", 1, 0, 0),  # the command of the last tick can still arrive
        ("o1 c1 o2 o3 c3", 2, 0, 1),
        ("o1 o2 c2 c0", 1, 1, 1),
        ("o1 o2 o3 c2 c3 c0", 2, 0, 1),
        ("o1 c2 c3 o2 o3", 2, 0, 1),  # before their odometry
        ("o1 o2 c99 o3 o4 c98", 0, 2, 3),  # the wall clock, at half the rate
    ],
)
def test_commands_answer_by_stamp_or_else_by_order(events, answered, by_order, missed):
    counts = {"missed_ticks": missed, "ticks_by_stamp": answered, "ticks_by_order": by_order}
    assert trace_of(events).counts() == counts


@given(st.sets(st.integers(1, 50)), st.randoms())
def test_order_of_arrival_does_not_matter(lost, random):
    events = [f"o{stamp}" for stamp in range(1, 52)]
    for stamp in set(range(1, 51)) - lost:
        place = events.index(f"o{stamp}") + random.randint(-3, 4)
        events.insert(max(0, min(len(events), place)), f"c{stamp}")
    counts = trace_of(" ".join(events)).counts()
    assert (counts["missed_ticks"], counts["ticks_by_stamp"]) == (len(lost), 50 - len(lost))


@pytest.mark.parametrize(
    ("events", "numbers"),
    [
        ("", []),
        ("o1", [math.nan]),
        ("c0 o1", [math.nan]),
        ("o1 o2 c1 c2 o3 o4 c4 c4", [2, 3, 3, 6]),  # with the stamp, else the last received
        ("o1 o2 o3 c9", [math.nan, math.nan, 3]),
    ],
)
def test_trace_has_the_command_of_each_tick(events, numbers):
    rows = trace_of(events).as_array(len(numbers))
    assert rows.shape == (len(numbers), 3)
    np.testing.assert_array_equal(rows[:, 0], numbers)
    assert set(rows[~np.isnan(rows[:, 0]), 2]) <= {-1.0}
