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


def test_last_message_is_repeated_within_a_quarter_of_a_second(trace):
    assert not trace.is_late(4 * SECOND_NS + 249_999_999)
    assert trace.is_late(4 * SECOND_NS + 250_000_000)
    assert not ReasonTrace().is_late(SECOND_NS)


def test_later_message_with_the_same_stamp_applies(trace):
    trace.add(4 * SECOND_NS, "obstacle")
    assert trace.at(4 * SECOND_NS) == "obstacle"


def test_only_the_beginning_of_a_long_name_is_kept(trace):
    trace.add(7 * SECOND_NS, "x" * 41)
    assert trace.at(7 * SECOND_NS) == "x" * 40


def test_message_that_still_applies_is_not_forgotten(trace):
    trace.forget_before(2 * SECOND_NS + 5)
    assert trace.at(2 * SECOND_NS + 5) == "start"
    trace.forget_before(4 * SECOND_NS)
    assert trace.at(3 * SECOND_NS) == ""
    assert trace.at(4 * SECOND_NS) == "bend"


def test_trace_without_messages_has_no_reason_and_nothing_to_forget():
    trace = ReasonTrace()
    trace.forget_before(SECOND_NS)
    assert trace.at(SECOND_NS) == ""


def test_messages_beyond_the_limit_are_forgotten():
    trace = ReasonTrace()
    for i in range(5001):
        trace.add(i, str(i))
    trace.forget_before(0)
    assert trace.at(4999) == "4999"
    assert trace.at(5000) == "4999"
