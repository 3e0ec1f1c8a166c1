"""The connections between nodes: a drive in lockstep starts when those of its loop are open."""

from __future__ import annotations

import http.client
import time
import xmlrpc.client
from typing import Any, Callable, Sequence

import rosgraph
import rospy

from sdc_sim.ros.loop_lock import LoopLock

_WARNING_AFTER_S = 5.0
_POLL_S = 0.1
_ANSWER_TIMEOUT_S = 1.0
# Directions of a connection that its publisher lists, see the slave API of ROS.
_OUTWARD = ("o", "b")


class Connections:
    """The topics and the connections of all nodes at one time.

    Raises:
        OSError, rosgraph.MasterException: there is no ROS master
    """

    def __init__(self) -> None:
        self._master = rosgraph.Master(rospy.get_name())
        self._open: dict[str, set[tuple[str, str]]] = {}
        # Names of the nodes that publish, and that subscribe to, each topic.
        publishers, subscribers, _ = self._master.getSystemState()
        self.publishers = {topic: set(nodes) for topic, nodes in publishers}
        self.subscribers = {topic: set(nodes) for topic, nodes in subscribers}

    def is_reachable(self, node: str) -> bool:
        """Return whether a node answers. A killed node stays registered at the master."""
        return self._ask(node, "getPid") is not None

    def is_open(self, publisher: str, topic: str, subscriber: str) -> bool:
        """Return whether a publisher is connected to a subscriber, as the publisher lists it.

        A subscriber lists a connection before it is open.
        """
        if publisher not in self._open:
            listed = self._ask(publisher, "getBusInfo") or ()
            self._open[publisher] = {(link[4], link[1]) for link in listed if link[2] in _OUTWARD}
        return (topic, subscriber) in self._open[publisher]

    def _ask(self, node: str, method: str) -> Any:
        """Call a method of the slave API of a node; return None if the node does not answer."""
        try:
            with xmlrpc.client.ServerProxy(self._master.lookupNode(node), _Transport()) as proxy:
                return getattr(proxy, method)(rospy.get_name())[2]
        except (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterException):
            return None


class _Transport(xmlrpc.client.Transport):
    """Ends calls to a node that does not answer, such as a stopped process."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = _ANSWER_TIMEOUT_S
        return connection


def missing_connections(
    graph: Connections, odometry: str, tick_topics: Sequence[str], nodes: set[str]
) -> list[str]:
    """Return a description of each connection that is missing for the first tick.

    Each of the nodes must subscribe to the odometry, which a node does after its other topics.
    Each of them, and each node that subscribes to another topic of the tick, must be connected to
    all publishers of all its topics. Each other topic of the tick needs a publisher: a node of the
    car publishes the odometry where that is an estimate.

    Args:
        graph: the present connections
        odometry: name of the odometry topic
        tick_topics: names of the other topics that a node needs in a tick
        nodes: names of the nodes to wait for
    """
    absent = nodes - graph.subscribers.get(odometry, set())
    missing = [f"{node} to subscribe to {odometry}" for node in sorted(absent)]
    unpublished = [topic for topic in tick_topics if not graph.publishers.get(topic)]
    missing += [f"a publisher of {topic}" for topic in unpublished]
    needed = (graph.subscribers.get(topic, set()) for topic in (odometry, *tick_topics))
    ready = nodes.union(*needed) - absent
    for topic, subscribers in sorted(graph.subscribers.items()):
        for publisher in sorted(graph.publishers.get(topic, ())):
            missing += [
                f"{node} to connect to {publisher} for {topic}"
                for node in sorted(ready & subscribers)
                if not graph.is_open(publisher, topic, node)
                and graph.is_reachable(publisher)
                and (node in nodes or graph.is_reachable(node))
            ]
    return missing


def wait_for_connections(
    lock: LoopLock, missing: Callable[[], list[str]], timeout_s: float
) -> None:
    """Wait until no connection is missing, or until the timeout; the log names what is missing."""
    started_s = time.monotonic()
    while not rospy.is_shutdown():
        try:
            names = missing()
        except (OSError, rosgraph.MasterException):
            names = ["the ROS master"]
        waited_s = time.monotonic() - started_s
        if not names:
            return
        if waited_s > timeout_s:
            rospy.logwarn("sim: starts without %s", "; ".join(names))
            return
        if waited_s > _WARNING_AFTER_S:
            rospy.logwarn_once(f"sim: waiting for {'; '.join(names)}")
        lock.wait_until(_POLL_S)


def is_connected(subscriber: rospy.Subscriber) -> bool:
    """Return whether a publisher has accepted a connection of this subscriber.

    rospy counts a connection (`get_num_connections`) before it is open.
    """
    return any(connection.md5sum for connection in list(subscriber.impl.connections))
