"""A clock that stops, and a master that is gone."""

import threading
import types

import pytest

from sdc_common.ros import connection_watchdog
from sdc_common.ros.connection_watchdog import (
    ClockMonitor,
    topics_without_publisher,
    watch_connections,
)


def test_stop_and_continuation_of_the_clock_are_reported_once_each():
    clock = ClockMonitor(5.0)
    changes = []
    for step in range(60):
        wall_s = 100.0 + 0.5 * step
        sim_time = 7.0 if step < 20 else 0.05 * step if step < 40 else 99.0
        if clock.update(wall_s, sim_time):
            changes.append((wall_s, clock.stopped))
    assert changes == [(105.0, True), (110.0, False), (125.0, True)]


def test_running_clock_reports_no_change():
    clock = ClockMonitor(5.0)
    assert not any(clock.update(0.5 * step, step) for step in range(1000))


class Master:
    """A ROS master, as rosgraph.Master gives access to it, and the XML-RPC interface of a node."""

    master_uri = "http://127.0.0.1:11311"
    failure = None  # what each call of the master raises
    connections = ()
    subscriptions = (("/cmd", "sdc_msgs/CarlaVehicleControl"),)

    def getPid(self):  # noqa: N802 (names of ROS)
        if self.failure is not None:
            raise self.failure
        return 100

    def getSubscriptions(self, caller):  # noqa: N802
        assert caller == "/car"
        return 1, "", self.subscriptions

    def getBusInfo(self, caller):  # noqa: N802
        assert caller == "/car"
        return 1, "", self.connections


@pytest.fixture
def values():
    """Return the parameters that the node finds at its start."""
    return {"/use_sim_time": True}


@pytest.fixture
def log():
    """Return the lines that the node has logged."""
    return []


@pytest.fixture
def master(monkeypatch, values, log):
    found = Master()
    for name, value in (
        ("rospy.get_name", lambda: "/car"),
        ("rospy.get_node_uri", lambda: "http://me:4"),
        ("rospy.get_param", lambda name, default: values.get(name, default)),
        ("rospy.logwarn", lambda text, *arguments: log.append(text % arguments)),
        ("rospy.loginfo", lambda text, *arguments: log.append(text % arguments)),
        ("rosgraph.Master", {"/car": found}.__getitem__),
        ("xmlrpc.client.ServerProxy", {"http://me:4": found}.__getitem__),
    ):
        monkeypatch.setattr(f"{connection_watchdog.__name__}.{name}", value)
    return found


def test_topics_with_a_connected_publisher_are_not_named(master):
    # id, other node, direction (in, out, both), transport, topic, whether it is connected
    master.connections = (
        (1, "http://other:1", "i", "TCPROS", "/cmd", 1),
        (2, "http://other:1", "i", "TCPROS", "/gone", 0),
        (3, "http://other:1", "o", "TCPROS", "/looped", 1),
        (4, "http://other:1", "b", "UDPROS", "/both", 1),
    )
    names = ("/never", "/looped", "/gone", "/cmd", "/both")
    master.subscriptions = [(name, "std_msgs/Empty") for name in names]
    assert topics_without_publisher() == ["/gone", "/looped", "/never"]


class WatchedNode:
    """Time for `watch_connections`, which passes at once.

    Attributes:
        sim_time: function of the wall time since the start [s]
        at: functions to call, by the wall time since the start [s]
    """

    def __init__(self, monkeypatch):
        self._monkeypatch = monkeypatch
        self._passed_s, self._end_s = 0.0, 0.0
        self._failures, self._daemons = [], []
        self.sim_time, self.at = float, {}
        wall_clock = types.SimpleNamespace(
            sleep=self._sleep, monotonic=lambda: 1000.0 + self._passed_s
        )
        rospy = f"{connection_watchdog.__name__}.rospy"
        monkeypatch.setattr(connection_watchdog, "time", wall_clock)
        monkeypatch.setattr(f"{rospy}.get_rostime", lambda: self.sim_time(self._passed_s))
        monkeypatch.setattr(f"{rospy}.core.is_shutdown_requested", self._is_at_the_end)

    def _is_at_the_end(self):
        return self._passed_s >= self._end_s

    def _sleep(self, duration_s):
        self._daemons.append(threading.current_thread().daemon)
        self._passed_s += duration_s
        for time_s in [one for one in self.at if one <= self._passed_s]:
            self.at.pop(time_s)()

    def watch(self, duration_s):
        """Watch for so long [s]."""
        self._end_s = duration_s
        self._monkeypatch.setattr(threading, "excepthook", self._failures.append)
        others = set(threading.enumerate())
        watch_connections()
        for thread in set(threading.enumerate()) - others:
            thread.join(60.0)
        assert self._failures == []
        assert all(self._daemons), "the thread keeps the process from ending"


@pytest.fixture
def node(monkeypatch, master):
    return WatchedNode(monkeypatch)


def test_clock_that_stops_for_5_s_is_logged_with_the_topics_without_publisher(node, master, log):
    master.subscriptions = (("/path", "nav_msgs/Path"), *master.subscriptions)
    node.sim_time = lambda wall_s: 3.0 if 3.0 < wall_s < 7.0 else min(wall_s, 10.0)
    node.watch(14.5)
    assert log == []
    node.watch(22.0)
    (stopped,) = log
    assert stopped.startswith("car: waiting for /clock, which stopped 5 s ago: ")
    assert stopped.endswith(" or waits for a command; no publisher of /cmd, /path")


def test_clock_that_continues_is_logged(node, log):
    node.sim_time = lambda wall_s: 3.0 if 3.0 < wall_s < 9.0 else wall_s
    node.watch(30.0)
    assert len(log) == 2
    assert log[1] == "car: /clock continues"


def test_stopped_clock_of_a_connected_node_is_logged_without_topics(node, master, log):
    master.connections = [(1, "http://other:1", "i", "TCPROS", "/cmd", 1)]
    node.sim_time = lambda wall_s: 3.0
    node.watch(20.0)
    (stopped,) = log
    assert stopped.endswith(" or waits for a command")


def test_node_without_simulated_time_logs_nothing_about_the_clock(node, values, log):
    values.clear()
    node.sim_time = lambda wall_s: 3.0
    node.watch(20.0)
    assert log == []


def test_each_time_without_a_master_is_logged_once(node, master, log):
    def failing(failure):
        master.failure = failure

    node.at = {15.0: lambda: failing(OSError()), 45.0: lambda: failing(None)}
    node.at[65.0] = node.at[15.0]
    node.watch(100.0)
    assert len(log) == 2
    assert log[0] == log[1]
    assert log[0].startswith("car: no roscore responds at http://127.0.0.1:11311; existing")
