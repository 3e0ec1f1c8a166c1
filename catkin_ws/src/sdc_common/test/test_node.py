"""What nodes log about the connections of a drive."""

import pytest
import rospy
from rosgraph import Master

from sdc_common.processes import wait_until
from sdc_common.ros import node, speed_reason_publisher


@pytest.fixture
def warnings(monkeypatch):
    """Return the warnings of a node whose master responds."""
    logged = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: logged.append(text % values))
    monkeypatch.setattr(rospy, "logwarn_throttle", lambda seconds, text: logged.append(text))
    monkeypatch.setattr(Master, "getPid", lambda master: 1)
    return logged


@pytest.mark.parametrize(
    "times, has_ended, count",
    [((0, 0, 0), False, 1), ((0, 3, 3), False, 0), ((3, 4, 4), False, 1), ((3, 4, 4), True, 0)],
    ids=["no simulator", "waits at its first tick", "stopped", "after the drive"],
)
def test_stopped_clock_is_a_problem_during_a_drive(monkeypatch, warnings, times, has_ended, count):
    clock = iter(map(rospy.Time, times))
    monkeypatch.setattr(rospy, "get_rostime", lambda: next(clock))
    monkeypatch.setattr(rospy, "get_param", lambda name, default: has_ended)
    monkeypatch.setattr(node, "every", lambda seconds, check: (check(), check()))
    node.watch_connections()
    assert len(warnings) == count


def test_first_path_is_awaited_without_a_warning(monkeypatch, warnings):
    monkeypatch.setattr(speed_reason_publisher, "LoopPublisher", lambda *_, **__: None)
    reasons = speed_reason_publisher.SpeedReasonPublisher()
    monkeypatch.setattr(reasons, "update", lambda *_: None)
    reasons.timed_out("path", rospy.Time(1))
    assert warnings == []
    monkeypatch.setattr(reasons, "_started_s", -100.0)
    reasons.timed_out("path", rospy.Time(1))
    assert len(warnings) == 1 and "no path, braking" in warnings[0]


def test_function_is_called_periodically_although_the_master_does_not_respond(monkeypatch):
    calls = []

    def call():
        calls.append(1)
        raise OSError

    monkeypatch.setattr(rospy, "is_shutdown", lambda: len(calls) == 3)
    node.every(0.001, call)
    wait_until(lambda: len(calls) == 3, 10.0, "three calls")
