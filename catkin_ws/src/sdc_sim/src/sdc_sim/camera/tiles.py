"""Tiles of the ground: textures, road and shadows, rasterized when they are first needed."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from sdc_map.network import Network
from sdc_sim.camera.air import worn_paint
from sdc_sim.camera.ground_shadows import GroundShadows
from sdc_sim.camera.ground_textures import FINEST_TEXEL_M, LEVELS, TILE_PX, ground_textures
from sdc_sim.camera.network_rasterizer import NetworkRasterizer
from sdc_sim.camera.road_rasterizer import ASPHALT, RoadRasterizer
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.simulation.weather import Weather

CACHED_TILES = 96


class GroundTiles:
    """Square tiles of the map at LEVELS resolutions; the last CACHED_TILES are kept.

    A tile depends on its place only, so that a picture does not depend on the pictures before.
    """

    def __init__(self, road: Road | Network, scenery: Scenery, seed: int, weather: Weather):
        self._textures = [ground_textures(level, seed) for level in range(LEVELS)]
        self._road: NetworkRasterizer | RoadRasterizer
        if isinstance(road, Network):
            self._road = NetworkRasterizer(road)
        else:
            self._road = RoadRasterizer(road)
        self._shadows = GroundShadows(scenery, seed, weather) if len(scenery) else None
        self._wear = [worn_paint(weather, seed, level, 2 * TILE_PX) for level in range(LEVELS)]
        self.tile = lru_cache(CACHED_TILES)(self._rasterize)

    def _rasterize(self, level: int, column: int, row: int) -> np.ndarray:
        """Return the tile (TILE_PX, TILE_PX, 4) BGRA of a column along x and a row along y."""
        size_m = FINEST_TEXEL_M * 2**level * TILE_PX
        origin_m = np.array([column, row]) * size_m
        part = np.s_[
            row % 2 * TILE_PX : (row % 2 + 1) * TILE_PX,
            column % 2 * TILE_PX : (column % 2 + 1) * TILE_PX,
        ]
        grass, asphalt = (texture[part] for texture in self._textures[level])
        weights = self._road.weights(level, origin_m, size_m)
        shade = self._shadows.shade(level, origin_m, size_m) if self._shadows else None
        if weights is None:
            return grass if shade is None else _scaled(grass, shade)
        wear = self._wear[level]
        if wear is not None:
            weights = _worn(weights[0], wear[part]), weights[1]
        if shade is not None:
            paved, green = (cv2.multiply(plane, shade, scale=1.0 / 255.0) for plane in weights)
        else:
            paved, green = weights
        return cv2.add(_scaled(asphalt, paved, ASPHALT * 255.0), _scaled(grass, green))


def _worn(paved: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the brightness of pavement where a share, 0..255, of all paint is left."""
    asphalt = round(ASPHALT * 255.0)
    paint = cv2.multiply(cv2.subtract(paved, asphalt), left, scale=1.0 / 255.0)
    return cv2.add(cv2.min(paved, asphalt), paint)


def _scaled(texture: np.ndarray, plane: np.ndarray, full: float = 255.0) -> np.ndarray:
    """Return a BGRA texture multiplied by a plane, whose value `full` leaves it as it is."""
    return cv2.multiply(texture, cv2.cvtColor(plane, cv2.COLOR_GRAY2BGRA), scale=1.0 / full)
