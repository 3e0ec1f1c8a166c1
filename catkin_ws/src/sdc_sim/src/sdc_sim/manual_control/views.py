"""The views of the manual control: camera pictures from topics, and the map."""

from __future__ import annotations

from typing import Iterable

import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image

from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.map_view import MapView


class ViewSelector:
    """Cycles through the pictures of topics and a map. Messages may arrive in any thread.

    Args:
        topics: names of sensor_msgs/Image topics
        map_view: draws the map

    Attributes:
        selected: name of the topic whose picture is shown, or MAP
    """

    MAP = "map"

    def __init__(self, topics: Iterable[str], map_view: MapView):
        self.map_view = map_view
        self._views = [*topics, self.MAP]
        self.selected = self._views[0]
        self._messages: dict[str, Image] = {}
        self._bridge = CvBridge()

    def on_picture(self, message: Image, topic: str) -> None:
        """Store the newest picture of a topic."""
        self._messages[topic] = message

    def select_next(self) -> None:
        """Select the next view."""
        self.selected = self._views[(self._views.index(self.selected) + 1) % len(self._views)]

    def picture(self, state: DriveState) -> np.ndarray | None:
        """Return the selected view as (H, W, 3) BGR uint8, or None if nothing arrived yet.

        Raises:
            ValueError: the picture of the topic is not valid.
        """
        if self.selected == self.MAP:
            if state.pose is None:
                return None
            return self.map_view.picture(*state.pose, state.path, state.obstacles)
        message = self._messages.get(self.selected)
        if message is None:
            return None
        try:
            picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
        except (CvBridgeError, TypeError) as error:
            raise ValueError(f"the picture on {self.selected} is not valid: {error}") from error
        if 0 in picture.shape:
            raise ValueError(f"the picture on {self.selected} is empty")
        return picture
