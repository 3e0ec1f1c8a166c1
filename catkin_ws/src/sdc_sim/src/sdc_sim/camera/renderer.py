"""Renderer of the front camera's picture: a road or a network, its scenery, and boxes."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from sdc_map.network import Network
from sdc_sim.camera.air import Air
from sdc_sim.camera.boxes import Box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground import Ground
from sdc_sim.camera.painting import dim
from sdc_sim.camera.scene_objects import SceneObjects
from sdc_sim.camera.sky import Sky
from sdc_sim.road.network_scenery import network_scenery
from sdc_sim.road.road import Road
from sdc_sim.simulation.weather import CLEAR, Weather


class Renderer:
    """Renderer of a road as the camera of a vehicle sees it, for one thread at a time.

    The picture depends on the arguments of `render` only. Memory does not grow with the length of
    the route: the renderer keeps fixed textures and a bounded number of tiles and buildings.
    """

    def __init__(
        self,
        road: Road | Network,
        camera: CameraModel | None = None,
        seed: int = 0,
        weather: Weather = CLEAR,
    ):
        self.camera = CameraModel() if camera is None else camera
        scenery = network_scenery(road, seed) if isinstance(road, Network) else road.scenery(seed)
        self._sky = Sky(self.camera, seed)
        self._ground = Ground(road, scenery, self.camera, seed, weather)
        self._air = Air(weather, self.camera, seed)
        self.objects = SceneObjects(scenery, self.camera, self._air, seed)

    def draw_background(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Paint every pixel of a picture: the sky, then the ground below the horizon."""
        self._sky.draw(picture, yaw_rad)
        self._ground.draw(picture, (x_m, y_m, yaw_rad), self._sky.horizon)
        self._air.veil_background(picture)

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
            boxes: what to draw, in any order
            light: brightness, from 0 (black) to 1 (day)
            out: array (height, width, 4) uint8 to render to; None for a new one
            time_s: time of the picture, in which the rain falls [s]

        Returns:
            BGRA picture (height, width, 4) uint8
        """
        picture = out
        if picture is None:
            picture = np.empty((self.camera.height, self.camera.width, 4), np.uint8)
        self.draw_background(picture, x_m, y_m, yaw_rad)
        self.objects.draw(picture, (x_m, y_m, yaw_rad), boxes, time_s)
        dim(picture, light)
        return picture
