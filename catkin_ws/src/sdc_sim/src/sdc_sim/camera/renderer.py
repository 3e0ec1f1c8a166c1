"""Draws the picture of the front camera: a road, its surroundings and boxes."""

from __future__ import annotations

import numpy as np

from sdc_sim.camera.bodies import SceneObjects
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground import Ground
from sdc_sim.camera.painting import dim
from sdc_sim.camera.sky import Sky
from sdc_sim.road.road import Road


class Backdrop:
    """Sky and ground: the part of the picture that lies behind all bodies."""

    def __init__(self, road: Road, camera_model: CameraModel, seed: int = 0):
        self._sky = Sky(camera_model, seed)
        self.ground = Ground(road, road.scenery(seed), camera_model, seed)

    def draw(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Paint over the whole picture."""
        self._sky.draw(picture, yaw_rad)
        self.ground.draw(picture, x_m, y_m, yaw_rad, self._sky.horizon)


class Renderer:
    """Draws the road, its surroundings and boxes as the camera of a vehicle sees them.

    The picture depends on the arguments of `render` only, not on what was drawn before. Memory is bounded however
    long the route: CACHED_TILES tiles of 256 kB beside fixed textures. A renderer is for one thread at a time.
    """

    def __init__(self, road: Road, camera_model: CameraModel | None = None, seed: int = 0):
        self.camera = CameraModel() if camera_model is None else camera_model
        self.backdrop = Backdrop(road, self.camera, seed)
        self.bodies = SceneObjects(road.scenery(seed), self.camera, seed)

    def render(
        self, x_m: float, y_m: float, yaw_rad: float, boxes=(), light: float = 1.0
    ) -> np.ndarray:
        """The picture (height, width, 4) uint8 BGRA, a new array, for a vehicle at that pose (metres, radians).

        `boxes`: the `Box`es to draw, in any order. `light` 0..1 scales the brightness: 1 day, 0 black.
        Raises ValueError for a pose that is not finite or a light outside 0..1.
        """
        if not np.all(np.isfinite([x_m, y_m, yaw_rad])):
            raise ValueError(f"pose ({x_m}, {y_m}, {yaw_rad}) is not finite")
        if not 0.0 <= light <= 1.0:
            raise ValueError(f"light {light} is outside 0..1")
        picture = np.empty((self.camera.height, self.camera.width, 4), np.uint8)
        self.backdrop.draw(picture, x_m, y_m, yaw_rad)
        self.bodies.draw(picture, x_m, y_m, yaw_rad, boxes)
        dim(picture, light)
        return picture
