"""Paints the ground of the camera picture: grass, road, lines and shadows.

The map is cut into square tiles at six resolutions, 2.5 cm to 80 cm a texel; a tile is rasterised when first seen and
depends on nothing but its place, so that a picture does not depend on the ones before. Each band of rows samples the
resolution that suits its distance, several times a row where a row spans metres of ground, and averages: that is what
keeps the distance from shimmering (texture mip-mapping, Williams 1983, with anisotropic sampling along the view). A texel
is never narrower than 1.5 pixels of the picture, so every second column is sampled and those between are interpolated.
"""

from __future__ import annotations

from collections import OrderedDict

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import (
    FIXED_POINT_BITS,
    HAZE_BGR,
    HAZE_RANGE_M,
    SHADE,
    SHADOW_M_PER_M,
    footprint,
    halve,
    lattice_noise,
)
from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, LINE_WIDTH_M, MARGIN_M, CellIndex, Road

TILE_PX = 256
WINDOW_TILES = 3
FINEST_TEXEL_M = 0.025
SUBROWS = (1, 2, 4, 8, 4, 4)  # samples a row, one entry a resolution; powers of two
SUPERSAMPLES = 2  # of a texel, either way, when a tile is rasterised
CACHED_TILES = 96
ROADWAY = 5  # bands of a tile painted before the roadway
STRETCH_M = 2.0 * DASH_PERIOD_M
GRASS_BGR = np.array([50.0, 104.0, 92.0])
ASPHALT_BGR = np.array([88.0, 85.0, 83.0])
ASPHALT, PAINT, KERB, TRACK = 0.40, 1.0, 0.66, 0.365  # brightness, as parts of paint


