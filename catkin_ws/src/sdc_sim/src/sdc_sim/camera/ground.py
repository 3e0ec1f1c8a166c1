"""Ground of the camera picture: grass, road, lines and shadows.

The map is cut into square tiles at several resolutions, see GroundTiles. Each band of rows samples
the resolution that suits its distance, several times per row where a row covers metres of ground,
and averages. This keeps distant lines from flickering (mip-mapping, Williams, "Pyramidal
Parametrics", SIGGRAPH 1983, with anisotropic sampling along the view). A texel is never narrower
than 1.5 pixels of the picture, so only every second column is sampled; the others are interpolated.
"""

from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from sdc_map.network import Network
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.ground_textures import FINEST_TEXEL_M, GRASS_BGR, LEVELS, TILE_PX
from sdc_sim.camera.tiles import GroundTiles
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.simulation.weather import HAZE_BGR, HAZE_RANGE_M, Weather

# Each level keeps a window of so many tiles, either way, that its rows can touch.
_WINDOW_TILES = 3
# Samples per row by level, powers of two.
_SUBROWS = (1, 2, 4, 8, 4, 4)
_HAZE_FROM_M = 35.0
_MOST_HAZE = 0.55


class _Band(NamedTuple):
    """Rows of the picture that sample one level."""

    level: int  # resolution of the tiles
    first: int  # first row
    rows: int  # number of rows
    subrows: int  # samples per row
    start: int  # first row of the samples of the band among those of all bands


