"""The views of the hand control: pictures of topics, and the map."""

from __future__ import annotations

import numpy as np
from cv_bridge import CvBridge, CvBridgeError

from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.map_view import MapView


class ViewSelector:
    """Cycles through the pictures of some topics and a map. Messages may come from other threads than the one that looks.

    topics: names of sensor_msgs/Image topics.
    """

    MAP = "map"

    def __init__(self, topics, map_view: MapView):
        self.views = [*topics, self.MAP]
        self.map_view = map_view
        self.shown = self.views[0]
        self._messages = {}
        self._bridge = CvBridge()

    def take(self, message, topic: str) -> None:
        """Keep the newest picture of a topic."""
        self._messages[topic] = message

    def next(self) -> None:
        """Show the next view."""
        self.shown = self.views[(self.views.index(self.shown) + 1) % len(self.views)]

    def picture(self, facts: DriveState) -> np.ndarray | None:
        """The view as (H, W, 3) BGR uint8, or None where nothing is known yet. Raises ValueError for a picture that is none."""
        if self.shown == self.MAP:
            return (
                self.map_view.picture(*facts.pose, facts.path, facts.obstacles)
                if facts.pose
                else None
            )
        message = self._messages.get(self.shown)
        if message is None:
            return None
        try:
            picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
        except (CvBridgeError, TypeError) as error:
            raise ValueError(f"a picture on {self.shown} is none: {error}") from error
        if 0 in picture.shape:
            raise ValueError(f"a picture on {self.shown} is empty")
        return picture
