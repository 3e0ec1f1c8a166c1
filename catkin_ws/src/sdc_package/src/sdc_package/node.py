"""What every node needs from ROS beyond rospy itself."""
from __future__ import annotations

import sys
import warnings

import rospy


def parameter(name: str):
    """The private parameter `name` of this node; without it the node ends with one line and exit code 1."""
    try:
        return rospy.get_param("~" + name)
    except KeyError:
        refuse(f"parameter {rospy.resolve_name('~' + name)} is missing; start the node with its launch file, "
               f"which loads config{rospy.get_name()}.yaml")


def refuse(message) -> None:
    """End the node with one clear line and exit code 1."""
    rospy.logfatal("%s: %s", rospy.get_name().lstrip("/"), message)
    rospy.signal_shutdown(str(message))
    sys.exit(1)


def loop_publisher(topic: str, message_class, latch: bool = False) -> rospy.Publisher:
    """A publisher for the driving loop: it writes to its subscribers in the caller's thread.

    A queue (rospy's `queue_size`) hands each message to a thread of its own, which costs about as much as the hop itself. What
    is lost is only that a subscriber which stops reading for minutes will stop the publisher, too, once the system's
    buffers are full.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)  # rospy recommends a queue
        return rospy.Publisher(topic, message_class, queue_size=None, latch=latch, tcp_nodelay=True)
