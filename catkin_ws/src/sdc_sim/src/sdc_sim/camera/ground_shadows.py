"""Shadows of trees and buildings on the tiles of the ground."""

from __future__ import annotations

import cv2
import numpy as np

from sdc_sim.camera.ground_textures import TILE_PX
from sdc_sim.camera.painting import FIXED_POINT_BITS, footprint, shadow_hull, touching
from sdc_sim.camera.road_rasterizer import fixed_point
from sdc_sim.road.scenery import TREE, Scenery
from sdc_sim.simulation.weather import Weather

_CROWN_CORNERS = 18


class GroundShadows:
    """Outlines of the shadows of the scenery, at least one object."""

    def __init__(self, scenery: Scenery, seed: int, weather: Weather):
        self._scenery = scenery
        self._weather = weather
        shadow = weather.shadow_m_per_m
        # Half the length of the shadow of a round crown, as a share of the tree's height.
        self._stretch = 0.42 if not weather.low_sun else 0.30 * float(np.hypot(*shadow))
        position, height = scenery.position_m, scenery.size_m[:, 2:]
        middle = position + 0.62 * height * shadow
        crowns = self._crowns(middle, seed)
        trunks = np.stack([position - 0.15, position + 0.15, middle + 0.15, middle - 0.15], axis=1)
        self._outlines = [
            [crown, trunk] if kind == TREE else [self._building_shadow(item)]
            for item, (kind, crown, trunk) in enumerate(zip(scenery.kind, crowns, trunks))
        ]
        reach = (0.6 * np.max(scenery.size_m, axis=1) + 1.0)[:, None]
        tip = position + height * shadow
        self._low = np.minimum(position, tip) - reach
        self._high = np.maximum(position, tip) + reach

    def _crowns(self, middle: np.ndarray, seed: int) -> np.ndarray:
        """Return the shadows (N, _CROWN_CORNERS, 2) of treetops around `middle` (N, 2) [m]."""
        angle = np.linspace(0.0, 2.0 * np.pi, _CROWN_CORNERS, endpoint=False)
        wobble = np.random.RandomState(seed + 3).uniform(0.85, 1.12, (256, _CROWN_CORNERS))
        shadow = self._weather.shadow_m_per_m
        away = shadow / np.hypot(*shadow)
        across = [-away[1], away[0]]
        ring = (
            self._stretch * np.cos(angle)[:, None] * away + 0.30 * np.sin(angle)[:, None] * across
        )
        height = self._scenery.size_m[:, 2:]
        return middle[:, None] + height[..., None] * wobble[self._scenery.variant][..., None] * ring

    def _building_shadow(self, item: int) -> np.ndarray:
        size = self._scenery.size_m[item]
        base = footprint((0.0, 0.0), self._scenery.yaw_rad[item], size)
        return self._scenery.position_m[item] + shadow_hull(
            base, size[2], self._weather.shadow_m_per_m
        )

    def shade(self, level: int, origin_m: np.ndarray, size_m: float) -> np.ndarray | None:
        """Return the brightness of the ground of a tile; see RoadRasterizer.weights.

        Returns:
            brightness (TILE_PX, TILE_PX) uint8, or None if no shadow falls on the tile
        """
        near = touching(self._low, self._high, origin_m, origin_m + size_m)
        if len(near) == 0:
            return None
        shade = np.full((TILE_PX, TILE_PX), 255, np.uint8)
        scale = TILE_PX / size_m
        for item in near.tolist():
            for outline in self._outlines[item]:
                cv2.fillPoly(
                    shade,
                    [fixed_point((outline - origin_m) * scale)],
                    (int(255 * self._weather.shade),),
                    cv2.LINE_AA,
                    FIXED_POINT_BITS,
                )
        if int(shade.min()) == 255:
            return None
        return cv2.blur(shade, (5, 5)) if level < 2 and not self._weather.low_sun else shade
