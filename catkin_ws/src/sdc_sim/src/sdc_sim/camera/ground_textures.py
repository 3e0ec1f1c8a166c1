"""Textures of the ground: grass and asphalt at several resolutions."""

from __future__ import annotations

import cv2
import numpy as np

from sdc_sim.camera.painting import lattice_noise

# Tiles are squares of so many texels. A texel of level k is FINEST_TEXEL_M * 2**k wide.
TILE_PX = 256
FINEST_TEXEL_M = 0.025
LEVELS = 6
GRASS_BGR = np.array([50.0, 104.0, 92.0])
_ASPHALT_BGR = np.array([88.0, 85.0, 83.0])
# Strength of the fine octaves and of the grain of asphalt, by level.
_FINE = (1.0, 0.8, 0.6, 0.4, 0.25, 0.15)
_GRAIN = (0.06, 0.03, 0.01, 0.0, 0.0, 0.0)


def ground_textures(level: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the textures of grass and asphalt.

    They are periodic over two tiles. Neighbouring levels share all but one octave of the noise.

    Args:
        level: resolution, 0..LEVELS-1
        seed: selects the pattern

    Returns:
        grass and asphalt (2 TILE_PX, 2 TILE_PX, 4) BGRA
    """
    size = 2 * TILE_PX
    octaves = [lattice_noise(seed, level - k, size, 2**k) for k in (0, 1, 2)]
    grain = np.random.RandomState(seed + 7 * level).normal(size=(size, size)).astype(np.float32)
    fine = _FINE[level]
    blades = (
        0.075 * octaves[0]
        + fine * (0.07 * octaves[1] + 0.07 * octaves[2])
        + (0.06 * grain if level < 2 else 0.0)
    )
    hue = 0.05 * octaves[1] + 0.04 * octaves[0]
    grass = GRASS_BGR * (1.0 + blades[..., None] + hue[..., None] * np.array([-0.6, 0.0, 0.9]))
    stone = 0.022 * octaves[0] + fine * (0.022 * octaves[1] + 0.028 * octaves[2])
    stone = stone + _GRAIN[level] * grain
    asphalt = _ASPHALT_BGR * (1.0 + stone[..., None])
    return _bgra(grass), _bgra(asphalt)


def _bgra(texture: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(np.clip(texture, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)
