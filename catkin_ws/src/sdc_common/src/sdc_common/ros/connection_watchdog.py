"""Watch what a node depends on: the simulated clock and the ROS master."""

from __future__ import annotations

import contextlib
import math
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
from rospy.impl.registration import get_service_manager

CLOCK_TIMEOUT_S = 5.0
_CHECK_CLOCK_EVERY_S = 0.5
_CHECK_MASTER_EVERY_S = 10.0


class ClockMonitor:
    """Detects when simulated time stops and when it continues.

    Attributes:
        stopped: whether simulated time has not changed for the timeout
    """

    def __init__(self, timeout_s: float):
        """Start to monitor at the first update.

        Args:
            timeout_s: after this wall time without a change, the clock counts as stopped [s]
        """
        self._timeout_s = timeout_s
        self._changed_at_s = math.nan
        self._last: object = None
        self.stopped = False

    def update(self, wall_s: float, sim_time: object) -> bool:
        """Take the present times.

        Args:
            wall_s: the wall clock [s]
            sim_time: simulated time, in any type that can be compared

        Returns:
            whether `stopped` has changed
        """
        if sim_time != self._last:
            self._last = sim_time
            self._changed_at_s = wall_s
        stopped = wall_s - self._changed_at_s >= self._timeout_s
        changed = stopped != self.stopped
        self.stopped = stopped
        return changed


class MasterRegistration:
    """Registers this node again after the roscore was restarted.

    Connected nodes work without the master. But a restarted master has no registrations and no
    parameters: a new node finds no other. So each node registers its topics, its services and its
    own parameters again.
    """

    def __init__(self):
        self._name = rospy.get_name()
        self._master = rosgraph.Master(self._name)
        self._unreachable = False
        self._master_pid = self._master.getPid()
        self.uses_sim_time = rospy.get_param("/use_sim_time", False)
        self._parameters = {
            "/use_sim_time": self.uses_sim_time,
            self._name: rospy.get_param(self._name, None),
        }

    def check(self) -> None:
        """Register again if the master is another process, or does not know this node.

        A new master may know a part of this node: rospy registers a topic that was added without a
        master as soon as there is one again. In a container, it may have the process id of the old
        one.
        """
        if rospy.core.is_shutdown_requested():
            return
        try:
            pid = self._master.getPid()
            if pid != self._master_pid or not self._is_known():
                self._register()
                self._master_pid = pid
                self._warn("the roscore was restarted; registered again")
        except rosgraph.MasterException:
            return
        except OSError:
            if not self._unreachable:
                self._warn(
                    f"no roscore responds at {self._master.master_uri}; existing connections stay"
                )
            self._unreachable = True
            return
        self._unreachable = False

    def _is_known(self) -> bool:
        try:
            self._master.lookupNode(self._name)
        except rosgraph.MasterException:
            return False
        return True

    def _register(self) -> None:
        uri = rospy.get_node_uri()
        own = xmlrpc.client.ServerProxy(uri)
        for name, value in self._parameters.items():
            if value is not None and not self._master.hasParam(name):
                self._master.setParam(name, value)
        for topic, message_type in _topics(own.getPublications(self._name)):
            self._master.registerPublisher(topic, message_type, uri)
        for topic, message_type in _topics(own.getSubscriptions(self._name)):
            publishers = self._master.registerSubscriber(topic, message_type, uri)
            own.publisherUpdate(self._name, topic, publishers)
        for service, service_uri in get_service_manager().get_services():
            self._master.registerService(service, service_uri, uri)

    def _warn(self, message: str) -> None:
        rospy.logwarn("%s: %s", self._name.lstrip("/"), message)


def topics_without_publisher() -> list[str]:
    """Return the topics that this node subscribes to and that have no connected publisher."""
    own, name = xmlrpc.client.ServerProxy(rospy.get_node_uri()), rospy.get_name()
    connected = {
        connection[4]
        for connection in _topics(own.getBusInfo(name))
        if connection[2] in ("i", "b") and connection[5]
    }
    topics = _topics(own.getSubscriptions(name))
    return sorted(topic for topic, _ in topics if topic not in connected)


def _topics(answer: object) -> list:
    """Return the value of an answer (code, message, value) of a node's XML-RPC interface."""
    return answer[2]  # type: ignore[index]


def watch_connections() -> None:
    """Watch the clock and the master from now on, in a thread of its own and in wall time.

    While the clock is stopped, log which topics have no publisher. Register again with a restarted
    master.
    """
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    with contextlib.suppress(OSError, rosgraph.MasterException):
        master = MasterRegistration()
        clock = ClockMonitor(CLOCK_TIMEOUT_S)
        checked_at = -math.inf
        while not rospy.core.is_shutdown_requested():
            time.sleep(_CHECK_CLOCK_EVERY_S)
            if master.uses_sim_time and clock.update(time.monotonic(), rospy.get_rostime()):
                _log_clock(clock.stopped)
            if time.monotonic() - checked_at > _CHECK_MASTER_EVERY_S:
                master.check()
                checked_at = time.monotonic()


def _log_clock(stopped: bool) -> None:
    node = rospy.get_name().lstrip("/")
    if not stopped:
        rospy.loginfo("%s: /clock continues", node)
        return
    missing = ", ".join(topics_without_publisher())
    rospy.logwarn(
        "%s: waiting for /clock, which stopped %g s ago: the simulator does not run, is paused, "
        "or waits for a command" + (f"; no publisher of {missing}" if missing else ""),
        node,
        CLOCK_TIMEOUT_S,
    )
