"""What every node needs from ROS beyond rospy itself."""

from __future__ import annotations

import sys
import threading
import time
import warnings

import rospy

from sdc_common.ros.connection_watchdog import watch_connections


def parameter(name: str):
    """The private parameter `name` of this node; without it the node ends with one line and exit code 1."""
    try:
        return rospy.get_param("~" + name)
    except KeyError:
        refuse(
            f"parameter {rospy.resolve_name('~' + name)} is missing; start the node with its launch file, "
            f"which loads config{rospy.get_name()}.yaml"
        )


def refuse(message) -> None:
    """End the node with one clear line and exit code 1."""
    rospy.logfatal("%s: %s", rospy.get_name().lstrip("/"), message)
    rospy.signal_shutdown(str(message))
    sys.exit(1)


class LoopPublisher(rospy.Publisher):
    """A publisher for the driving loop: it writes to its subscribers in the caller's thread.

    A queue (rospy's `queue_size`) hands each message to a thread of its own, which costs about as much as the hop itself. What
    is lost is only that a subscriber which stops reading for minutes will stop the publisher, too, once the system's
    buffers are full.
    """

    def __init__(self, topic: str, message_class, latch: bool = False):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # rospy recommends a queue
            super().__init__(topic, message_class, queue_size=None, latch=latch, tcp_nodelay=True)

    def publish(self, *args, **kwds):
        """As rospy's; a message that the end of the node has overtaken is nobody's loss."""
        try:
            super().publish(*args, **kwds)
        except rospy.ROSException:
            if not rospy.core.is_shutdown_requested():
                raise


def every(seconds: float, look) -> None:
    """From now on call `look()` each so many seconds of wall time, in a thread of its own.

    rospy's Timer wakes with each message on /clock, which in lockstep is with every tick.
    """

    def run():
        while not rospy.is_shutdown():
            time.sleep(seconds)
            look()

    threading.Thread(target=run, daemon=True).start()


def spin_beside(loop) -> None:
    """Run `loop()` in a thread of its own until it ends or the node shuts down; raises what it raised.

    Signal handlers run in the main thread: one that interrupts a publish there waits for ever for the lock that the publish
    holds, and the node has to be killed. So the main thread does nothing but wait.
    """
    failures = []

    def run():
        try:
            loop()
        except Exception as error:  # noqa: BLE001  raised again in the main thread
            failures.append(error)
        rospy.signal_shutdown("the loop has ended")

    watch_connections()
    threading.Thread(target=run, daemon=True).start()
    rospy.spin()
    if failures and not isinstance(failures[0], rospy.ROSInterruptException):
        raise failures[0]
