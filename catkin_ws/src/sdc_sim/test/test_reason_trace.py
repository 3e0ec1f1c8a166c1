"""Which published reason applies at a tick."""

import pytest

from sdc_sim.evaluation.reason_trace import ReasonTrace

SECOND_NS = 1_000_000_000


@pytest.fixture
def trace():
    filled = ReasonTrace()
    filled.add(4 * SECOND_NS, "bend")
    filled.add(2 * SECOND_NS, "start")
    return filled


@pytest.mark.parametrize(
    ("time_ns", "reason"),
    [
        (2 * SECOND_NS - 1, ""),
        (2 * SECOND_NS, "start"),
        (3 * SECOND_NS, "start"),
        (3 * SECOND_NS + 1, ""),
        (4 * SECOND_NS - 1, ""),
        (4 * SECOND_NS, "bend"),
        (5 * SECOND_NS, "bend"),
        (5 * SECOND_NS + 1, ""),
    ],
)
def test_reason_applies_from_its_stamp_on_for_a_second(trace, time_ns, reason):
    assert trace.at(time_ns) == reason


def test_later_message_with_the_same_stamp_applies(trace):
    trace.add(4 * SECOND_NS, "obstacle")
    assert trace.at(4 * SECOND_NS) == "obstacle"


def test_only_the_beginning_of_a_long_name_is_kept(trace):
    trace.add(7 * SECOND_NS, "x" * 41)
    assert trace.at(7 * SECOND_NS) == "x" * 40
