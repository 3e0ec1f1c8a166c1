"""Watch what a node depends on: the simulated clock and the ROS master."""

from __future__ import annotations

import contextlib
import math
import threading
import time
import xmlrpc.client

import rosgraph
import rospy

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

    While the clock is stopped, log which topics have no publisher. Log when the master is gone.
    """
    threading.Thread(target=_watch, daemon=True).start()


def _watch() -> None:
    with contextlib.suppress(OSError, rosgraph.MasterException):
        uses_sim_time = rospy.get_param("/use_sim_time", False)
        clock = ClockMonitor(CLOCK_TIMEOUT_S)
        has_master, check_at_s = True, 0.0
        while not rospy.core.is_shutdown_requested():
            time.sleep(_CHECK_CLOCK_EVERY_S)
            now_s = time.monotonic()
            if uses_sim_time and clock.update(now_s, rospy.get_rostime()):
                _log_clock(clock.stopped)
            if now_s >= check_at_s:
                check_at_s = now_s + _CHECK_MASTER_EVERY_S
                has_master = _check_master(has_master)


def _check_master(had_master: bool) -> bool:
    """Return whether the ROS master responds; log once when it no longer does."""
    master = rosgraph.Master(rospy.get_name())
    try:
        master.getPid()
    except OSError:
        if had_master:
            rospy.logwarn(
                "%s: no roscore responds at %s; existing connections stay",
                rospy.get_name().lstrip("/"),
                master.master_uri,
            )
        return False
    return True


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
