"""What every node needs from ROS beyond rospy itself."""
from __future__ import annotations

import sys

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
