"""The start in lockstep names each connection that is missing for the first tick."""

import logging

import pytest

from sdc_sim.ros.connections import missing_connections, wait_for_connections
from sdc_sim.ros.loop_lock import LoopLock

ODOMETRY, OBSTACLES, COMMAND, PATH = "/odometry", "/obstacles", "/command", "/path"

BLIND = "/planner to connect to /sim for /obstacles"
DEAF = "/referee to connect to /planner for /path"


class Graph:
    """The referee and a planner are connected, except where a test says otherwise."""

    publishers = {ODOMETRY: {"/sim"}, OBSTACLES: {"/sim"}}
    publishers.update({COMMAND: {"/controller"}, PATH: {"/planner"}})
    subscribers = {ODOMETRY: {"/referee", "/planner"}, OBSTACLES: {"/planner"}}
    subscribers.update({COMMAND: {"/sim", "/referee", "/plot"}, PATH: {"/referee"}})

    def __init__(self, closed=(), dead=()):
        self.closed, self.dead = closed, dead

    def is_reachable(self, node):
        return node not in self.dead

    def is_open(self, publisher, topic, subscriber):
        return (publisher, topic, subscriber) not in self.closed and subscriber != "/plot"


@pytest.mark.parametrize(
    ("closed", "dead", "nodes", "missing"),
    [
        ([], [], ["/referee"], []),
        ([], [], ["/referee", "/record"], ["/record to subscribe to /odometry"]),
        (
            *([("/controller", COMMAND, "/referee"), ("/sim", OBSTACLES, "/planner")], []),
            *(["/referee"], ["/referee to connect to /controller for /command", BLIND]),
        ),
        # A killed node is still registered. One to wait for is not ignored.
        ([("/controller", COMMAND, "/referee")], ["/controller"], ["/referee"], []),
        ([("/sim", OBSTACLES, "/planner")], ["/planner"], ["/referee"], []),
        ([("/planner", PATH, "/referee")], ["/referee"], ["/referee"], [DEAF]),
    ],
)
def test_each_missing_connection_is_named(closed, dead, nodes, missing):
    graph = Graph(closed, dead)
    assert missing_connections(graph, ODOMETRY, [OBSTACLES], set(nodes)) == missing


def test_odometry_that_the_car_estimates_needs_a_publisher():
    missing = missing_connections(Graph(), ODOMETRY, [OBSTACLES, "/estimate"], {"/referee"})
    assert missing == ["a publisher of /estimate"]


def test_start_waits_for_connections_until_its_timeout(caplog):
    lock = LoopLock()
    with lock:
        left = [["a"], ["a"], []]
        wait_for_connections(lock, lambda: left.pop(0), 60.0)
        assert left == []
        with caplog.at_level(logging.WARNING):
            wait_for_connections(lock, lambda: ["/referee to connect"], 0.0)
    assert "starts without /referee to connect" in caplog.text
