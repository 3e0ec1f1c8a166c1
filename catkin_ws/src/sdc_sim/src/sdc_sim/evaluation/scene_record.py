"""What was around the car during a drive, for the page of its report."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

PATH, OBSTACLES, LIGHTS, PICTURE = "path", "obstacles", "lights", "picture"
INTERVAL_S = 0.5


class SceneRecord:
    """Entries (time [s], content) of each kind, in the order in which they were received.

    The content of a path is rows of x, y [m] and target speed [m/s]; that of obstacles is rows of
    id, x, y [m], yaw [rad], length and width [m]; that of lights is their states by id; that of a
    picture is a JPEG in base64.

    Attributes:
        entries: entries by kind
    """

    def __init__(self, keep: bool):
        """Create an empty record; without `keep`, it stores only the last entry of each kind."""
        self.entries: dict[str, list] = defaultdict(list)
        self._keep = keep

    def is_due(self, kind: str, time_s: float) -> bool:
        """Return whether the last entry of a kind is older than the interval."""
        entries = self.entries[kind]
        return not entries or not 0.0 <= time_s - entries[-1][0] < INTERVAL_S

    def add(self, kind: str, time_s: float, content: Any) -> None:
        """Add an entry."""
        entries = self.entries[kind]
        if not self._keep:
            entries.clear()
        entries.append((time_s, content))

    def is_new(self, kind: str, content: Any) -> bool:
        """Return whether the content differs from that of the last entry of its kind."""
        entries = self.entries[kind]
        return not entries or entries[-1][1] != content
