"""The start handshake names each connection that is missing for the first tick."""

import time
from types import SimpleNamespace

import pytest

from sdc_sim.ros import start_handshake
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.ros.start_handshake import (
    ConnectionGraph,
    StartHandshake,
    is_connected,
    missing_connections,
)

ODOMETRY, OBSTACLES, COMMAND, PATH = "/odometry", "/obstacles", "/command", "/path"
TICK_TOPICS = (ODOMETRY, OBSTACLES)


class FakeGraph:
    """A world in which the referee and a planner are fully connected."""

    def __init__(self):
        self.publishers = {
            ODOMETRY: {"/sim"},
            OBSTACLES: {"/sim"},
            COMMAND: {"/controller"},
            PATH: {"/planner"},
        }
        self.subscribers = {
            ODOMETRY: {"/referee", "/planner"},
            OBSTACLES: {"/planner"},
            COMMAND: {"/sim", "/referee"},
            PATH: {"/referee"},
        }
        self.unreachable = set()
        self.connected = {
            "/referee": {(ODOMETRY, "/sim"), (COMMAND, "/controller"), (PATH, "/planner")},
            "/planner": {(ODOMETRY, "/sim"), (OBSTACLES, "/sim")},
        }

    def is_reachable(self, node):
        return node not in self.unreachable

    def connections(self, node):
        return self.connected.get(node, set())


def missing(graph, nodes=("/referee",)):
    return missing_connections(graph, ODOMETRY, TICK_TOPICS, set(nodes))


def test_nothing_is_missing_when_all_nodes_are_connected():
    assert missing(FakeGraph()) == []


def test_node_that_does_not_run_is_missing():
    assert missing(FakeGraph(), ["/referee", "/record"]) == ["/record to subscribe to /odometry"]


@pytest.mark.parametrize(
    ("node", "topic", "publisher"),
    [
        ("/referee", COMMAND, "/controller"),
        ("/referee", ODOMETRY, "/sim"),
        ("/planner", OBSTACLES, "/sim"),
    ],
)
def test_each_missing_connection_is_named(node, topic, publisher):
    graph = FakeGraph()
    graph.connected[node].remove((topic, publisher))
    assert missing(graph) == [f"{node} to connect to {publisher} for {topic}"]


def test_topic_without_a_publisher_is_not_missing():
    graph = FakeGraph()
    del graph.publishers[PATH]
    graph.connected["/referee"].remove((PATH, "/planner"))
    assert missing(graph) == []


def test_node_that_subscribes_to_no_topic_of_the_tick_is_ignored():
    graph = FakeGraph()
    graph.subscribers[COMMAND].add("/plot")
    assert missing(graph) == []


@pytest.mark.parametrize("dead", ["/planner", "/controller"])
def test_killed_node_that_is_still_registered_is_ignored(dead):
    graph = FakeGraph()
    graph.unreachable = {dead}
    graph.connected["/planner"] = set()
    graph.connected["/referee"] = {(ODOMETRY, "/sim")} | (
        {(COMMAND, "/controller")} if dead == "/planner" else {(PATH, "/planner")}
    )
    if dead == "/controller":
        graph.connected["/planner"] = {(ODOMETRY, "/sim"), (OBSTACLES, "/sim")}
    assert missing(graph) == []


def test_node_to_wait_for_is_not_ignored_when_it_does_not_answer():
    graph = FakeGraph()
    graph.unreachable = {"/referee"}
    graph.connected["/referee"] = set()
    assert "/referee to connect to /sim for /odometry" in missing(graph)


class FakeMaster:
    """A master that knows the nodes /sim and /referee."""

    def __init__(self, _caller):
        pass

    def getSystemState(self):
        return [[ODOMETRY, ["/sim"]]], [[ODOMETRY, ["/referee"]]], []

    def lookupNode(self, name):
        return "http:/" + name


@pytest.mark.parametrize(
    ("publisher_lists_it", "subscriber_lists_it", "connected"),
    [(True, True, True), (False, True, False), (True, False, False)],
)
def test_connection_counts_when_both_nodes_list_it(
    monkeypatch, publisher_lists_it, subscriber_lists_it, connected
):
    outward = [[1, "/referee", "o", "TCPROS", ODOMETRY, True, ""]] * publisher_lists_it
    inward = [[1, "http://sim", "i", "TCPROS", ODOMETRY, True, ""]] * subscriber_lists_it
    bus_infos = {"/sim": outward, "/referee": inward}
    monkeypatch.setattr(start_handshake.rosgraph, "Master", FakeMaster)
    monkeypatch.setattr(ConnectionGraph, "_ask", lambda self, node, method: bus_infos[node])
    expected = {(ODOMETRY, "/sim")} if connected else set()
    assert ConnectionGraph().connections("/referee") == expected


@pytest.mark.parametrize(("md5sum", "connected"), [(None, False), ("50204ce1", True)])
def test_subscriber_is_connected_when_the_publisher_has_accepted(md5sum, connected):
    connections = [SimpleNamespace(md5sum=md5sum)]
    subscriber = SimpleNamespace(impl=SimpleNamespace(connections=connections))
    assert is_connected(subscriber) == connected


class Handshake(StartHandshake):
    """Lacks the given connections at each poll, the last ones for ever."""

    def __init__(self, *polls):
        super().__init__((), ODOMETRY, (), ())
        self.polls = list(polls)

    def missing(self):
        return self.polls.pop(0) if len(self.polls) > 1 else self.polls[0]


CONNECTION = "/referee to connect to /planner for /path"


def test_connection_that_is_never_made_does_not_delay_the_start(monkeypatch):
    monkeypatch.setattr(start_handshake, "STUCK_S", 0.3)
    Handshake([CONNECTION, "another to connect to it"], [CONNECTION]).wait(
        time.monotonic() + 3600.0, RequestQueue()
    )


def test_absent_node_is_waited_for_until_the_deadline(monkeypatch):
    monkeypatch.setattr(start_handshake, "STUCK_S", 0.0)
    handshake = Handshake(*[["/record to subscribe to /odometry", CONNECTION]] * 5, [])
    handshake.wait(time.monotonic() + 3600.0, RequestQueue())
    assert handshake.polls == [[]]
