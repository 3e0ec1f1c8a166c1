"""Weather of the camera picture: fog, rain, a low sun, worn lines. All are off by default."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import cv2
import numpy as np

from sdc_common.validation import check_between, check_non_negative
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import HAZE_BGR, HAZE_RANGE_M, SHADE, SHADOW_M_PER_M, lattice_noise

# At the distance of sight, 5 % of the contrast are left (meteorological optical range, WMO).
_CONTRAST_LEFT = 0.05
_FOG_BGR = np.array([206.0, 203.0, 200.0])
_RAIN_BGR = np.array([158.0, 152.0, 147.0])
# In rain the sight is shorter, and the wet ground darker.
_RAIN_SIGHT_M = 220.0
_WET = 0.78
_RAIN_LAYERS = 8
_STREAKS = 420
_STREAK_BRIGHTNESS = 70.0
_STREAKS_PER_S = 97.0
# The sun is about 14 degrees high: shadows are long and dark, and the light is warm.
_LOW_SUN_SHADOW = 5.6
_LOW_SUN_SHADE = 0.32
# Fog and clouds leave hardly any shadow.
_DIFFUSE_SHADE = 0.88
_LOW_SUN_TINT_BGR = (0.74, 0.90, 1.02)


@dataclass(frozen=True)
class Weather:
    """Weather of the pictures.

    Attributes:
        fog_m: distance of sight [m]; 0: clear
        rain: strength of the rain, 0..1
        low_sun: whether the sun is low, with long hard shadows
        worn_lines: share of the paint that is worn off, 0..1
    """

    fog_m: float = 0.0
    rain: float = 0.0
    low_sun: bool = False
    worn_lines: float = 0.0

    def __post_init__(self):
        check_non_negative(**{"weather.fog_m": self.fog_m})
        check_between(0.0, 1.0, **{"weather.rain": self.rain})
        check_between(0.0, 1.0, **{"weather.worn_lines": self.worn_lines})
        if not isinstance(self.low_sun, bool):
            raise ValueError(f"weather.low_sun must be true or false, got {self.low_sun!r}")

    @classmethod
    def read(cls, values: Mapping[str, Any]) -> Weather:
        """Return the weather of a section of parameters.

        Raises:
            ValueError: a name is unknown, or a value is out of range
        """
        known = {field.name for field in fields(cls)}
        unknown = sorted(set(values) - known)
        if unknown:
            raise ValueError(f"weather.{unknown[0]} is unknown; write one of {sorted(known)}")
        return cls(**values)

    @property
    def shadow_m_per_m(self) -> np.ndarray:
        """Return the offset (2,) of the shadow of an object of 1 m height [m]."""
        return SHADOW_M_PER_M * (_LOW_SUN_SHADOW if self.low_sun else 1.0)

    @property
    def shade(self) -> float:
        """Return the brightness of the ground in a shadow, 0..1."""
        if self.foggy:
            return _DIFFUSE_SHADE
        return _LOW_SUN_SHADE if self.low_sun else SHADE

    @property
    def fog_bgr(self) -> np.ndarray:
        """Return the colour (3,) that distant objects fade to."""
        if self.rain:
            return _RAIN_BGR
        return _FOG_BGR if self.fog_m else HAZE_BGR

    @property
    def foggy(self) -> bool:
        """Return whether fog or rain limit the sight."""
        return bool(self.fog_m or self.rain)

    @property
    def sight_m(self) -> float:
        """Return the distance of sight, infinite in clear weather [m]."""
        sights = [self.fog_m] if self.fog_m else []
        sights += [_RAIN_SIGHT_M / self.rain] if self.rain else []
        return min(sights, default=math.inf)

    def fog(self, distance_m: float | np.ndarray) -> Any:
        """Return the share of the fog's colour at distances, 0..1; 0 in clear weather."""
        return 1.0 - np.power(_CONTRAST_LEFT, np.asarray(distance_m) / self.sight_m)

    @property
    def haze_range_m(self) -> float:
        """Return the distance at which 1/e of the contrast of a building is left [m]."""
        return min(HAZE_RANGE_M, -self.sight_m / math.log(_CONTRAST_LEFT))

    def wear(self, seed: int, level: int, size_px: int) -> np.ndarray | None:
        """Return the share of paint that is left (size_px, size_px) uint8, or None for all of it.

        The pattern is periodic over the image, and coarser at lower resolutions.
        """
        if not self.worn_lines:
            return None
        octaves = [lattice_noise(seed + 91, level - k, size_px, 2**k) for k in (0, 1, 2)]
        noise = 0.5 * octaves[0] + 0.6 * octaves[1] + 0.5 * octaves[2]
        # Of the normal distribution, so much is below the threshold.
        threshold = float(np.quantile(noise, 0.85 * self.worn_lines))
        left = np.clip(0.5 + (noise - threshold) / 0.5, 0.06, 1.0) * (1.0 - 0.35 * self.worn_lines)
        if level >= 3:  # a texel is wider than the holes
            left = np.full_like(left, left.mean())
        return np.round(255.0 * left).astype(np.uint8)


CLEAR = Weather()


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
