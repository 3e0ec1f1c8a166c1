"""Private parameters of a node, with an error for each that the node does not know."""

from __future__ import annotations

from typing import Any

import rospy

from sdc_common.ros.node import parameter, refuse
from sdc_common.suggestion import suggestion


class Parameters:
    """Reads private parameters by name and refuses those that are set but not read."""

    def __init__(self) -> None:
        self._read: set[str] = set()

    def __call__(self, name: str) -> Any:
        """Return the value of a parameter; without it the node ends with an error."""
        self._read.add(name)
        return parameter(name)

    def refuse_unread(self) -> None:
        """End the node with an error if there is a parameter that was not read, as a misspelt one.

        Call it after all parameters have been read.
        """
        for name in sorted(set(rospy.get_param("~", {})) - self._read):
            hint = suggestion(name, self._read, "remove it")
            refuse(f"unknown parameter {rospy.resolve_name('~' + name)}; {hint}")
