"""Waits at the start until the nodes of the loop are connected, so that no message is lost."""

from __future__ import annotations

import http.client
import time
import xmlrpc.client
from typing import Any, Iterable, Sequence

import rosgraph
import rospy

from sdc_sim.ros.request_queue import RequestQueue

WARNING_AFTER_S = 5.0
# A node with a rate of its own answers no odometry before the time advances.
FIRST_ANSWER_S = 1.0
_POLL_S = 0.1
# Nodes with different definitions of a message never connect.
STUCK_S = 10.0
_CONNECTION = " to connect to "
_ANSWER_TIMEOUT_S = 1.0
# Directions of connections in the list that a node returns, see the slave API of ROS.
_INWARD, _OUTWARD = ("i", "b"), ("o", "b")


class StartHandshake:
    """Waits for the publisher of commands and for the subscribers of a tick.

    It is complete when
    - a publisher of commands is connected to this node, and
    - each of `nodes` subscribes to the odometry, and
    - each of `nodes`, and each other node that subscribes to a topic of the tick, is connected to
      every publisher of every topic that it subscribes to.

    The topics of the tick are latched: a node that starts later receives the present tick when it
    connects. A node subscribes to the odometry after its other topics, because its subscription to
    the odometry shows that it is ready.

    Args:
        command_subscribers: subscribers of this node to software commands
        odometry: name of the odometry topic
        tick_topics: names of the other topics that a node needs in a tick
        nodes: names of the nodes to wait for
        first_answer_s: least wall time to wait for the first answer
    """

    def __init__(
        self,
        command_subscribers: Sequence[rospy.Subscriber],
        odometry: str,
        tick_topics: Iterable[str],
        nodes: Iterable[str],
        first_answer_s: float = FIRST_ANSWER_S,
    ):
        self._command_subscribers = command_subscribers
        self._odometry = odometry
        self._tick_topics = (odometry, *tick_topics)
        self._nodes = set(nodes)
        self._first_answer_s = first_answer_s
        self._waited_s = 0.0

    @property
    def answer_timeout_s(self) -> float:
        """Wall time to wait for the answer to the first odometry.

        A machine on which the connections took long also computes the first answer slowly.
        """
        return max(self._first_answer_s, self._waited_s)

    def wait(self, deadline_s: float, requests: RequestQueue) -> None:
        """Process requests until the handshake is complete or the deadline (time.monotonic()).

        Connections between ready nodes are given up when none is made for STUCK_S.
        """
        started_s = time.monotonic()
        self._wait(deadline_s, requests)
        self._waited_s = time.monotonic() - started_s

    def _wait(self, deadline_s: float, requests: RequestQueue) -> None:
        last, changed_s = [""], time.monotonic()
        warning_s = changed_s + WARNING_AFTER_S
        while not rospy.is_shutdown() and (missing := self.missing()):
            now_s = time.monotonic()
            if missing != last or not all(_CONNECTION in each for each in missing):
                last, changed_s = missing, now_s
            if now_s > min(deadline_s, changed_s + STUCK_S):
                rospy.logwarn("sim: starts without %s", "; ".join(missing))
                return
            if now_s > warning_s:
                rospy.logwarn_once(f"sim: waiting for {'; '.join(missing)}")
            requests.process_until(time.monotonic() + _POLL_S)

    def missing(self) -> list[str]:
        """Return a description of each connection that is missing."""
        missing = []
        if not any(is_connected(subscriber) for subscriber in self._command_subscribers):
            missing.append(f"a publisher of {self._command_subscribers[0].resolved_name}")
        try:
            graph = ConnectionGraph()
            missing += missing_connections(graph, self._odometry, self._tick_topics, self._nodes)
        except (OSError, rosgraph.MasterException):
            missing.append("the ROS master")
        return missing


