"""Trees of the camera picture: sprites that always face the camera."""

from __future__ import annotations

import math

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import blend, halve
from sdc_sim.road.scenery import CROWN_CENTRE_SHARE, TRUNK_RADIUS_SHARE, Scenery
from sdc_sim.simulation.weather import Weather

TREE_RANGE_M = 120.0
# A tree becomes transparent over so much before the end of its range.
_FADE_M = 30.0
_SPRITES = 4
_SPRITE_PX = (256, 192)


class TreePainter:
    """Painter of the trees of the scenery."""

    def __init__(self, scenery: Scenery, camera: CameraModel, seed: int, weather: Weather):
        self._weather = weather
        self._scenery = scenery
        self._camera = camera
        self._focal = camera.focal_px
        self._sprites = [_pyramid(_tree_sprite(seed + 17 * k)) for k in range(_SPRITES)]

    def draw(self, picture: np.ndarray, item: int, ahead_m: float, aside_m: float) -> None:
        """Paint a tree, an item of the scenery, so far ahead of the camera and to its left."""
        camera = self._camera
        height_m = float(self._scenery.size_m[item, 2])
        variant = int(self._scenery.variant[item])
        c, s = math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
        depth = ahead_m * c + camera.mount_z_m * s
        scale = self._focal / depth
        foot_u = camera.width / 2.0 - aside_m * scale
        foot_v = camera.height / 2.0 + scale * (camera.mount_z_m * c - ahead_m * s)
        high = height_m * scale
        sprite = self._sprite(variant, high)
        per_px = sprite.shape[0] / high
        wide = sprite.shape[1] / per_px
        flip = -per_px if variant & 4 else per_px
        u0 = max(0, math.floor(foot_u - wide / 2))
        u1 = min(camera.width, math.ceil(foot_u + wide / 2) + 1)
        v0 = max(0, math.floor(foot_v - high))
        v1 = min(camera.height, math.ceil(foot_v) + 1)
        if u1 - u0 < 1 or v1 - v0 < 1:
            return
        inverse = np.array(
            [
                [flip, 0.0, (sprite.shape[1] - 1) / 2.0 + flip * (u0 - foot_u)],
                [0.0, per_px, sprite.shape[0] - 0.5 + per_px * (v0 - foot_v)],
            ]
        )
        part = cv2.warpAffine(
            sprite, inverse, (u1 - u0, v1 - v0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        if self._weather.foggy:
            part = _fogged(part, float(self._weather.fog(ahead_m)), self._weather.fog_bgr)
        opacity = min(1.0, (TREE_RANGE_M - ahead_m) / _FADE_M)
        if opacity < 1.0:
            part = cv2.multiply(part, (opacity, opacity, opacity, opacity))
        blend(picture[v0:v1, u0:u1], part)

    def _sprite(self, variant: int, height_px: float) -> np.ndarray:
        """Return the sprite of a variant in the resolution that suits its height in the picture."""
        levels = self._sprites[variant % len(self._sprites)]
        level = math.floor(math.log2(levels[0].shape[0] / height_px) + 0.25)
        return levels[min(max(0, level), len(levels) - 1)]


def _fogged(sprite: np.ndarray, share: float, fog_bgr: np.ndarray) -> np.ndarray:
    """Return a premultiplied BGRA sprite with a share of the fog's colour."""
    opacity = cv2.cvtColor(cv2.extractChannel(sprite, 3), cv2.COLOR_GRAY2BGRA)
    veil = cv2.multiply(opacity, (*(share * fog_bgr / 255.0), 0.0))
    return cv2.add(cv2.multiply(sprite, (1.0 - share, 1.0 - share, 1.0 - share, 1.0)), veil)


def _pyramid(sprite: np.ndarray) -> list[np.ndarray]:
    """Return the sprite at full size, half of it, a quarter, and so on."""
    levels = [sprite]
    while levels[-1].shape[0] > 8:
        levels.append(halve(levels[-1]))
    return levels


def _tree_sprite(seed: int) -> np.ndarray:
    """Return a tree (256, 192, 4), premultiplied BGRA, its foot in the middle of the lowest row."""
    rng = np.random.RandomState(seed)
    high, wide = _SPRITE_PX
    colour = np.zeros((2 * high, 2 * wide, 3), np.float32)
    alpha = np.zeros((2 * high, 2 * wide), np.uint8)
    foot = round(2 * high * TRUNK_RADIUS_SHARE)
    crown_y = round(2 * high * (1.0 - CROWN_CENTRE_SHARE))
    trunk = np.array([[192 - foot, 511], [192 + foot, 511], [199, 300], [187, 300]], np.int32)
    shaded = np.array([[194, 511], [204, 511], [199, 300], [194, 300]], np.int32)
    cv2.fillPoly(alpha, [trunk], (255,))
    # A trunk is as bright as grass: a darker one has steep edges, as a marking has.
    cv2.fillPoly(colour, [trunk], (70, 92, 104))
    cv2.fillPoly(colour, [shaded], (60, 78, 90))
    tint = rng.uniform(0.85, 1.15, 3) * np.array([44.0, 100.0, 70.0])
    leaves = []
    for _ in range(230):
        angle, radius = rng.uniform(0, 2 * np.pi), np.sqrt(rng.uniform(0, 1))
        x, y = 192 + 142 * radius * np.cos(angle), crown_y + 138 * radius * np.sin(angle)
        leaves.append((x, y, rng.uniform(14, 36)))
    for x, y, r in sorted(leaves, key=lambda leaf: leaf[2], reverse=True):
        lit = 0.62 + 0.5 * np.clip(0.5 - 0.34 * (x - 192) / 142 - 0.62 * (y - crown_y) / 138, 0, 1)
        lit *= rng.uniform(0.82, 1.16)
        cv2.circle(alpha, (int(x), int(y)), int(r), (255,), -1)
        cv2.circle(colour, (int(x), int(y)), int(r), tuple(0.8 * lit * tint), -1)
        cv2.circle(
            colour, (int(x - 0.2 * r), int(y - 0.25 * r)), int(0.72 * r), tuple(lit * tint), -1
        )
    image = np.dstack([colour * (alpha[..., None] / 255.0), alpha.astype(np.float32)])
    return np.clip(halve(image), 0, 255).astype(np.uint8)
