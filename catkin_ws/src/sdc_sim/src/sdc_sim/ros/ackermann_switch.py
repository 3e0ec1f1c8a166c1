"""Whether the simulator itself serves ackermann_cmd."""

from __future__ import annotations

import time

import rosgraph
import rospy

_CHECK_PERIOD_S = 1.0


class AckermannSwitch:
    """Switches the simulator's Ackermann control off while another node has it.

    Such a node, as carla_ackermann_control of the CARLA bridge, subscribes to the targets and
    publishes control commands. Two controllers with the same target would command in turn.

    Args:
        mode: True: always on; False: always off; "auto": off while there is such a node
        targets: name of the topic of Ackermann targets
        commands: name of the topic of control commands
    """

    def __init__(self, mode: str | bool, targets: str, commands: str):
        self._mode = mode
        self._targets = targets
        self._commands = commands
        self._other: str | None = None
        self._next_check_s = 0.0

    @property
    def subscribes(self) -> bool:
        """Whether the simulator needs the targets at all."""
        return self._mode is not False

    def is_on(self) -> bool:
        """Return whether to obey a target now; at intervals, ask the ROS master."""
        if self._mode == "auto" and time.monotonic() >= self._next_check_s:
            self._next_check_s = time.monotonic() + _CHECK_PERIOD_S
            self._check()
        return self._other is None

    def _check(self) -> None:
        try:
            publishers, subscribers, _ = rosgraph.Master(rospy.get_name()).getSystemState()
        except (OSError, rosgraph.MasterException):
            return
        nodes = set(dict(publishers).get(self._commands, ()))
        nodes &= set(dict(subscribers).get(self._targets, ()))
        other = min(nodes - {rospy.get_name()}, default=None)
        if other == self._other:
            return
        self._other = other
        if other:
            rospy.logwarn(
                f"sim: {other} turns {self._targets} into {self._commands}; the sim leaves it to "
                "that node (parameter ackermann_cmd)"
            )
        else:
            rospy.loginfo(f"sim: serves {self._targets} again")
