"""Weather of the camera picture: fog, rain, a low sun, worn lines. All are off by default."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

# In clear weather: colour and distance of the haze, offset of the shadow of an object of 1 m
# height, brightness in the shadow.
HAZE_BGR = np.array([214.0, 202.0, 190.0])
HAZE_RANGE_M = 420.0
SHADOW_M_PER_M = np.array([0.55, -0.45])
SHADE = 0.58
# At the distance of sight, 5 % of the contrast are left (meteorological optical range, WMO).
_CONTRAST_LEFT = 0.05
_FOG_BGR = np.array([206.0, 203.0, 200.0])
_RAIN_BGR = np.array([158.0, 152.0, 147.0])
# In rain the sight is shorter.
_RAIN_SIGHT_M = 220.0
# The sun is about 14 degrees high: shadows are long and dark.
_LOW_SUN_SHADOW = 5.6
_LOW_SUN_SHADE = 0.32
# Fog and clouds leave hardly any shadow.
_DIFFUSE_SHADE = 0.88


@dataclass(frozen=True)
class Weather:
    """Weather of the pictures."""

    fog_m: float = 0.0  # distance of sight [m]; 0: clear
    rain: float = 0.0  # strength of the rain, 0..1
    low_sun: bool = False  # whether the sun is low, with long hard shadows
    worn_lines: float = 0.0  # share of the paint that is worn off, 0..1

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


CLEAR = Weather()