def _ground_textures(level: int, seed: int) -> tuple:
    """Grass and asphalt (512, 512, 4) BGRA, periodic; neighbouring levels share all but one octave of the noise."""
    size = 2 * TILE_PX
    octaves = [lattice_noise(seed, level - k, size, 2**k) for k in (0, 1, 2)]
    grain = np.random.RandomState(seed + 7 * level).normal(size=(size, size)).astype(np.float32)
    fine = (1.0, 0.8, 0.6, 0.4, 0.25, 0.15)[level]
    blades = (
        0.075 * octaves[0]
        + fine * (0.07 * octaves[1] + 0.07 * octaves[2])
        + (0.06 * grain if level < 2 else 0.0)
    )
    hue = 0.05 * octaves[1] + 0.04 * octaves[0]
    grass = GRASS_BGR * (1.0 + blades[..., None] + hue[..., None] * np.array([-0.6, 0.0, 0.9]))
    stone = 0.022 * octaves[0] + fine * (0.022 * octaves[1] + 0.028 * octaves[2])
    stone = stone + (0.06, 0.03, 0.01, 0.0, 0.0, 0.0)[level] * grain
    asphalt = ASPHALT_BGR * (1.0 + stone[..., None])
    return tuple(
        cv2.cvtColor(np.clip(t, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)
        for t in (grass, asphalt)
    )


class _Pieces:
    """The road in straight pieces between `stations`, those of repeated laps left out, and where to find them.

    A piece runs from `start` to `end` (P, 2), with the unit vectors to the left `start_left` and `end_left` (P, 2). `stretch` (P,)
    numbers the stretches of STRETCH_M along the road; each ends between two dashes, so that none of its pieces cuts a dash.
    """

    def __init__(self, road: Road, stations: np.ndarray):
        stations = np.column_stack([stations[:-1], stations[1:]])
        stations = stations[~road.repeats[stations].all(axis=1)]
        first, last = stations.T
        self.start, self.end, self.start_left, self.end_left = (
            a[k]
            for a, k in (
                (road.points_m, first),
                (road.points_m, last),
                (road.left, first),
                (road.left, last),
            )
        )
        self.stretch = np.floor((road.s_m[first] + DASH_LENGTH_M) / STRETCH_M).astype(np.int64)
        along = self.end - self.start
        self._length2 = np.sum(along * along, axis=1)
        self._twist = np.sum(along * (self.end_left - self.start_left), axis=1)
        reach = road.left_edge_m + 2.0
        low, high = (
            np.minimum(self.start, self.end) - reach,
            np.maximum(self.start, self.end) + reach,
        )
        self.index = CellIndex(low, high, max(32.0, float(np.max(high - low)) / 2.0 + 0.1))

    def tangled(self, pieces: np.ndarray, low_m: np.ndarray, high_m: np.ndarray) -> np.ndarray:
        """Whether the band from `low_m` to `high_m` (B,) to the left of the pieces (P,) folds over itself: (B, P)."""
        length2, twist = self._length2[pieces], self._twist[pieces]
        return np.minimum(length2 + low_m[:, None] * twist, length2 + high_m[:, None] * twist) < 0.0


def _fixed(points_px: np.ndarray) -> np.ndarray:
    """Pixels of a canvas as OpenCV's fixed-point numbers; 0 is the border of the first pixel, not its middle."""
    return np.rint((points_px - 0.5) * 2**FIXED_POINT_BITS).astype(np.int32)


class _Tiles:
    """Tiles of the ground by (level, column, row), rasterised when asked for, the last CACHED_TILES of them kept."""

    def __init__(self, road: Road, scenery, seed: int):
        self.road = road
        self.scenery = scenery
        self.textures = [_ground_textures(level, seed) for level in range(len(SUBROWS))]
        self.cache = OrderedDict()
        self._pieces = [
            _Pieces(road, road.stations(*limits)) for limits in ((0.004,), (0.015,), (0.05, 24.0))
        ]
        if len(scenery):
            self._outline_shadows(seed)

    def _outline_shadows(self, seed: int) -> None:
        """Outlines of the shadows that the scenery casts on the ground, a list of (N, 2) for each item, and where they are."""
        position, height = self.scenery.position_m, self.scenery.size_m[:, 2:]
        angle = np.linspace(0.0, 2.0 * np.pi, 18, endpoint=False)
        wobble = np.random.RandomState(seed + 3).uniform(0.85, 1.12, (256, 18))[
            self.scenery.variant
        ]
        away = SHADOW_M_PER_M / np.hypot(*SHADOW_M_PER_M)
        ring = 0.42 * np.cos(angle)[:, None] * away + 0.30 * np.sin(angle)[:, None] * [
            -away[1],
            away[0],
        ]
        middle = position + 0.62 * height * SHADOW_M_PER_M
        crowns = middle[:, None] + height[..., None] * wobble[..., None] * ring
        trunks = np.stack([position - 0.15, position + 0.15, middle + 0.15, middle - 0.15], axis=1)
        self._outlines = [
            [crown, trunk] if kind == 0 else [self._building_shadow(item)]
            for item, (kind, crown, trunk) in enumerate(zip(self.scenery.kind, crowns, trunks))
        ]
        reach = (0.6 * np.max(self.scenery.size_m, axis=1) + 1.0)[:, None]
        tip = position + height * SHADOW_M_PER_M
        self._shadow_low, self._shadow_high = (
            np.minimum(position, tip) - reach,
            np.maximum(position, tip) + reach,
        )
        self._shadows = CellIndex(self._shadow_low, self._shadow_high, 32.0)

    def _building_shadow(self, item: int) -> np.ndarray:
        position, size = self.scenery.position_m[item], self.scenery.size_m[item]
        base = footprint((0.0, 0.0), self.scenery.yaw_rad[item], size)
        return (
            position
            + cv2.convexHull(
                np.concatenate([base, base + size[2] * SHADOW_M_PER_M]).astype(np.float32)
            )[:, 0]
        )

    def tile(self, level: int, column: int, row: int) -> np.ndarray:
        key = (level, column, row)
        tile = self.cache.get(key)
        if tile is None:
            tile = self.cache[key] = self._rasterise(level, column, row)
            if len(self.cache) > CACHED_TILES:
                self.cache.popitem(last=False)
        else:
            self.cache.move_to_end(key)
        return tile

    def _rasterise(self, level: int, column: int, row: int) -> np.ndarray:
        size_m = FINEST_TEXEL_M * 2**level * TILE_PX
        origin = np.array([column, row]) * size_m
        part = np.s_[
            row % 2 * TILE_PX : (row % 2 + 1) * TILE_PX,
            column % 2 * TILE_PX : (column % 2 + 1) * TILE_PX,
        ]
        grass, asphalt = (texture[part] for texture in self.textures[level])
        weights, shade = (
            self._road_weights(level, origin, size_m),
            self._shade(level, origin, size_m),
        )
        if weights is None:
            return (
                grass
                if shade is None
                else cv2.multiply(
                    grass, cv2.cvtColor(shade, cv2.COLOR_GRAY2BGRA), scale=1.0 / 255.0
                )
            )
        if shade is not None:
            weights = [cv2.multiply(plane, shade, scale=1.0 / 255.0) for plane in weights]
        paved, green = (cv2.cvtColor(plane, cv2.COLOR_GRAY2BGRA) for plane in weights)
        return cv2.add(
            cv2.multiply(asphalt, paved, scale=1.0 / (ASPHALT * 255.0)),
            cv2.multiply(grass, green, scale=1.0 / 255.0),
        )

    def _road_weights(self, level: int, origin: np.ndarray, size_m: float):
        """Two planes (TILE_PX, TILE_PX) uint8, brightness of the paved part and share of the grass; None without a road."""
        road, store = self.road, self._pieces[level // 2]
        near = store.index.near(origin, origin + size_m)
        if len(near) == 0:
            return None
        side = TILE_PX * SUPERSAMPLES
        texel_m = size_m / side
        right, left = road.right_edge_m, road.left_edge_m
        # fillConvexPoly paints the boundary too, half a sample beyond the polygon on either side.
        edge = cv2.LINE_8 if level < 2 else cv2.LINE_AA
        line_m = max(LINE_WIDTH_M, 2.0 * texel_m)
        half_m = 0.5 * (line_m - texel_m)
        inset_m = half_m + 1.5 * texel_m
        ink = ASPHALT + (PAINT - ASPHALT) * LINE_WIDTH_M / line_m
        paint, asphalt, track = (int(255 * brightness) for brightness in (ink, ASPHALT, TRACK))
        # Painted first to last. From the roadway on (ROADWAY), a stretch of road at a time. The first two leave so much grass:
        grass = (140, 0)
        bands = [
            (right - MARGIN_M - 1.1, left + MARGIN_M + 1.1, int(255 * 0.22)),
            (right - MARGIN_M - 0.25, left + MARGIN_M + 0.25, int(255 * KERB)),
            (right - MARGIN_M, left + MARGIN_M, asphalt),
            (right - half_m, right + half_m, paint),
            (left - half_m, left + half_m, paint),
            (right + inset_m, left - inset_m, asphalt),
        ]
        if level < 3:
            bands += [
                (at - 0.22, at + 0.22, track)
                for at in (-0.75, 0.75, road.lane_width_m - 0.75, road.lane_width_m + 0.75)
            ]

        low, high = np.array([band[:2] for band in bands]).T

        def outlines(pieces, low, high):
            """Quadrilaterals (B, P, 4, 2) of those bands of those pieces, and which of them touch the canvas (B, P)."""
            low, high = low[:, None, None] / texel_m, high[:, None, None] / texel_m
            start, end = (
                (store.start[pieces] - origin) / texel_m,
                (store.end[pieces] - origin) / texel_m,
            )
            start_left, end_left = store.start_left[pieces], store.end_left[pieces]
            a, b, c, d = corners = [
                _fixed(point + aside * left)
                for point, aside, left in (
                    (start, low, start_left),
                    (end, low, end_left),
                    (end, high, end_left),
                    (start, high, start_left),
                )
            ]
            least, most = (
                np.minimum(np.minimum(a, b), np.minimum(c, d)),
                np.maximum(np.maximum(a, b), np.maximum(c, d)),
            )
            touch = (most >= 0) & (least <= side << FIXED_POINT_BITS)
            return np.stack(corners, axis=2), touch[..., 0] & touch[..., 1]

        pieces = near[outlines(near, low[:1], high[:1])[1][0]]  # the first band holds all others
        if len(pieces) == 0:
            return None
        quads, seen = outlines(pieces, low, high)
        folded = store.tangled(pieces, low, high)
        canvas, green = np.zeros((side, side), np.uint8), np.full((side, side), 255, np.uint8)

        def lay(band, rows, onto, value):
            own, tangled = quads[band], folded[band]
            for k in rows[seen[band, rows]].tolist():
                if tangled[k]:
                    cv2.fillPoly(onto, own[k : k + 1], value, edge, FIXED_POINT_BITS)
                else:
                    cv2.fillConvexPoly(onto, own[k], value, edge, FIXED_POINT_BITS)

        every = np.arange(len(pieces))
        for band in range(ROADWAY):
            lay(band, every, canvas, bands[band][2])
        for band, share in enumerate(grass):
            lay(band, every, green, share)
        # Over the edge lines of one pass goes the roadway of every other; a later pass also hides earlier dashes.
        # The last piece of a stretch may reach into the next one's dashes.
        stretch = store.stretch[pieces]
        numbers = np.unique(
            np.concatenate([stretch, np.intersect1d(stretch + 1, store.stretch[near])])
        )
        s = (
            STRETCH_M * numbers[:, None, None]
            + DASH_PERIOD_M * np.arange(2)[:, None]
            + DASH_LENGTH_M * np.linspace(0.0, 1.0, 4)
        )
        points, normals = road.at(s.ravel())
        rims = [
            (((points + (road.centre_line_m + side_m) * normals) - origin) / texel_m).reshape(
                s.shape + (2,)
            )
            for side_m in (-half_m, half_m)
        ]
        dashes = _fixed(
            np.stack(
                [rims[0][:, :, :-1], rims[0][:, :, 1:], rims[1][:, :, 1:], rims[1][:, :, :-1]],
                axis=3,
            )
        )
        ends = s[..., [0, -1]]
        repeated = road.repeats[np.minimum(np.searchsorted(road.s_m, ends), len(road.s_m) - 1)].all(
            axis=-1
        )
        exists = (ends[..., 0] >= road.s_m[0]) & (ends[..., 1] <= road.s_m[-1]) & ~repeated
        for n, number in enumerate(numbers):
            rows = np.flatnonzero(stretch == number)
            for band in range(ROADWAY, len(bands)):
                lay(band, rows, canvas, bands[band][2])
            for quad in dashes[n][exists[n]].reshape(-1, 4, 2):
                cv2.fillConvexPoly(canvas, quad, paint, edge, FIXED_POINT_BITS)
        return halve(canvas), halve(green)

    def _shade(self, level: int, origin: np.ndarray, size_m: float):
        """(TILE_PX, TILE_PX) uint8 factor of the shadows of trees and buildings, or None where none falls."""
        if len(self.scenery) == 0:
            return None
        near = self._shadows.near(origin, origin + size_m)
        near = near[
            np.all(
                (self._shadow_low[near] <= origin + size_m) & (self._shadow_high[near] >= origin),
                axis=1,
            )
        ]
        if len(near) == 0:
            return None
        shade = np.full((TILE_PX, TILE_PX), 255, np.uint8)
        scale = TILE_PX / size_m
        for item in near.tolist():
            for outline in self._outlines[item]:
                cv2.fillPoly(
                    shade,
                    [_fixed((outline - origin) * scale)],
                    int(255 * SHADE),
                    cv2.LINE_AA,
                    FIXED_POINT_BITS,
                )
        if int(shade.min()) == 255:
            return None
        return cv2.blur(shade, (5, 5)) if level < 2 else shade


class Ground:
    """Paints the rows of the picture from the horizon down. `horizon_sky`: the sky's row (1, width, 4) above the horizon."""

    def __init__(self, road: Road, scenery, cam: CameraModel, seed: int):
        self.camera = cam
        self.tiles = _Tiles(road, scenery, seed)
        self._windows = [
            [
                None,
                np.zeros((WINDOW_TILES, WINDOW_TILES), bool),
                np.zeros((WINDOW_TILES * TILE_PX, WINDOW_TILES * TILE_PX, 4), np.uint8),
            ]
            for _ in SUBROWS
        ]
        self._plan_rows()

    def _plan_rows(self) -> None:
        """Which rows sample which resolution where; all of it depends on the camera only."""
        cam = self.camera
        f, h = cam.focal_px, cam.mount_z_m
        c, s = np.cos(cam.pitch_rad), np.sin(cam.pitch_rad)
        side = np.tan(cam.fov_rad / 2.0)

        def ray(v):
            y = (v - cam.height / 2.0) / f
            t = h / np.maximum(s + y * c, 1e-9)
            return t * (c - y * s), t / f

        rows = np.arange(cam.height)
        distance, _ = ray(rows.astype(float))
        tile_m = FINEST_TEXEL_M * TILE_PX * 2.0 ** np.arange(len(SUBROWS))
        far = 0.84 * tile_m / np.hypot(side, 0.25)
        level = np.searchsorted(far, distance)
        self._first_ground_row = cam.first_ground_row
        self._first_tiled_row = int(np.flatnonzero(level < len(SUBROWS))[0])
        self._bands = []
        forward, spread, start = [], [], 0
        for k, count in enumerate(SUBROWS):
            own = rows[level == k]
            if len(own) == 0:
                continue
            sub = (own[None, :] + (np.arange(count)[:, None] + 0.5) / count - 0.5).ravel()
            d, w = ray(np.maximum(sub, cam.horizon_px + 0.3))
            near, deep = float(d.min()), float(d.max())
            self._bands.append((k, int(own[0]), int(own[-1]) + 1, count, start, near, deep))
            forward.append(d)
            spread.append(w)
            start += len(sub)
        self._forward, self._spread = np.concatenate(forward), np.concatenate(spread)
        self._near, self._deep = (
            np.array([b[k] for b in self._bands])[:, None, None] for k in (5, 6)
        )
        self._level_of_row = np.concatenate(
            [np.full((b[2] - b[1]) * b[3], n) for n, b in enumerate(self._bands)]
        )
        columns = -(-cam.width // 2)  # each stands for two of the picture
        middle = (np.arange(columns) + 0.5) * cam.width / columns - 0.5
        self._columns = np.stack([np.ones(columns), middle - cam.width / 2.0]).astype(np.float32)
        self._map_x = np.empty((start, columns), np.float32)
        self._map_y = np.empty_like(self._map_x)
        self._sub = np.empty((start, columns, 4), np.uint8)
        self._side = side * (1.0 + 1.0 / cam.width)

        haze = np.minimum(1.0 - np.exp(-distance / HAZE_RANGE_M), 0.55)
        self._far_bgra = tuple(GRASS_BGR) + (255.0,)
        self._hazy = slice(self._first_ground_row, int(np.flatnonzero(distance > 35.0)[-1]) + 1)
        clear = np.broadcast_to(
            (1.0 - haze[self._hazy])[:, None, None], (len(haze[self._hazy]), cam.width, 4)
        )
        veil = clear * 0.0 + np.append(HAZE_BGR * 0.82, 0.0) * haze[self._hazy][:, None, None]
        self._clear, self._veil = (
            np.round(255 * clear).astype(np.uint8),
            np.round(veil).astype(np.uint8),
        )
        self._clear[..., 3] = 255

    def draw(
        self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float, horizon_sky: np.ndarray
    ) -> None:
        cam = self.camera
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        eye = cam.position_in_map(x_m, y_m, yaw_rad)[:2]
        heading = np.array([c, s])
        texel = FINEST_TEXEL_M * 2.0 ** np.array([b[0] for b in self._bands])
        reach = np.array([0.5 * (b[5] + b[6]) for b in self._bands])
        tile_m = texel * TILE_PX
        corner = (
            np.floor((eye + reach[:, None] * heading) / tile_m[:, None]).astype(np.int64)
            - WINDOW_TILES // 2
        )
        self._fill_windows(corner, tile_m, eye, heading)

        origin = (eye - corner * tile_m[:, None])[self._level_of_row]
        scale = 1.0 / texel[self._level_of_row]
        ax = (origin[:, 0] + c * self._forward) * scale - 0.5
        ay = (origin[:, 1] + s * self._forward) * scale - 0.5
        rows_x = np.stack([ax, s * self._spread * scale], axis=1).astype(np.float32)
        rows_y = np.stack([ay, -c * self._spread * scale], axis=1).astype(np.float32)
        cv2.gemm(rows_x, self._columns, 1.0, None, 0.0, dst=self._map_x)
        cv2.gemm(rows_y, self._columns, 1.0, None, 0.0, dst=self._map_y)

        picture[self._first_ground_row : self._first_tiled_row] = self._far_bgra
        for level, first, last, count, start, _, _ in self._bands:
            rows = last - first
            part = slice(start, start + rows * count)
            target = self._sub[part]
            cv2.remap(
                self._windows[level][2],
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
                (cam.width, rows),
                dst=picture[first:last],
                interpolation=cv2.INTER_LINEAR,
            )
        hazy = picture[self._hazy]
        cv2.add(cv2.multiply(hazy, self._clear, scale=1.0 / 255.0), self._veil, dst=hazy)
        row = self._first_ground_row
        share = float(np.clip(row + 0.5 - cam.horizon_px, 0.0, 1.0))
        if row > 0 and share < 1.0:
            cv2.addWeighted(
                picture[row : row + 1],
                share,
                horizon_sky,
                1.0 - share,
                0.0,
                dst=picture[row : row + 1],
            )

    def _fill_windows(
        self, corner: np.ndarray, tile_m: np.ndarray, eye: np.ndarray, heading: np.ndarray
    ) -> None:
        """Copy into each level's window the tiles that its band of rows can touch."""
        near, deep = self._near, self._deep
        side_m = tile_m[:, None, None]
        step = np.arange(WINDOW_TILES) + 0.5
        x = (corner[:, 0, None, None] + step[None, None, :]) * side_m - eye[0]
        y = (corner[:, 1, None, None] + step[None, :, None]) * side_m - eye[1]
        ahead, aside = heading[0] * x + heading[1] * y, heading[0] * y - heading[1] * x
        reach = 0.52 * (abs(heading[0]) + abs(heading[1])) * side_m
        slant = 0.52 * np.hypot(1.0, self._side) * np.sqrt(2.0) * side_m
        seen = (
            (ahead + reach >= near)
            & (ahead - reach <= deep)
            & (np.abs(aside) - self._side * ahead <= slant)
        )
        for band, (level, *_) in enumerate(self._bands):
            window = self._windows[level]
            key = (int(corner[band, 0]), int(corner[band, 1]))
            if window[0] != key:
                window[0] = key
                window[1][:] = False
            missing = seen[band] & ~window[1]
            if not missing.any():
                continue
            for row, column in np.argwhere(missing):
                window[2][
                    row * TILE_PX : (row + 1) * TILE_PX, column * TILE_PX : (column + 1) * TILE_PX
                ] = self.tiles.tile(level, key[0] + int(column), key[1] + int(row))
                window[1][row, column] = True
