"""Ground of the camera picture: grass, road, lines and shadows.

The map is cut into square tiles at several resolutions, see GroundTiles. Each band of rows samples
the resolution that suits its distance, several times per row where a row covers metres of ground,
and averages. This keeps distant lines from flickering (mip-mapping, Williams, "Pyramidal
Parametrics", SIGGRAPH 1983, with anisotropic sampling along the view). A texel is never narrower
than 1.5 pixels of the picture, so only every second column is sampled; the others are interpolated.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground_textures import FINEST_TEXEL_M, GRASS_BGR, LEVELS, TILE_PX
from sdc_sim.camera.painting import HAZE_BGR, HAZE_RANGE_M
from sdc_sim.camera.tiles import GroundTiles
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery

# Each level keeps a window of so many tiles, either way, that its rows can touch.
_WINDOW_TILES = 3
# Samples per row by level, powers of two.
_SUBROWS = (1, 2, 4, 8, 4, 4)
_HAZE_FROM_M = 35.0
_MOST_HAZE = 0.55


class _Band(NamedTuple):
    """Rows of the picture that sample one level.

    Attributes:
        level: resolution of the tiles
        first: first row
        last: row after the last one
        subrows: samples per row
        start: first row of the samples of the band among those of all bands
        near_m: least distance along the heading [m]
        far_m: greatest distance along the heading [m]
    """

    level: int
    first: int
    last: int
    subrows: int
    start: int
    near_m: float
    far_m: float

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return self.last - self.first


class _Window:
    """Adjacent tiles of one level in one image, which follow the camera."""

    def __init__(self):
        self.corner: tuple[int, int] | None = None
        self.filled = np.zeros((_WINDOW_TILES, _WINDOW_TILES), bool)
        self.image = np.zeros((_WINDOW_TILES * TILE_PX, _WINDOW_TILES * TILE_PX, 4), np.uint8)

    def move(self, corner: tuple[int, int]) -> None:
        """Move the lowest tile to (column, row); the window becomes empty if it moves."""
        if self.corner != corner:
            self.corner = corner
            self.filled[:] = False

    def put(self, row: int, column: int, tile: np.ndarray) -> None:
        """Store a tile."""
        y, x = row * TILE_PX, column * TILE_PX
        self.image[y : y + TILE_PX, x : x + TILE_PX] = tile
        self.filled[row, column] = True


class Ground:
    """Painter of the picture's rows from the horizon down."""

    def __init__(self, road: Road, scenery: Scenery, camera: CameraModel, seed: int):
        self.tiles = GroundTiles(road, scenery, seed)
        self._camera = camera
        self._windows = [_Window() for _ in range(LEVELS)]
        self._side = np.tan(camera.fov_rad / 2.0) * (1.0 + 1.0 / camera.width)
        self._plan_bands()
        self._plan_haze()

    def _ray(self, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distance ahead and width of a pixel on the ground of the rows `v` [m]."""
        camera = self._camera
        c, s = np.cos(camera.pitch_rad), np.sin(camera.pitch_rad)
        y = (v - camera.height / 2.0) / camera.focal_px
        t = camera.mount_z_m / np.maximum(s + y * c, 1e-9)
        return t * (c - y * s), t / camera.focal_px

    def _plan_bands(self) -> None:
        """Compute which rows sample which resolution where; it depends on the camera only."""
        camera = self._camera
        rows = np.arange(camera.height)
        self._distance, _ = self._ray(rows.astype(float))
        tile_m = FINEST_TEXEL_M * TILE_PX * 2.0 ** np.arange(LEVELS)
        far = 0.84 * tile_m / np.hypot(np.tan(camera.fov_rad / 2.0), 0.25)
        level = np.searchsorted(far, self._distance)
        self._first_tiled_row = int(np.flatnonzero(level < LEVELS)[0])
        bands: list[_Band] = []
        forward, spread, start = [], [], 0
        for k, count in enumerate(_SUBROWS):
            own = rows[level == k]
            if len(own) == 0:
                continue
            sub = (own[None, :] + (np.arange(count)[:, None] + 0.5) / count - 0.5).ravel()
            d, w = self._ray(np.maximum(sub, camera.horizon_px + 0.3))
            first, last = int(own[0]), int(own[-1]) + 1
            bands.append(_Band(k, first, last, count, start, float(d.min()), float(d.max())))
            forward.append(d)
            spread.append(w)
            start += len(sub)
        self._bands = bands
        self._forward, self._spread = np.concatenate(forward), np.concatenate(spread)
        self._near_m = np.array([band.near_m for band in bands])
        self._far_m = np.array([band.far_m for band in bands])
        self._texel_m = FINEST_TEXEL_M * 2.0 ** np.array([band.level for band in bands])
        self._band_of_row = np.repeat(
            np.arange(len(bands)), [band.rows * band.subrows for band in bands]
        )
        # One column of samples for two of the picture.
        columns = -(-camera.width // 2)
        middle = (np.arange(columns) + 0.5) * camera.width / columns - 0.5
        self._columns = np.stack([np.ones(columns), middle - camera.width / 2.0]).astype(np.float32)
        self._map_x = np.empty((start, columns), np.float32)
        self._map_y = np.empty_like(self._map_x)
        self._samples = np.empty((start, columns, 4), np.uint8)

    def _plan_haze(self) -> None:
        """Compute the haze of each row."""
        distance, first = self._distance, self._camera.first_ground_row
        self._hazy_rows = slice(first, int(np.flatnonzero(distance > _HAZE_FROM_M)[-1]) + 1)
        haze = np.minimum(1.0 - np.exp(-distance / HAZE_RANGE_M), _MOST_HAZE)[self._hazy_rows]
        shape = (len(haze), self._camera.width, 4)
        clear = np.broadcast_to((1.0 - haze)[:, None, None], shape)
        veil = np.broadcast_to(np.append(HAZE_BGR * 0.82, 0.0) * haze[:, None, None], shape)
        self._clear = np.round(255 * clear).astype(np.uint8)
        self._clear[..., 3] = 255
        self._veil = np.round(veil).astype(np.uint8)

    def draw(
        self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float, horizon: np.ndarray
    ) -> None:
        """Paint all rows below the horizon.

        Args:
            picture: BGRA picture (height, width, 4)
            x_m: position of the vehicle [m]
            y_m: position of the vehicle [m]
            yaw_rad: heading of the vehicle [rad]
            horizon: the sky's row (1, width, 4) above the horizon
        """
        eye = self._camera.position_in_map(x_m, y_m, yaw_rad)[:2]
        heading = np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
        tile_m = self._texel_m * TILE_PX
        reach = 0.5 * (self._near_m + self._far_m)
        corner = (
            np.floor((eye + reach[:, None] * heading) / tile_m[:, None]).astype(np.int64)
            - _WINDOW_TILES // 2
        )
        self._fill_windows(corner, tile_m, eye, heading)
        self._map_samples(eye - corner * tile_m[:, None], heading)
        picture[self._camera.first_ground_row : self._first_tiled_row] = (*GRASS_BGR, 255.0)
        for band in self._bands:
            self._draw_band(picture, band)
        hazy = picture[self._hazy_rows]
        cv2.add(cv2.multiply(hazy, self._clear, scale=1.0 / 255.0), self._veil, dst=hazy)
        self._blend_horizon(picture, horizon)

    def _map_samples(self, origin_m: np.ndarray, heading: np.ndarray) -> None:
        """Compute where in its window each sample lies.

        Args:
            origin_m: position of the camera from the corner of each band's window (B, 2) [m]
            heading: unit vector (2,) of the view
        """
        c, s = heading
        origin = origin_m[self._band_of_row]
        scale = 1.0 / self._texel_m[self._band_of_row]
        ax = (origin[:, 0] + c * self._forward) * scale - 0.5
        ay = (origin[:, 1] + s * self._forward) * scale - 0.5
        rows_x = np.stack([ax, s * self._spread * scale], axis=1).astype(np.float32)
        rows_y = np.stack([ay, -c * self._spread * scale], axis=1).astype(np.float32)
        cv2.gemm(rows_x, self._columns, 1.0, None, 0.0, dst=self._map_x)
        cv2.gemm(rows_y, self._columns, 1.0, None, 0.0, dst=self._map_y)

    def _draw_band(self, picture: np.ndarray, band: _Band) -> None:
        count, rows = band.subrows, band.rows
        part = slice(band.start, band.start + rows * count)
        target = self._samples[part]
        cv2.remap(
            self._windows[band.level].image,
            self._map_x[part],
            self._map_y[part],
            cv2.INTER_LINEAR,
            dst=target,
            borderMode=cv2.BORDER_REPLICATE,
        )
        while count > 1:
            count //= 2
            half = rows * count
            cv2.addWeighted(
                target[:half], 0.5, target[half : 2 * half], 0.5, 0.0, dst=target[:half]
            )
        cv2.resize(
            target[:rows],
            (self._camera.width, rows),
            dst=picture[band.first : band.last],
            interpolation=cv2.INTER_LINEAR,
        )

    def _blend_horizon(self, picture: np.ndarray, horizon: np.ndarray) -> None:
        """Mix the sky into the first row of the ground, which the horizon cuts."""
        row = self._camera.first_ground_row
        share = float(np.clip(row + 0.5 - self._camera.horizon_px, 0.0, 1.0))
        if row > 0 and share < 1.0:
            first = picture[row : row + 1]
            cv2.addWeighted(first, share, horizon, 1.0 - share, 0.0, dst=first)

    def _fill_windows(
        self, corner: np.ndarray, tile_m: np.ndarray, eye: np.ndarray, heading: np.ndarray
    ) -> None:
        """Copy into each level's window the tiles that its band of rows can touch.

        Args:
            corner: column and row of the lowest tile of each window (B, 2)
            tile_m: width of a tile of each level (B,) [m]
            eye: position (2,) of the camera [m]
            heading: unit vector (2,) of the view
        """
        near, far = self._near_m[:, None, None], self._far_m[:, None, None]
        side_m = tile_m[:, None, None]
        step = np.arange(_WINDOW_TILES) + 0.5
        x = (corner[:, 0, None, None] + step[None, None, :]) * side_m - eye[0]
        y = (corner[:, 1, None, None] + step[None, :, None]) * side_m - eye[1]
        ahead, aside = heading[0] * x + heading[1] * y, heading[0] * y - heading[1] * x
        reach = 0.52 * (abs(heading[0]) + abs(heading[1])) * side_m
        slant = 0.52 * np.hypot(1.0, self._side) * np.sqrt(2.0) * side_m
        seen = (
            (ahead + reach >= near)
            & (ahead - reach <= far)
            & (np.abs(aside) - self._side * ahead <= slant)
        )
        for band, own, (first_column, first_row) in zip(self._bands, seen, corner.tolist()):
            window = self._windows[band.level]
            window.move((first_column, first_row))
            missing = own & ~window.filled
            if not missing.any():
                continue
            for row, column in np.argwhere(missing).tolist():
                tile = self.tiles.tile(band.level, first_column + column, first_row + row)
                window.put(row, column, tile)
