"""Paints the sky of the camera picture, and the far trees and roofs on the horizon."""

from __future__ import annotations

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import HAZE_BGR, lattice_noise

SKY_COLUMNS = 2048
SKY_TOP_RAD = 0.75
SKY_STEP = 4  # pixels of the picture to one computed of the sky
SKYLINE_RAD = 0.055


def _panorama(seed: int) -> np.ndarray:
    """Sky (256, SKY_COLUMNS, 4) BGRA round the horizon, row 0 at elevation SKY_TOP_RAD, last row at 0."""
    rows = 256
    elevation = np.linspace(SKY_TOP_RAD, 0.0, rows)[:, None]
    azimuth = np.linspace(0.0, 2.0 * np.pi, SKY_COLUMNS, endpoint=False)[None, :]
    reach = 1.0 / np.tan(np.maximum(elevation, 0.035))
    x, y = (110.0 * reach * f(azimuth) + 4096.0 for f in (np.cos, np.sin))
    cover = np.zeros((rows, SKY_COLUMNS), np.float32)
    for octave, weight in ((0, 0.36), (1, 0.28), (2, 0.22), (3, 0.14)):
        noise = lattice_noise(seed + 31, octave, 1024, 2**octave).astype(np.float32)
        cover += weight * cv2.remap(
            noise,
            np.mod(x, 1023.0).astype(np.float32),
            np.mod(y, 1023.0).astype(np.float32),
            cv2.INTER_LINEAR,
        )
    cover = np.clip((cover - 0.05) / 0.55, 0.0, 1.0) * np.clip(elevation / 0.16, 0.0, 1.0) * 0.85
    height = (elevation / SKY_TOP_RAD) ** 0.6
    clear = HAZE_BGR + (np.array([216.0, 150.0, 92.0]) - HAZE_BGR) * height[..., None]
    sky = clear + (np.array([246.0, 243.0, 240.0]) - clear) * cover[..., None]
    return cv2.cvtColor(np.clip(sky, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)


def _skyline(seed: int, sky: np.ndarray) -> np.ndarray:
    """Far trees and roofs before the `sky` (48, 2 SKY_COLUMNS, 4) BGRA, last row at the horizon, SKYLINE_RAD high."""
    rows, columns = 48, 2 * SKY_COLUMNS
    rng = np.random.RandomState(seed + 5)
    angle = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    ridge = sum(
        rng.uniform(0.6, 1.0) / n**0.7 * np.sin(n * angle + rng.uniform(0, 6.3))
        for n in (3, 7, 13, 29, 61, 127, 211, 307)
    )
    wood = np.clip(0.46 + 0.12 * ridge, 0.3, 0.95)
    roofs = np.zeros(columns)
    for _ in range(70):
        at, wide = rng.randint(columns), rng.randint(12, 40)
        roofs[np.arange(at, at + wide) % columns] = rng.uniform(0.35, 0.85)
    height = (np.arange(rows)[::-1, None] + 0.5) / rows
    column, row = (
        grid.astype(np.float32)
        for grid in np.meshgrid(
            0.5 * np.arange(columns), (1.0 - height * SKYLINE_RAD / SKY_TOP_RAD) * (len(sky) - 1)
        )
    )
    image = cv2.remap(sky, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP).astype(
        np.float32
    )
    for top, colour in ((roofs, (168, 160, 152)), (wood, (88, 108, 84))):
        cover = np.clip((top - height) * rows / 1.6 + 0.5, 0.0, 1.0)[..., None]
        colour = np.append(np.array(colour, np.float32), 255.0)
        image += cover * (colour - image)
    return np.clip(image, 0, 255).astype(np.uint8)


class Sky:
    """Paints the rows of the picture down to the horizon; `horizon` (1, width, 4) is the last of them that was painted."""

    def __init__(self, cam: CameraModel, seed: int):
        self.camera = cam
        self._plan(seed)

    def _plan(self, seed: int) -> None:
        cam = self.camera
        c, s = np.cos(cam.pitch_rad), np.sin(cam.pitch_rad)

        def directions(u, v):
            x, y = np.meshgrid(
                (u - cam.width / 2.0) / cam.focal_px, (v - cam.height / 2.0) / cam.focal_px
            )
            ahead, up = c - y * s, -(s + y * c)
            return np.arctan2(x, ahead), np.arctan2(up, np.hypot(x, ahead))

        rows = cam.first_ground_row
        self._sky_rows = rows
        depth = min(rows, int(np.ceil(cam.focal_px * np.tan(SKYLINE_RAD))) + 1)
        self._line_top = rows - depth
        sky = _panorama(seed)
        self._sky = np.concatenate([sky, sky], axis=1)[:, : SKY_COLUMNS + SKY_COLUMNS // 2 + 4]
        small_rows = min(-(-self._line_top // SKY_STEP), cam.height // SKY_STEP)
        middle = 0.5 * (SKY_STEP - 1)
        azimuth, elevation = directions(
            SKY_STEP * np.arange(-(-cam.width // SKY_STEP)) + middle,
            SKY_STEP * np.arange(small_rows) + middle,
        )
        self._sky_x = (azimuth * SKY_COLUMNS / (2.0 * np.pi)).astype(np.float32)
        self._sky_y = np.clip(
            (1.0 - elevation / SKY_TOP_RAD) * (len(sky) - 1), 0, len(sky) - 1
        ).astype(np.float32)
        line = _skyline(seed, sky)
        self._line = np.concatenate([line, line], axis=1)[:, : 3 * SKY_COLUMNS + 4]
        azimuth, elevation = directions(np.arange(cam.width), np.arange(self._line_top, rows))
        self._line_x = (azimuth * SKY_COLUMNS / np.pi).astype(np.float32)
        self._line_y = np.minimum(
            (1.0 - elevation / SKYLINE_RAD) * len(line) - 0.5, len(line) - 1
        ).astype(np.float32)
        self.horizon = np.zeros((1, cam.width, 4), np.uint8)

    def draw(self, picture: np.ndarray, yaw_rad: float) -> None:
        cam = self.camera
        if self._sky_rows == 0:
            return
        # Columns run to the right, from a quarter turn left of the view at the least.
        turn = np.mod(-yaw_rad, 2.0 * np.pi) / (2.0 * np.pi)
        wrap = 1.0 if turn * SKY_COLUMNS < SKY_COLUMNS / 4 else 0.0
        rows = SKY_STEP * len(self._sky_x)
        if rows:
            small = cv2.remap(
                self._sky,
                self._sky_x + np.float32((turn + wrap) * SKY_COLUMNS),
                self._sky_y,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
            cv2.resize(small, (cam.width, rows), dst=picture[:rows], interpolation=cv2.INTER_LINEAR)
        cv2.remap(
            self._line,
            self._line_x + np.float32((turn + wrap) * 2 * SKY_COLUMNS),
            self._line_y,
            cv2.INTER_LINEAR,
            dst=picture[self._line_top : self._sky_rows],
            borderMode=cv2.BORDER_REPLICATE,
        )
        self.horizon[:] = picture[self._sky_rows - 1]
