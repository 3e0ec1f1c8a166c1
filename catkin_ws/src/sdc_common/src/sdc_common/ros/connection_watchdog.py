"""Watches, beside a node, what it depends on: the world's clock and the ROS master."""

from __future__ import annotations

import contextlib
import math
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
from rospy.impl.registration import get_service_manager

CLOCK_PATIENCE_S = 5.0
_LOOK_EVERY_S = 0.5
_ASK_MASTER_EVERY_S = 10.0


class ClockWatch:
    """Tells once each time simulated time stops or comes back. Times are numbers given to it: wall clock in seconds."""

    def __init__(self, patience_s: float, wall_s: float):
        self._patience_s = patience_s
        self._moved_at_s = wall_s
        self._last = None
        self.stands = False

    def look(self, wall_s: float, sim_time) -> bool:
        """Take the present times; returns whether `stands` has changed."""
        if sim_time != self._last:
            self._last = sim_time
            self._moved_at_s = wall_s
        stands = wall_s - self._moved_at_s >= self._patience_s
        changed = stands != self.stands
        self.stands = stands
        return changed


class Master:
    """Registers this node again when the roscore has been started anew.

    In ROS 1 nodes talk to each other without the master, so what is connected drives on while it is gone. But a new one knows
    nobody: whoever comes later finds no one, and what roslaunch had set as parameters is lost. So each node tells the new one
    again what it publishes, hears and serves, and the parameters that are its own.
    """

    def __init__(self):
        self.name = rospy.get_name()
        self.master = rosgraph.Master(self.name)
        self.parameters = {
            "/use_sim_time": rospy.get_param("/use_sim_time", False),
            self.name: rospy.get_param(self.name, None),
        }
        self.gone = False

    def look(self) -> None:
        """Ask the master whether it knows this node."""
        try:
            self.master.lookupNode(self.name)
        except rosgraph.MasterException:
            if rospy.core.is_shutdown_requested():
                return
            with contextlib.suppress(OSError, rosgraph.MasterException):
                self.register_again()
                rospy.logwarn(
                    "%s: the roscore was started anew; registered with it again",
                    self.name.lstrip("/"),
                )
        except OSError:
            if not self.gone and not rospy.core.is_shutdown_requested():
                rospy.logwarn(
                    "%s: no roscore answers at %s; what is connected goes on",
                    self.name.lstrip("/"),
                    self.master.master_uri,
                )
            self.gone = True
            return
        self.gone = False

    def register_again(self) -> None:
        """Tell a master that has forgotten it all that this node told the one before."""
        uri = rospy.get_node_uri()
        own = xmlrpc.client.ServerProxy(uri)
        for name, value in self.parameters.items():
            if value is not None and not self.master.hasParam(name):
                self.master.setParam(name, value)
        for topic, message_type in own.getPublications(self.name)[2]:
            self.master.registerPublisher(topic, message_type, uri)
        for topic, message_type in own.getSubscriptions(self.name)[2]:
            own.publisherUpdate(
                self.name, topic, self.master.registerSubscriber(topic, message_type, uri)
            )
        for service, service_uri in get_service_manager().get_services():
            self.master.registerService(service, service_uri, uri)


def unconnected_topics() -> list:
    """The topics that this node listens to and that nobody publishes to it."""
    own, name = xmlrpc.client.ServerProxy(rospy.get_node_uri()), rospy.get_name()
    connected = {
        connection[4]
        for connection in own.getBusInfo(name)[2]
        if connection[2] in ("i", "b") and connection[5]
    }
    return sorted(topic for topic, _ in own.getSubscriptions(name)[2] if topic not in connected)


def watch_connections() -> None:
    """From now on say what this node waits for when the clock stands, and register again with a new master.

    All of it happens on the wall clock and in a thread of its own, so that it works where no time passes.
    """
    threading.Thread(target=_watch, daemon=True).start()


def _watch():
    node = rospy.get_name().lstrip("/")
    with contextlib.suppress(OSError, rosgraph.MasterException):
        master = Master()
        clock = ClockWatch(CLOCK_PATIENCE_S, time.monotonic())
        asked_at = -math.inf
        while not rospy.core.is_shutdown_requested():
            time.sleep(_LOOK_EVERY_S)
            if master.parameters["/use_sim_time"] and clock.look(
                time.monotonic(), rospy.get_rostime()
            ):
                if clock.stands:
                    unheard = ", ".join(unconnected_topics())
                    rospy.logwarn(
                        "%s: waiting for /clock, which has stood for %g s: no world runs, it is paused, or it waits for a command"
                        + ("; nobody publishes " + unheard if unheard else ""),
                        node,
                        CLOCK_PATIENCE_S,
                    )
                else:
                    rospy.loginfo("%s: /clock runs", node)
            if time.monotonic() - asked_at > _ASK_MASTER_EVERY_S:
                master.look()
                asked_at = time.monotonic()
