"""The nodes of the ROS graph with the rates of their topics, and the log."""

from __future__ import annotations

import collections
import threading
from typing import Any

import rosgraph
from rosgraph_msgs.msg import Log

_REMEMBERED_LINES = 300
_MAX_CHARACTERS = 400
_LEVELS = {Log.DEBUG: "debug", Log.INFO: "info", Log.WARN: "warn", Log.ERROR: "error"}
# rospy writes it as information whenever a node that ends closes its connections.
_CLOSED_CONNECTION = "Inbound TCP/IP connection failed"


class LogLines:
    """The last lines of the log. `add` may be called in any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lines: collections.deque = collections.deque(maxlen=_REMEMBERED_LINES)
        self._new: list[dict[str, str]] = []

    def add(self, message: Any) -> None:
        """Add a rosgraph_msgs/Log."""
        level, text = _LEVELS.get(message.level, "fatal"), message.msg[:_MAX_CHARACTERS]
        if text.startswith(_CLOSED_CONNECTION):
            level = "debug"
        line = {"level": level, "node": message.name.lstrip("/"), "text": text}
        with self._lock:
            self._lines.append(line)
            self._new = [*self._new, line][-_REMEMBERED_LINES:]

    def all(self) -> list[dict[str, str]]:
        """Return all lines."""
        with self._lock:
            return list(self._lines)

    def take_new(self) -> list[dict[str, str]]:
        """Return the lines since the last call."""
        with self._lock:
            new, self._new = self._new, []
            return new


def node_rows(master: rosgraph.Master, rates: dict[str, float]) -> list[dict[str, Any]]:
    """Return each node with those of its published topics whose rate [1/s] is known.

    Raises:
        OSError: the master does not respond
        rosgraph.MasterException: the master refuses the request
    """
    publishers, subscribers, services = master.getSystemState()
    topics: dict[str, dict[str, float]] = {
        node: {}
        for rows in (publishers, subscribers, services)
        for _, nodes in rows
        for node in nodes
    }
    for topic, nodes in publishers:
        for node in nodes:
            if topic in rates:
                topics[node][topic] = round(rates[topic], 1)
    return [
        {"node": node.lstrip("/"), "topics": sorted(rows.items())}
        for node, rows in sorted(topics.items())
    ]
