"""The connected pages. Each message is built once and shared; a slow page misses some."""

from __future__ import annotations

import itertools
from typing import Any

from sdc_cockpit.protocol import CAMERA, picture_message

# Pictures on their way to a page that it has not drawn yet. Each one more makes a slow page later;
# with one, a page that is 100 ms away would get half of the pictures.
MAX_UNDRAWN = 3


class Viewer:
    """One page.

    Args:
        number: identifies it
        connection: has `write_message(data, binary)`, which returns a future that is done when the
            data are in the buffers of the system
    """

    def __init__(self, number: int, connection: Any):
        self.number = number
        self.shows_mask = False
        self._connection = connection
        self._writing: Any = None
        self._undrawn: list[int] = []

    @property
    def ready(self) -> bool:
        """Return whether the last message has left the server."""
        return self._writing is None or self._writing.done()

    @property
    def ready_for_picture(self) -> bool:
        """Return whether the page keeps up with drawing."""
        return self.ready and len(self._undrawn) < MAX_UNDRAWN

    def send(self, message: bytes, binary: bool = False) -> None:
        """Send a message now."""
        self._writing = self._connection.write_message(message, binary=binary)

    def send_picture(self, number: int, message: bytes) -> None:
        """Send a camera picture now."""
        self._undrawn.append(number)
        self.send(message, binary=True)

    def drawn(self, number: int) -> None:
        """Count a picture, and all before it, as drawn."""
        self._undrawn = [picture for picture in self._undrawn if picture > number]


class Viewers:
    """All connected pages. Use it in the server's thread; only `wanted` may be called elsewhere."""

    def __init__(self) -> None:
        self._viewers: dict[int, Viewer] = {}
        self._numbers = itertools.count(1)
        self._pictures = itertools.count(1)

    def __len__(self) -> int:
        return len(self._viewers)

    def add(self, connection: Any) -> Viewer:
        """Add a page."""
        viewer = Viewer(next(self._numbers), connection)
        self._viewers[viewer.number] = viewer
        return viewer

    def remove(self, viewer: Viewer) -> None:
        """Remove a page."""
        self._viewers.pop(viewer.number, None)

    def wanted(self, kind: int) -> bool:
        """Return whether a page would get a picture of this kind now."""
        return any(self._gets(viewer, kind) for viewer in tuple(self._viewers.values()))

    def _gets(self, viewer: Viewer, kind: int) -> bool:
        return viewer.ready_for_picture if kind == CAMERA else viewer.shows_mask and viewer.ready

    @property
    def shows_mask(self) -> bool:
        """Return whether a page shows the lane mask."""
        return any(viewer.shows_mask for viewer in self._viewers.values())

    def broadcast(self, message: bytes, always: bool = False) -> None:
        """Send a text to all pages that are ready for it, or, `always`, to all."""
        for viewer in list(self._viewers.values()):
            if always or viewer.ready:
                viewer.send(message)

    def broadcast_picture(self, kind: int, stamp_s: float, wall_s: float, file: bytes) -> None:
        """Send a picture to all pages that are ready for it."""
        number = next(self._pictures)
        message = picture_message(kind, number, stamp_s, wall_s, file)
        for viewer in list(self._viewers.values()):
            if not self._gets(viewer, kind):
                continue
            if kind == CAMERA:
                viewer.send_picture(number, message)
            else:
                viewer.send(message, binary=True)
