"""Sky of the camera picture, with far trees and roofs on the horizon."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import lattice_noise
from sdc_sim.simulation.weather import HAZE_BGR

_SKY_COLUMNS = 2048
_SKY_TOP_RAD = 0.75
# The sky is smooth: one texel for so many pixels of the picture, either way.
_SKY_STEP_PX = 4
_SKYLINE_RAD = 0.055
_SKYLINE_ROWS = 48
_ZENITH_BGR = np.array([216.0, 150.0, 92.0])
_CLOUD_BGR = np.array([246.0, 243.0, 240.0])
_ROOF_BGR = (168, 160, 152)
_WOOD_BGR = (88, 108, 84)


class _Layer(NamedTuple):
    """A picture of one and a half turns, and where the camera samples it at heading 0."""

    picture: np.ndarray
    x: np.ndarray
    y: np.ndarray
    columns_per_turn: int

    @classmethod
    def of(cls, panorama: np.ndarray, azimuth: np.ndarray, row: np.ndarray) -> _Layer:
        """Return the layer of a panorama that is sampled at azimuths [rad] and rows."""
        rows, columns = panorama.shape[:2]
        wide = np.concatenate([panorama, panorama], axis=1)[:, : columns + columns // 2 + 4]
        # OpenCV samples an image far faster inside than at its border.
        wide = np.pad(wide, ((0, 1), (0, 0), (0, 0)), mode="edge")
        x = (azimuth * columns / (2.0 * np.pi)).astype(np.float32)
        return cls(wide, x, np.clip(row, 0, rows - 1).astype(np.float32), columns)

    def sample(self, turn: float, out: np.ndarray | None = None) -> np.ndarray:
        """Return what the camera sees after a turn to the right [turns]."""
        x = self.x + np.float32(turn * self.columns_per_turn)
        border = cv2.BORDER_REPLICATE
        return cv2.remap(self.picture, x, self.y, cv2.INTER_LINEAR, dst=out, borderMode=border)


class Sky:
    """Painter of the picture's rows above the horizon."""

    def __init__(self, camera: CameraModel, seed: int):
        self._camera = camera
        self._rows = camera.first_ground_row
        skyline_rows = int(np.ceil(camera.focal_px * np.tan(_SKYLINE_RAD))) + 1
        self._skyline_top = self._rows - min(self._rows, skyline_rows)
        panorama = _panorama(seed)
        small_rows = min(-(-self._skyline_top // _SKY_STEP_PX), camera.height // _SKY_STEP_PX)
        middle = 0.5 * (_SKY_STEP_PX - 1)
        azimuth, elevation = self._directions(
            _SKY_STEP_PX * np.arange(-(-camera.width // _SKY_STEP_PX)) + middle,
            _SKY_STEP_PX * np.arange(small_rows) + middle,
        )
        share = elevation / _SKY_TOP_RAD
        self._sky = _Layer.of(panorama, azimuth, (1.0 - share) * (len(panorama) - 1))
        azimuth, elevation = self._directions(
            np.arange(camera.width), np.arange(self._skyline_top, self._rows)
        )
        row = (1.0 - elevation / _SKYLINE_RAD) * _SKYLINE_ROWS - 0.5
        self._skyline = _Layer.of(_skyline(seed, panorama), azimuth, row)
        # The lowest painted row, which the ground blends into.
        self.horizon = np.zeros((1, camera.width, 4), np.uint8)

    def _directions(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return azimuth, positive right, and elevation (len(v), len(u)) of pixels [rad]."""
        camera = self._camera
        c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
        x, y = np.meshgrid(
            (u - camera.width / 2.0) / camera.focal_px, (v - camera.height / 2.0) / camera.focal_px
        )
        ahead, up = c - y * s, -(s + y * c)
        return np.arctan2(x, ahead), np.arctan2(up, np.hypot(x, ahead))

    def draw(self, picture: np.ndarray, yaw_rad: float) -> None:
        """Paint all rows above the horizon of a BGRA picture (height, width, 4)."""
        if self._rows == 0:
            return
        # Columns increase to the right; the wrap keeps the left quarter of the view above column 0.
        turn = np.mod(-yaw_rad, 2.0 * np.pi) / (2.0 * np.pi)
        turn += 1.0 if turn < 0.25 else 0.0
        rows = _SKY_STEP_PX * len(self._sky.x)
        if rows:
            size = (self._camera.width, rows)
            small = self._sky.sample(turn)
            cv2.resize(small, size, dst=picture[:rows], interpolation=cv2.INTER_LINEAR)
        self._skyline.sample(turn, picture[self._skyline_top : self._rows])
        self.horizon[:] = picture[self._rows - 1]


def _panorama(seed: int) -> np.ndarray:
    """Return the sky (256, _SKY_COLUMNS, 4) BGRA, from elevation _SKY_TOP_RAD down to 0."""
    rows = 256
    elevation = np.linspace(_SKY_TOP_RAD, 0.0, rows)[:, None]
    azimuth = np.linspace(0.0, 2.0 * np.pi, _SKY_COLUMNS, endpoint=False)[None, :]
    reach = 1.0 / np.tan(np.maximum(elevation, 0.035))
    x = 110.0 * reach * np.cos(azimuth) + 4096.0
    y = 110.0 * reach * np.sin(azimuth) + 4096.0
    cover = np.zeros((rows, _SKY_COLUMNS), np.float32)
    for octave, weight in ((0, 0.36), (1, 0.28), (2, 0.22), (3, 0.14)):
        noise = lattice_noise(seed + 31, octave, 1024, 2**octave).astype(np.float32)
        cover += weight * cv2.remap(
            noise,
            np.mod(x, 1023.0).astype(np.float32),
            np.mod(y, 1023.0).astype(np.float32),
            cv2.INTER_LINEAR,
        )
    cover = np.clip((cover - 0.05) / 0.55, 0.0, 1.0) * np.clip(elevation / 0.16, 0.0, 1.0) * 0.85
    height = (elevation / _SKY_TOP_RAD) ** 0.6
    clear = HAZE_BGR + (_ZENITH_BGR - HAZE_BGR) * height[..., None]
    sky = clear + (_CLOUD_BGR - clear) * cover[..., None]
    return cv2.cvtColor(np.clip(sky, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)


def _skyline(seed: int, sky: np.ndarray) -> np.ndarray:
    """Return far woods and roofs in front of the sky.

    The image (_SKYLINE_ROWS, 2 _SKY_COLUMNS, 4) BGRA is _SKYLINE_RAD high; its last row is at the
    horizon.
    """
    rows, columns = _SKYLINE_ROWS, 2 * _SKY_COLUMNS
    rng = np.random.RandomState(seed + 5)
    angle = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    ridge = sum(
        rng.uniform(0.6, 1.0) / n**0.7 * np.sin(n * angle + rng.uniform(0, 6.3))
        for n in (3, 7, 13, 29, 61, 127, 211, 307)
    )
    wood = np.clip(0.46 + 0.12 * ridge, 0.3, 0.95)
    roofs = np.zeros(columns)
    for _ in range(70):
        start, width = rng.randint(columns), rng.randint(12, 40)
        roofs[np.arange(start, start + width) % columns] = rng.uniform(0.35, 0.85)
    height = (np.arange(rows)[::-1, None] + 0.5) / rows
    column, row = (
        grid.astype(np.float32)
        for grid in np.meshgrid(
            0.5 * np.arange(columns), (1.0 - height * _SKYLINE_RAD / _SKY_TOP_RAD) * (len(sky) - 1)
        )
    )
    image = cv2.remap(sky, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP).astype(
        np.float32
    )
    for top, bgr in ((roofs, _ROOF_BGR), (wood, _WOOD_BGR)):
        cover = np.clip((top - height) * rows / 1.6 + 0.5, 0.0, 1.0)[..., None]
        colour = np.append(np.array(bgr, np.float32), 255.0)
        image += cover * (colour - image)
    return np.clip(image, 0, 255).astype(np.uint8)
