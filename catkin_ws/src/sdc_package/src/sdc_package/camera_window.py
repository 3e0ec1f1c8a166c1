"""The window of the camera node, which shows the camera picture or the lane mask."""

from __future__ import annotations

import threading

import numpy as np
import rospy

TITLE = "camera: F shows or hides the lane filter, Q closes"


class CameraWindow:
    """A window with the latest picture or its lane mask; F switches between them, Q closes it.

    The node's callbacks call `update`; its main thread calls `run`, because only one thread may use
    a window.

    Args:
        enabled: whether to open a window at all
        show_mask: whether the window shows the lane mask first
    """

    def __init__(self, enabled: bool, show_mask: bool):
        self._enabled, self._show_mask = enabled, show_mask
        self._lock = threading.Lock()
        self._picture: np.ndarray | None = None

    @property
    def picture(self) -> np.ndarray | None:
        """Return what the window shows, (H, W, 3) uint8 BGR, or None before the first picture."""
        with self._lock:
            return self._picture

    def update(self, image: np.ndarray, mask: np.ndarray) -> None:
        """Set what the window shows.

        Args:
            image: camera picture, (H, W, 3 or more) uint8, BGR first
            mask: lane mask of the same size, (H, W) uint8
        """
        if self._enabled:
            with self._lock:
                self._picture = np.dstack([mask] * 3) if self._show_mask else image[:, :, :3]

    def press(self, key: str) -> bool:
        """Handle a key; return whether the window stays open."""
        if key == "f":
            self._show_mask = not self._show_mask
        return key != "q"

    def run(self) -> None:
        """Show pictures until the window or the node is closed; return at once without a window."""
        if not self._enabled:
            return
        # Imported here, because a machine without a display needs no window library.
        from sdc_common.window import ImageWindow, NoDisplay

        try:
            window = ImageWindow(TITLE)
        except NoDisplay as error:
            rospy.logwarn("camera: %s; continuing without a window", error)
        else:
            while not rospy.is_shutdown() and not window.closed:
                if not all(map(self.press, window.show(self.picture))):
                    window.close()
            window.close()
        self._enabled = False
