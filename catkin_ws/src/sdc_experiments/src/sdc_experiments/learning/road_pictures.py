"""Pictures of the front camera on one road."""

from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road


class RoadPictures:
    """Draws what the camera sees on the road along (N, 2) waypoints [m]."""

    def __init__(self, waypoints_m: np.ndarray, camera: CameraModel):
        self._renderer = Renderer(Road(waypoints_m), camera)
        self._bgra = np.empty((camera.height, camera.width, 4), np.uint8)

    def draw(
        self, x_m: float, y_m: float, yaw_rad: float, boxes: Sequence = (), daylight: float = 1.0
    ) -> np.ndarray:
        """Return the picture (height, width, 3) RGB from a pose of the car, with boxes on the road.

        Args:
            x_m: position in the map [m]
            y_m: position in the map [m]
            yaw_rad: heading [rad]
            boxes: see Renderer.render
            daylight: brightness, 0 to 1
        """
        self._renderer.render(x_m, y_m, yaw_rad, boxes, daylight, out=self._bgra)
        return cv2.cvtColor(self._bgra, cv2.COLOR_BGRA2RGB)
