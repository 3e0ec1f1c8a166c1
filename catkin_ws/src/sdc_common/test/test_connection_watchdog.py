"""Clock that stops, and the registration with a restarted master."""

import threading
import types

import pytest
import rosgraph

from sdc_common.ros import connection_watchdog
from sdc_common.ros.connection_watchdog import (
    ClockMonitor,
    MasterRegistration,
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


class RestartedMaster:
    """A ROS master, as rosgraph.Master gives access to it, and the XML-RPC interface of a node."""

    master_uri = "http://127.0.0.1:11311"
    pid = 100
    failure = None  # what each call of the master raises
    connections = ()
    subscriptions = (("/cmd", "sdc_msgs/CarlaVehicleControl"),)

    def __init__(self):
        self.nodes, self.parameters, self.updates = {"/car"}, {}, []
        self.publishers, self.subscribers, self.services = {}, {}, {}

    def restart(self):
        self.__init__()
        self.pid += 1
        self.nodes = set()

    def getPid(self):  # noqa: N802 (names of ROS)
        if self.failure is not None:
            raise self.failure
        return self.pid

    def lookupNode(self, name):  # noqa: N802
        if name not in self.nodes:
            raise rosgraph.MasterException("unknown node")

    def hasParam(self, name):  # noqa: N802
        return name in self.parameters

    def setParam(self, name, value):  # noqa: N802
        self.parameters[name] = value

    def registerPublisher(self, topic, message_type, uri):  # noqa: N802
        self.nodes.add("/car")
        self.publishers[topic] = message_type, uri

    def registerSubscriber(self, topic, message_type, uri):  # noqa: N802
        self.nodes.add("/car")
        self.subscribers[topic] = message_type, uri
        return ["http://other:1"]

    def registerService(self, service, service_uri, uri):  # noqa: N802
        self.nodes.add("/car")
        self.services[service] = service_uri, uri

    def getPublications(self, caller):  # noqa: N802
        assert caller == "/car"
        return 1, "", [["/odometry", "nav_msgs/Odometry"]]

    def getSubscriptions(self, caller):  # noqa: N802
        assert caller == "/car"
        return 1, "", self.subscriptions

    def getBusInfo(self, caller):  # noqa: N802
        assert caller == "/car"
        return 1, "", self.connections

    def publisherUpdate(self, caller, topic, publishers):  # noqa: N802
        assert caller == "/car"
        self.updates.append((topic, publishers))


@pytest.fixture
def values():
    """Return the parameters that the node finds at its start."""
    return {"/use_sim_time": True, "/car": {"gain": 2.5}}


@pytest.fixture
def log():
    """Return the lines that the node has logged."""
    return []


@pytest.fixture
def master(monkeypatch, values, log):
    found = RestartedMaster()
    services = [("/car/pause", "rosrpc://me:5")]
    manager = types.SimpleNamespace(get_services=lambda: services)
    for name, value in (
        ("rospy.get_name", lambda: "/car"),
        ("rospy.get_node_uri", lambda: "http://me:4"),
        ("rospy.get_param", lambda name, default: values.get(name, default)),
        ("rospy.logwarn", lambda text, *arguments: log.append(text % arguments)),
        ("rospy.loginfo", lambda text, *arguments: log.append(text % arguments)),
        ("rosgraph.Master", {"/car": found}.__getitem__),
        ("xmlrpc.client.ServerProxy", {"http://me:4": found}.__getitem__),
        ("get_service_manager", lambda: manager),
    ):
        monkeypatch.setattr(f"{connection_watchdog.__name__}.{name}", value)
    return found


def test_node_registers_all_of_itself_with_a_restarted_master(master):
    registration = MasterRegistration()
    registration.check()
    assert (master.publishers, master.services) == ({}, {}), "the master knows the node"
    master.restart()
    registration.check()
    assert master.publishers == {"/odometry": ("nav_msgs/Odometry", "http://me:4")}
    assert master.subscribers == {"/cmd": ("sdc_msgs/CarlaVehicleControl", "http://me:4")}
    assert master.updates == [("/cmd", ["http://other:1"])]
    assert master.services == {"/car/pause": ("rosrpc://me:5", "http://me:4")}
    assert master.parameters == {"/use_sim_time": True, "/car": {"gain": 2.5}}


def test_restarted_master_keeps_the_parameters_that_it_has_already(master):
    registration = MasterRegistration()
    master.restart()
    master.parameters["/car"] = {"gain": 1.0}
    registration.check()
    assert master.parameters == {"/use_sim_time": True, "/car": {"gain": 1.0}}


def test_node_registers_the_rest_of_itself_with_a_master_that_knows_a_part(master):
    registration = MasterRegistration()
    master.restart()
    master.registerSubscriber("/new", "std_msgs/Empty", "http://me:4")  # rospy does that
    registration.check()
    assert "/odometry" in master.publishers


def test_node_registers_with_a_master_of_the_same_process_id(master):
    registration = MasterRegistration()
    master.restart()
    master.pid -= 1
    registration.check()
    assert "/odometry" in master.publishers


def test_restart_of_the_master_is_logged_once(master, log):
    registration = MasterRegistration()
    master.restart()
    for _ in range(3):
        registration.check()
    (line,) = log
    assert line.startswith("car: the roscore was restarted")
    assert line.endswith("registered again")


def test_restarted_master_gets_no_parameters_that_the_node_did_not_have(master, values):
    values.clear()
    registration = MasterRegistration()
    master.restart()
    registration.check()
    assert master.parameters == {"/use_sim_time": False}


def test_each_time_without_a_master_is_logged_once(master, log):
    registration = MasterRegistration()
    for failure in (OSError(), None, OSError(), OSError()):
        master.failure = failure
        registration.check()
    assert len(log) == 2
    assert log[0] == log[1]
    assert log[0].startswith("car: no roscore responds at http://127.0.0.1:11311;")
    assert log[0].endswith("existing connections stay")


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


@pytest.mark.parametrize("restart_s", [0.5, 4.0, 14.0])
def test_restarted_master_is_noticed_within_11_s(node, master, restart_s):
    node.at[restart_s] = master.restart
    node.watch(restart_s + 11.0)
    assert "/odometry" in master.publishers


@pytest.mark.parametrize("failure", [ConnectionRefusedError(), rosgraph.MasterException("none")])
def test_node_that_starts_without_a_master_is_not_watched(node, master, log, failure):
    master.failure = failure
    node.watch(20.0)
    assert log == []
