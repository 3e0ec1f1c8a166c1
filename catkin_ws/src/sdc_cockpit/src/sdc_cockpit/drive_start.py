"""Before a drive starts: no other drive runs, and no parameter of the last one is in force."""

from __future__ import annotations

import contextlib
import xmlrpc.client

import rosgraph
import rospy

# Parameters of the master itself.
_KEPT = ("/roslaunch", "/run_id", "/rosdistro", "/rosversion")


def check_no_drive() -> None:
    """Raise ValueError if a simulator runs under this master."""
    # A killed node stays registered, but it does not respond.
    with contextlib.suppress(rosgraph.MasterException, OSError):
        node = xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode("/sim"))
        node.getPid(rospy.get_name())
        raise ValueError("a drive runs that this page did not start; end it first")


def clear_parameters() -> None:
    """Delete the parameters of all other nodes, so that none of the last drive is in force."""
    for name in {"/" + name.split("/")[1] for name in rospy.get_param_names()}:
        if name not in _KEPT and name != rospy.get_name():
            rospy.delete_param(name)
