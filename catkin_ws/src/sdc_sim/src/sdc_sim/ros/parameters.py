"""The parameters of a node, with a mend for each that is misspelt."""

from __future__ import annotations

import difflib

import rospy

from sdc_common.ros.node import parameter, refuse


class Parameters:
    """Reads private parameters by name, and refuses those that were set but that nothing reads."""

    def __init__(self):
        self._read = set()

    def __call__(self, name: str):
        self._read.add(name)
        return parameter(name)

    def refuse_unread(self) -> None:
        """To be called when all have been read: a misspelt option would change nothing, and nobody would know."""
        for name in sorted(set(rospy.get_param("~", {})) - self._read):
            close = difflib.get_close_matches(name, self._read, n=1)
            refuse(
                f"unknown parameter {rospy.resolve_name('~' + name)}; "
                + (f"did you mean '{close[0]}'?" if close else "remove it")
            )
