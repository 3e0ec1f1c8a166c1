"""A bad message is refused with a warning; other errors are not hidden."""

import contextlib

import pytest
import rospy

from sdc_common.ros import refusal
from sdc_common.ros.refusal import refusing


@pytest.fixture
def warnings(monkeypatch):
    """Collect the log, at a time that starts at 100 s and is changed by `warnings.now_s`."""

    class Log(list):
        now_s = 100.0

    log = Log()
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: log.append(text % args))
    monkeypatch.setattr(rospy, "get_name", lambda: "/planner")
    monkeypatch.setattr(refusal.time, "monotonic", lambda: log.now_s)
    monkeypatch.setattr(refusal, "_last_warning_s", {})
    return log


def test_value_error_is_logged_with_node_topic_and_reason(warnings):
    with refusing("/odometry"):
        raise ValueError("x is nan")
    assert warnings == ["planner: refused a message on /odometry: x is nan"]


def test_other_errors_are_raised_unless_they_are_named(warnings):
    with pytest.raises(KeyError), refusing("/odometry"):
        raise KeyError("a bug")
    assert warnings == []
    with refusing("/odometry", KeyError, TypeError):
        raise KeyError("bad data")
    assert len(warnings) == 1


@pytest.mark.parametrize("shutting_down", [False, True])
def test_closed_topic_is_an_error_unless_the_node_shuts_down(warnings, monkeypatch, shutting_down):
    monkeypatch.setattr(rospy.core, "is_shutdown_requested", lambda: shutting_down)
    expected = contextlib.nullcontext() if shutting_down else pytest.raises(rospy.ROSException)
    with expected, refusing("/odometry"):
        raise rospy.ROSException("publish() to a closed topic")
    assert warnings == []


def test_one_warning_a_second_is_logged_for_each_topic(warnings):
    def refuse(topic):
        with refusing(topic):
            raise ValueError("bad")

    for now_s in (100.0, 100.5, 100.99):
        warnings.now_s = now_s
        refuse("/odometry")
        refuse("/path")
    assert len(warnings) == 2
    assert [text.split(": ")[1] for text in warnings] == [
        "refused a message on /odometry",
        "refused a message on /path",
    ]
    warnings.now_s = 101.0
    refuse("/odometry")
    assert len(warnings) == 3
