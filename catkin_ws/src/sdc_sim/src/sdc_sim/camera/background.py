"""Background of the camera picture: sky and ground."""

from __future__ import annotations

import numpy as np

from sdc_sim.camera.air import Air
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground import Ground
from sdc_sim.camera.sky import Sky
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.simulation.weather import CLEAR, Weather


class Background:
    """Painter of every pixel of the picture: the sky, then the ground below the horizon.

    Attributes:
        ground: painter of the ground
    """

    def __init__(
        self,
        road: Road,
        scenery: Scenery,
        camera: CameraModel,
        seed: int = 0,
        weather: Weather = CLEAR,
    ):
        self._sky = Sky(camera, seed)
        self.ground = Ground(road, scenery, camera, seed, weather)
        self._air = Air(weather, camera, seed)

    def draw(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Paint the background for a pose of the vehicle.

        Args:
            picture: BGRA picture (height, width, 4) uint8
            x_m: position in the map [m]
            y_m: position in the map [m]
            yaw_rad: heading in the map [rad]
        """
        self._sky.draw(picture, yaw_rad)
        self.ground.draw(picture, x_m, y_m, yaw_rad, self._sky.horizon)
        self._air.veil_background(picture)