class ConnectionGraph:
    """The connections between all nodes at one time.

    Attributes:
        publishers: names of the nodes that publish each topic
        subscribers: names of the nodes that subscribe to each topic
    """

    def __init__(self) -> None:
        self._master = rosgraph.Master(rospy.get_name())
        self._uris: dict[str, str | None] = {}
        self._bus_infos: dict[str, Sequence[Sequence[Any]]] = {}
        publishers, subscribers, _ = self._master.getSystemState()
        self.publishers = {topic: set(nodes) for topic, nodes in publishers}
        self.subscribers = {topic: set(nodes) for topic, nodes in subscribers}

    def is_reachable(self, node: str) -> bool:
        """Return whether a node answers. A killed node stays registered at the master."""
        return self._ask(node, "getPid") is not None

    def connections(self, node: str) -> set[tuple[str, str]]:
        """Return topic and publisher of each connection to a subscribing node.

        A subscriber lists a connection before it is open, and a publisher lists one to a process
        that was killed. Only what both of them list is a connection.
        """
        return {
            (topic, publisher)
            for _, uri, direction, _, topic, *_ in self._bus_info(node)
            if direction in _INWARD
            for publisher in self.publishers.get(topic, ())
            if self._uri(publisher) == uri and node in self._receivers(publisher, topic)
        }

    def _receivers(self, publisher: str, topic: str) -> set[str]:
        """Return the names of the nodes to which a node publishes a topic."""
        return {
            receiver
            for _, receiver, direction, _, name, *_ in self._bus_info(publisher)
            if direction in _OUTWARD and name == topic
        }

    def _bus_info(self, node: str) -> Sequence[Sequence[Any]]:
        """Return the connections of a node as it lists them itself (getBusInfo)."""
        if node not in self._bus_infos:
            self._bus_infos[node] = self._ask(node, "getBusInfo") or ()
        return self._bus_infos[node]

    def _uri(self, node: str) -> str | None:
        if node not in self._uris:
            try:
                self._uris[node] = self._master.lookupNode(node)
            except rosgraph.MasterException:
                self._uris[node] = None
        return self._uris[node]

    def _ask(self, node: str, method: str) -> Any:
        """Call a method of the slave API of a node; return None if the node does not answer."""
        uri = self._uri(node)
        if uri is None:
            return None
        try:
            with xmlrpc.client.ServerProxy(uri, _Transport()) as proxy:
                return getattr(proxy, method)(rospy.get_name())[2]
        except (OSError, http.client.HTTPException, xmlrpc.client.Error):
            return None


def missing_connections(
    graph: ConnectionGraph, odometry: str, tick_topics: Iterable[str], nodes: set[str]
) -> list[str]:
    """Return a description of each connection that is missing for the first tick.

    Args:
        graph: the present connections
        odometry: name of the odometry topic
        tick_topics: topics whose reachable subscribers must be ready
        nodes: nodes that must be ready
    """
    absent = nodes - graph.subscribers.get(odometry, set())
    missing = [f"{node} to subscribe to {odometry}" for node in sorted(absent)]
    ready = set().union(nodes, *(graph.subscribers.get(topic, ()) for topic in tick_topics))
    for node in sorted(ready - absent):
        topics = {topic for topic, names in graph.subscribers.items() if node in names}
        wanted = {(topic, name) for topic in topics for name in graph.publishers.get(topic, ())}
        open_connections = wanted - graph.connections(node)
        if not open_connections or (node not in nodes and not graph.is_reachable(node)):
            continue
        missing += [
            f"{node}{_CONNECTION}{publisher} for {topic}"
            for topic, publisher in sorted(open_connections)
            if graph.is_reachable(publisher)
        ]
    return missing


def is_connected(subscriber: rospy.Subscriber) -> bool:
    """Return whether a publisher has accepted a connection of this subscriber.

    rospy counts a connection (`get_num_connections`) before it is open.
    """
    return any(connection.md5sum for connection in list(subscriber.impl.connections))


class _Transport(xmlrpc.client.Transport):
    """Ends calls to a node that does not answer, such as a stopped process."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = _ANSWER_TIMEOUT_S
        return connection