class Ground:
    """Painter of the picture's rows from the horizon down."""

    def __init__(
        self,
        road: Road | Network,
        scenery: Scenery,
        camera: CameraModel,
        seed: int,
        weather: Weather,
    ):
        self.tiles = GroundTiles(road, scenery, seed, weather)
        self._camera = camera
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
        samples, start = [], 0
        for k, count in enumerate(_SUBROWS):
            own = rows[level == k]
            if len(own) == 0:
                continue
            sub = (own[None, :] + (np.arange(count)[:, None] + 0.5) / count - 0.5).ravel()
            bands.append(_Band(k, int(own[0]), len(own), count, start))
            samples.append(self._ray(np.maximum(sub, camera.horizon_px + 0.3)))
            start += len(sub)
        self._bands = bands
        self._forward, self._spread = np.concatenate(samples, axis=1)
        self._near_m, self._far_m = np.array([(d.min(), d.max()) for d, _ in samples]).T
        texel_m = FINEST_TEXEL_M * 2.0 ** np.array([band.level for band in bands])
        self._tile_m = texel_m * TILE_PX
        self._band_of_row = np.repeat(
            np.arange(len(bands)), [band.rows * band.subrows for band in bands]
        )
        self._texels_per_m = 1.0 / texel_m[self._band_of_row]
        # One column of samples for two of the picture.
        columns = -(-camera.width // 2)
        middle = (np.arange(columns) + 0.5) * camera.width / columns - 0.5
        self._columns = np.stack([np.ones(columns), middle - camera.width / 2.0]).astype(np.float32)
        self._lines = np.empty((2, start, 2), np.float32)
        self._maps = np.empty((2, start, columns), np.float32)
        self._samples = np.empty((start, columns, 4), np.uint8)
        self._means = np.empty((camera.height - self._first_tiled_row, columns, 4), np.uint8)
        side_px = _WINDOW_TILES * TILE_PX
        self._windows = np.zeros((len(bands), side_px, side_px, 4), np.uint8)
        self._corner = np.zeros((len(bands), 2), np.int64)
        self._filled = np.zeros((len(bands), _WINDOW_TILES, _WINDOW_TILES), bool)

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
        self._grass = np.array((*GRASS_BGR, 255.0)).astype(np.uint8)

    def draw(self, picture: np.ndarray, pose: Sequence[float], horizon: np.ndarray) -> None:
        """Paint all rows below the horizon.

        Args:
            picture: BGRA picture (height, width, 4)
            pose: x [m], y [m] and heading [rad] of the vehicle in the map
            horizon: the sky's row (1, width, 4) above the horizon
        """
        camera, first = self._camera, self._first_tiled_row
        eye = camera.position_in_map(*pose)[:2]
        heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
        reach = 0.5 * (self._near_m + self._far_m)
        tiles = (eye + reach[:, None] * heading) / self._tile_m[:, None]
        corner = np.floor(tiles).astype(np.int64) - _WINDOW_TILES // 2
        self._fill_windows(corner, eye, heading)
        self._map_samples(eye - corner * self._tile_m[:, None], heading)
        for band, window in zip(self._bands, self._windows):
            self._sample(band, window)
        picture[camera.first_ground_row : first] = self._grass
        cv2.resize(
            self._means,
            (camera.width, camera.height - first),
            dst=picture[first:],
            interpolation=cv2.INTER_LINEAR,
        )
        hazy = picture[self._hazy_rows]
        cv2.add(cv2.multiply(hazy, self._clear, scale=1.0 / 255.0), self._veil, dst=hazy)
        self._blend_horizon(picture, horizon)

    def _map_samples(self, origin_m: np.ndarray, heading: np.ndarray) -> None:
        """Compute where in its window each sample lies.

        `origin_m` (B, 2) is the camera from the corner of each band's window.
        """
        origin = origin_m.T[:, self._band_of_row]
        ahead, right = heading[:, None], np.array([[heading[1]], [-heading[0]]])
        self._lines[..., 0] = (origin + ahead * self._forward) * self._texels_per_m - 0.5
        self._lines[..., 1] = right * self._spread * self._texels_per_m
        for lines, samples in zip(self._lines, self._maps):
            cv2.gemm(lines, self._columns, 1.0, None, 0.0, dst=samples)

    def _sample(self, band: _Band, window: np.ndarray) -> None:
        """Compute the mean of the samples of each row of a band."""
        count, rows = band.subrows, band.rows
        part = slice(band.start, band.start + rows * count)
        first = band.first - self._first_tiled_row
        means = self._means[first : first + rows]
        target = self._samples[part] if count > 1 else means
        cv2.remap(
            window,
            self._maps[0, part],
            self._maps[1, part],
            cv2.INTER_LINEAR,
            dst=target,
            borderMode=cv2.BORDER_REPLICATE,
        )
        while count > 1:
            count //= 2
            half = rows * count
            mean = target[:half] if count > 1 else means
            cv2.addWeighted(target[:half], 0.5, target[half : 2 * half], 0.5, 0.0, dst=mean)

    def _blend_horizon(self, picture: np.ndarray, horizon: np.ndarray) -> None:
        """Mix the sky into the first row of the ground, which the horizon cuts."""
        row = self._camera.first_ground_row
        share = float(np.clip(row + 0.5 - self._camera.horizon_px, 0.0, 1.0))
        if row > 0 and share < 1.0:
            first = picture[row : row + 1]
            cv2.addWeighted(first, share, horizon, 1.0 - share, 0.0, dst=first)

    def _fill_windows(self, corner: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> None:
        """Copy into each band's window the tiles that its rows can touch.

        `corner` has the column and the row of the lowest tile of each window (B, 2).
        """
        self._filled[(corner != self._corner).any(axis=1)] = False
        self._corner = corner
        near, far = self._near_m[:, None, None], self._far_m[:, None, None]
        side_m = self._tile_m[:, None, None]
        middle = corner[..., None] + (np.arange(_WINDOW_TILES) + 0.5)
        x, y = (middle * side_m - eye[:, None]).transpose(1, 0, 2)
        x, y = x[:, None, :], y[:, :, None]
        ahead, aside = heading[0] * x + heading[1] * y, heading[0] * y - heading[1] * x
        reach = 0.52 * (abs(heading[0]) + abs(heading[1])) * side_m
        slant = 0.52 * np.hypot(1.0, self._side) * np.sqrt(2.0) * side_m
        missing = (
            (ahead + reach >= near)
            & (ahead - reach <= far)
            & (np.abs(aside) - self._side * ahead <= slant)
            & ~self._filled
        )
        for band, row, column in np.argwhere(missing).tolist():
            tile_column, tile_row = (corner[band] + (column, row)).tolist()
            y_px, x_px = row * TILE_PX, column * TILE_PX
            window = self._windows[band, y_px : y_px + TILE_PX, x_px : x_px + TILE_PX]
            window[:] = self.tiles.tile(self._bands[band].level, tile_column, tile_row)
        self._filled |= missing
