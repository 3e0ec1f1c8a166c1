"""Parameters, publishers, threads and connections of nodes, in addition to rospy."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
import warnings
import xmlrpc.client
from collections.abc import Callable
from typing import Any, NoReturn

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager
from std_srvs.srv import Trigger

_CHECK_EVERY_S = 5.0
# Whether the drive has ended: the referee writes its report, and the clock stops.
ENDED_PARAMETER = "/referee/drive_ended"
_WATCH = ("/referee", "/record", "/cockpit", "/show")  # nodes that only watch a drive


def parameter(name: str) -> Any:
    """Return the private parameter `name`; end the node with exit code 1 if it is missing."""
    try:
        return rospy.get_param("~" + name)
    except KeyError:
        refuse(
            f"parameter {rospy.resolve_name('~' + name)} is missing; "
            f"start the node with its launch file, which loads config{rospy.get_name()}.yaml"
        )


def refuse(message: object) -> NoReturn:
    """Log one line, and end the node with exit code 1 and the launch that started it."""
    rospy.logfatal("%s: %s", rospy.get_name().lstrip("/"), message)
    _end_launch()
    rospy.signal_shutdown(str(message))
    sys.exit(1)


def _end_launch() -> None:
    """Interrupt the roslaunch that started this node: with `respawn` it would start it forever."""
    with contextlib.suppress(OSError, xmlrpc.client.Error, rosgraph.MasterException):
        for uri in rospy.get_param("/roslaunch/uris", {}).values():
            answer: Any = xmlrpc.client.ServerProxy(uri).get_pid()
            if answer[2] == os.getppid():
                os.kill(os.getppid(), signal.SIGINT)


class LoopPublisher(rospy.Publisher, rospy.SubscribeListener):
    """A publisher for the driving loop: it writes to its subscribers in the caller's thread.

    With a queue (rospy's `queue_size`), another thread sends each message, which about doubles the
    latency. Without one, a subscriber that stops reading for minutes blocks the publisher when the
    system's buffers are full. The newest one, in a drive the planner, is served first.
    """

    def __init__(self, topic: str, message_class: type, latch: bool = False):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # rospy recommends a queue
            super().__init__(topic, message_class, queue_size=None, latch=latch, tcp_nodelay=True)
        self.impl.add_subscriber_listener(self)

    def peer_subscribe(self, *_: Any) -> None:
        """Sort the connections, those that only watch last; rospy calls this for a new one."""
        with self.impl.c_lock:
            newest = self.impl.connections[::-1]
            newest.sort(key=lambda connection: connection.endpoint_id.endswith(_WATCH))
            self.impl.connections = newest

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message as rospy does; while the node shuts down, drop it."""
        try:
            super().publish(*args, **kwds)
        except rospy.ROSException:
            if not rospy.core.is_shutdown_requested():
                raise


def every(seconds: float, function: Callable[[], object]) -> None:
    """Call a function periodically in a thread, in wall time; without a master it has no effect.

    rospy's Timer wakes up for each message on /clock, which is once a tick in lockstep.
    """

    def run() -> None:
        while not rospy.is_shutdown():
            time.sleep(seconds)
            with contextlib.suppress(OSError, rosgraph.MasterException):
                function()

    threading.Thread(target=run, daemon=True).start()


def watch_connections() -> None:
    """Log when the simulated clock has stopped or the master is gone, until the drive has ended."""
    master = rosgraph.Master(rospy.get_name())
    last_time, has_run = rospy.get_rostime(), False
    logged: set[str] = set()

    def check() -> None:
        nonlocal last_time, has_run, logged
        problems, ros_time = set(), rospy.get_rostime()
        has_run |= ros_time != last_time and not last_time.is_zero()
        # At its first tick, the simulator waits for nodes, and logs for which.
        if ros_time == last_time and (has_run or ros_time.is_zero()):
            problems.add(
                f"waiting for /clock, which has stopped for {_CHECK_EVERY_S:g} s: the simulator "
                f"does not run, is paused, or waits for a command{_missing_publishers()}"
            )
        try:
            master.getPid()
        except (OSError, rosgraph.MasterException):
            problems.add(f"no roscore responds at {master.master_uri}; existing connections stay")
        if problems and _drive_has_ended():
            return
        for problem in problems - logged:
            rospy.logwarn("%s: %s", rospy.get_name().lstrip("/"), problem)
        last_time, logged = ros_time, problems

    every(_CHECK_EVERY_S, check)


def _drive_has_ended() -> bool:
    with contextlib.suppress(OSError, rosgraph.MasterException):
        return rospy.get_param(ENDED_PARAMETER, False)
    return False


def _missing_publishers() -> str:
    """Name the topics that this node subscribes to and that have no connected publisher."""
    connections = get_topic_manager().get_pub_sub_info()
    connected = {topic for _, _, way, _, topic, is_up, *_ in connections if way != "o" and is_up}
    topics = sorted({topic for topic, _ in get_topic_manager().get_subscriptions()} - connected)
    return f"; no publisher of {', '.join(topics)}" if topics else ""


def offer_reload(load: Callable[[], object]) -> None:
    """Offer the service ~reload (std_srvs/Trigger), which calls `load` to read parameters again.

    Args:
        load: reads the parameters and uses them from then on; it raises TypeError or ValueError for
            a bad one, and then changes nothing
    """

    def reload(_request: object) -> tuple[bool, str]:
        try:
            load()
        except (TypeError, ValueError) as error:
            return False, str(error)
        return True, "the parameters are in use"

    rospy.Service("~reload", Trigger, reload)


def spin_with(loop: Callable[[], object]) -> None:
    """Run a loop in a thread until it returns or the node shuts down; raise what it raised.

    Signal handlers run in the main thread. One that interrupts `publish` there waits forever for
    the lock that `publish` holds. So the main thread only spins.
    """
    failures = []

    def run() -> None:
        try:
            loop()
        except Exception as error:  # noqa: BLE001  raised again in the main thread
            # At the shutdown rospy ends waits, and closes topics while the loop still publishes.
            if not (rospy.core.is_shutdown_requested() and isinstance(error, rospy.ROSException)):
                failures.append(error)
        rospy.signal_shutdown("the loop has ended")

    watch_connections()
    threading.Thread(target=run, daemon=True).start()
    rospy.spin()
    if failures:
        raise failures[0]
