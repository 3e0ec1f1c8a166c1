"""What the weather does to the camera picture: fog, rain, warm light, worn paint."""

from __future__ import annotations

import math

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import lattice_noise
from sdc_sim.simulation.weather import Weather

# In rain the ground is darker.
_WET = 0.78
_RAIN_LAYERS = 8
_STREAKS = 420
_STREAK_BRIGHTNESS = 70.0
_STREAKS_PER_S = 97.0
_LOW_SUN_TINT_BGR = (0.74, 0.90, 1.02)


class Air:
    """What the air does to the picture: fog, rain and the colour of the light."""

    def __init__(self, weather: Weather, camera: CameraModel, seed: int = 0):
        self.weather = weather
        self._veil: tuple[np.ndarray, np.ndarray] | None = None
        if weather.foggy:
            self._veil = self._plan_veil(camera)
        self._streaks = []
        if weather.rain:
            self._streaks = [_streaks(camera, weather.rain, seed + k) for k in range(_RAIN_LAYERS)]

    def _plan_veil(self, camera: CameraModel) -> tuple[np.ndarray, np.ndarray]:
        """Return by what to multiply each pixel of the background, 0..255, and what to add."""
        weather = self.weather
        rows = (np.arange(camera.height) - camera.height / 2.0) / camera.focal_px
        c, s = math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
        down = s + rows * c
        distance = camera.mount_z_m / np.maximum(down, 1e-4)
        columns = (np.arange(camera.width) - camera.width / 2.0) / camera.focal_px
        fog = weather.fog(distance[:, None] * np.hypot(1.0, columns)[None, :])
        # The layer of fog is some decametres high; clouds hide the sky in rain.
        sky = np.maximum(weather.fog(60.0 / np.maximum(-down, 1e-4)), 0.85 if weather.rain else 0.0)
        fog = np.where(down[:, None] > 0.0, fog, sky[:, None])
        wet = np.where(down[:, None] > 0.0, 1.0 - (1.0 - _WET) * min(1.0, 2.0 * weather.rain), 1.0)
        clear = np.repeat((255.0 * wet * (1.0 - fog))[..., None], 4, axis=2)
        clear[..., 3] = 255.0
        veil = np.append(weather.fog_bgr, 0.0) * fog[..., None]
        return np.round(clear).astype(np.uint8), np.round(veil).astype(np.uint8)

    def veil_background(self, picture: np.ndarray) -> None:
        """Add fog to a picture of sky and ground."""
        if self._veil is not None:
            clear, veil = self._veil
            cv2.add(cv2.multiply(picture, clear, scale=1.0 / 255.0), veil, dst=picture)

    def finish(self, picture: np.ndarray, x_m: float, y_m: float, time_s: float) -> None:
        """Add what is in front of all objects: the streaks of the rain, the colour of the light."""
        if self._streaks:
            # The picture depends on place and time only. A streak is not in the next picture.
            number = math.floor(37.0 * x_m) * 7 + math.floor(37.0 * y_m) * 3
            number += round(_STREAKS_PER_S * time_s)
            cv2.add(picture, self._streaks[number % len(self._streaks)], dst=picture)
        if self.weather.low_sun:
            cv2.multiply(picture, (*_LOW_SUN_TINT_BGR, 1.0), dst=picture)


def _streaks(camera: CameraModel, rain: float, seed: int) -> np.ndarray:
    """Return a layer (height, width, 4) of rain drops, blurred by their motion."""
    random = np.random.RandomState(seed + 400)
    layer = np.zeros((camera.height, camera.width), np.uint8)
    for _ in range(round(_STREAKS * rain)):
        u, v = random.uniform(0, camera.width), random.uniform(-30, camera.height)
        near = random.uniform(0.3, 1.0) ** 2
        length, lean = 8.0 + 46.0 * near, 0.10 * (u - camera.width / 2.0) / camera.width
        start = (round(16 * u), round(16 * v))
        end = (round(16 * (u + lean * length)), round(16 * (v + length)))
        bright = _STREAK_BRIGHTNESS * random.uniform(0.4, 1.0)
        cv2.line(layer, start, end, bright, 1 if near < 0.6 else 2, cv2.LINE_AA, 4)
    layer = cv2.GaussianBlur(layer, (3, 5), 0)
    layers = cv2.merge([layer] * 4)
    layers[..., 3] = 0
    return layers


def worn_paint(weather: Weather, seed: int, level: int, size_px: int) -> np.ndarray | None:
    """Return the share of paint that is left (size_px, size_px) uint8, or None for all of it.

    The pattern is periodic over the image, and coarser at lower resolutions.
    """
    if not weather.worn_lines:
        return None
    octaves = [lattice_noise(seed + 91, level - k, size_px, 2**k) for k in (0, 1, 2)]
    noise = 0.5 * octaves[0] + 0.6 * octaves[1] + 0.5 * octaves[2]
    # Of the normal distribution, so much is below the threshold.
    threshold = float(np.quantile(noise, 0.85 * weather.worn_lines))
    left = np.clip(0.5 + (noise - threshold) / 0.5, 0.06, 1.0) * (1.0 - 0.35 * weather.worn_lines)
    if level >= 3:  # a texel is wider than the holes
        left = np.full_like(left, left.mean())
    return np.round(255.0 * left).astype(np.uint8)
