"""Watch what a node depends on: the simulated clock and the ROS master."""

from __future__ import annotations

import threading
import time

import rosgraph
import rospy
from rospy.impl.registration import get_topic_manager

CLOCK_TIMEOUT_S = 5.0
_CHECK_CLOCK_EVERY_S = 0.5
_CHECK_MASTER_EVERY_S = 10.0


def watch_connections() -> None:
    """Watch the clock and the master from now on, in threads of their own and in wall time.

    While the clock is stopped, log which topics have no publisher. Log when the master is gone.
    """
    threading.Thread(target=_watch_clock, daemon=True).start()
    threading.Thread(target=_watch_master, daemon=True).start()


def _watch_clock() -> None:
    if rospy.rostime.is_wallclock():
        return
    node = rospy.get_name().lstrip("/")
    last, changed_at_s, stopped = rospy.get_rostime(), time.monotonic(), False
    while not rospy.core.is_shutdown_requested():
        time.sleep(_CHECK_CLOCK_EVERY_S)
        now, now_s = rospy.get_rostime(), time.monotonic()
        if now != last:
            last, changed_at_s = now, now_s
            if stopped:
                rospy.loginfo("%s: /clock continues", node)
            stopped = False
        elif not stopped and now_s - changed_at_s >= CLOCK_TIMEOUT_S:
            stopped = True
            missing = ", ".join(topics_without_publisher())
            rospy.logwarn(
                "%s: waiting for /clock, which stopped %g s ago: the simulator does not run, is "
                "paused, or waits for a command"
                + (f"; no publisher of {missing}" if missing else ""),
                node,
                CLOCK_TIMEOUT_S,
            )


def topics_without_publisher() -> list[str]:
    """Return the topics that this node subscribes to and that have no connected publisher."""
    connected = {
        topic
        for _, _, direction, _, topic, is_connected, *_ in get_topic_manager().get_pub_sub_info()
        if direction in ("i", "b") and is_connected
    }
    topics = {topic for topic, _ in get_topic_manager().get_subscriptions()}
    return sorted(topics - connected)


def _watch_master() -> None:
    master = rosgraph.Master(rospy.get_name())
    has_responded = True
    while not rospy.core.is_shutdown_requested():
        try:
            master.getPid()
            has_responded = True
        except (OSError, rosgraph.MasterException):
            if has_responded:
                rospy.logwarn(
                    "%s: no roscore responds at %s; existing connections stay",
                    rospy.get_name().lstrip("/"),
                    master.master_uri,
                )
            has_responded = False
        time.sleep(_CHECK_MASTER_EVERY_S)
