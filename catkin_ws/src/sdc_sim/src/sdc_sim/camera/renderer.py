"""Renderer of the front camera's picture: a road, its scenery, and boxes."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from sdc_sim.camera.background import Background
from sdc_sim.camera.boxes import Box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import dim
from sdc_sim.camera.scene_objects import SceneObjects
from sdc_sim.road.road import Road
from sdc_sim.simulation.weather import CLEAR, Weather


class Renderer:
    """Renderer of a road as the camera of a vehicle sees it, for one thread at a time.

    The picture depends on the arguments of `render` only. Memory does not grow with the length of
    the route: the renderer keeps fixed textures and a bounded number of tiles and buildings.

    Attributes:
        camera: geometry of the camera
        background: painter of sky and ground
        objects: painter of scenery and boxes
    """

    def __init__(
        self,
        road: Road,
        camera: CameraModel | None = None,
        seed: int = 0,
        weather: Weather = CLEAR,
    ):
        self.camera = CameraModel() if camera is None else camera
        scenery = road.scenery(seed)
        self.background = Background(road, scenery, self.camera, seed, weather)
        self.objects = SceneObjects(scenery, self.camera, seed, weather)

    def render(
        self,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        boxes: Sequence[Box] = (),
        light: float = 1.0,
        out: np.ndarray | None = None,
        time_s: float = 0.0,
    ) -> np.ndarray:
        """Return the picture for a pose of the vehicle.

        Args:
            x_m: position in the map [m]
            y_m: position in the map [m]
            yaw_rad: heading in the map [rad]
            boxes: the boxes to draw, in any order
            light: brightness, from 0 (black) to 1 (day)
            out: array (height, width, 4) uint8 to render to; None for a new one
            time_s: time of the picture, in which the rain falls [s]

        Returns:
            BGRA picture (height, width, 4) uint8

        Raises:
            ValueError: the pose is not finite, or the light is outside 0..1
        """
        if not np.all(np.isfinite([x_m, y_m, yaw_rad])):
            raise ValueError(
                f"render: x_m, y_m and yaw_rad must be finite, got {(x_m, y_m, yaw_rad)}"
            )
        if not 0.0 <= light <= 1.0:
            raise ValueError(f"render: light must be in 0..1, got {light}")
        picture = out
        if picture is None:
            picture = np.empty((self.camera.height, self.camera.width, 4), np.uint8)
        self.background.draw(picture, x_m, y_m, yaw_rad)
        self.objects.draw(picture, x_m, y_m, yaw_rad, boxes, time_s)
        dim(picture, light)
        return picture
