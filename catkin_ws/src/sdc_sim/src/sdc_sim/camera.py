"""The picture of the front camera: a pinhole camera over a flat world with a road, scenery and boxes.

`CameraModel` is the geometry (where a point of the map falls in the picture), `Renderer` draws. Pixel centres are at
integer coordinates; the principal point is (w/2, h/2) and fx = fy = w / (2 tan(fov/2)), as the CARLA bridge gives
them in its camera_info. The optical frame is that of REP 103: x right, y down, z along the view.

How the ground is drawn. The map is cut into square tiles at six resolutions, 2.5 cm to 80 cm a texel; a tile is
rasterised when first seen and depends on nothing but its place, so that a picture does not depend on the ones before.
Each band of rows samples the resolution that suits its distance, several times a row where a row spans metres of
ground, and averages: that is what keeps the distance from shimmering (texture mip-mapping, Williams 1983, with
anisotropic sampling along the view).
"""
from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass

import cv2
import numpy as np

from .road import DASH_LENGTH_M, DASH_PERIOD_M, LINE_WIDTH_M, MARGIN_M, CellIndex, Road

# ------------------------------------------------------------------ geometry


@dataclass(frozen=True)
class CameraModel:
    """A pinhole camera on a car that stands level on the ground plane z = 0.

    `mount_x_m` ahead of the vehicle's centre, `mount_z_m` above the ground, `pitch_rad` positive nose down.
    """

    width: int = 640
    height: int = 480
    fov_rad: float = np.pi / 2.0
    mount_x_m: float = 0.7
    mount_z_m: float = 1.7
    pitch_rad: float = np.pi / 360.0

    def __post_init__(self):
        if not (self.width >= 16 and self.height >= 16 and self.width % 2 == 0):
            raise ValueError(f"picture of {self.width} x {self.height}: at least 16 x 16 with an even width")
        if not (0.1 < self.fov_rad < 2.4 and self.mount_z_m > 0.1 and abs(self.pitch_rad) < 0.3):
            raise ValueError("camera: fov_rad in 0.1..2.4, mount_z_m above 0.1, pitch_rad within 0.3")

    @property
    def focal_px(self) -> float:
        """fx = fy, pixels."""
        return self.width / (2.0 * np.tan(self.fov_rad / 2.0))

    @property
    def horizon_px(self) -> float:
        """Row of the horizon, pixels (fractional)."""
        return self.height / 2.0 - self.focal_px * np.tan(self.pitch_rad)

    def intrinsic_matrix(self) -> np.ndarray:
        """K (3, 3), pixels."""
        f = self.focal_px
        return np.array([[f, 0.0, self.width / 2.0], [0.0, f, self.height / 2.0], [0.0, 0.0, 1.0]])

    def vehicle_from_optical(self) -> np.ndarray:
        """Rotation (3, 3) that turns a vector of the optical frame into the vehicle frame (x forward, z up)."""
        c, s = np.cos(self.pitch_rad), np.sin(self.pitch_rad)
        return np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])

    def position_in_map(self, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Position (3,) of the camera in the map for a vehicle at that pose, metres."""
        return np.array([x_m + self.mount_x_m * np.cos(yaw_rad), y_m + self.mount_x_m * np.sin(yaw_rad),
                         self.mount_z_m])

    def optical_from_map(self, points_m, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Points (..., 3) of the map in the optical frame of a vehicle at that pose, metres."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        map_from_vehicle = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        offset = np.asarray(points_m, float) - self.position_in_map(x_m, y_m, yaw_rad)
        return offset @ (map_from_vehicle @ self.vehicle_from_optical())

    def project(self, points_m, x_m: float, y_m: float, yaw_rad: float) -> tuple:
        """Pixels (N, 2) as (u, v) of `points_m` (N, 3) in the map, and the mask (N,) of those in front.

        Pixels of points that are not in front (less than 1 cm along the view) are NaN.
        """
        p = self.optical_from_map(np.asarray(points_m, float).reshape(-1, 3), x_m, y_m, yaw_rad)
        front = p[:, 2] > 0.01
        pixels = np.full((len(p), 2), np.nan)
        pixels[front] = self.focal_px * p[front, :2] / p[front, 2:] + [self.width / 2.0, self.height / 2.0]
        return pixels, front


KINDS = ("car", "pedestrian", "obstacle", "light")


@dataclass(frozen=True)
class Box:
    """A body on the ground: centre `x_m`, `y_m` and `yaw_rad` in the map, size in metres, colour (b, g, r) 0..255.

    `kind`: 'car', 'pedestrian', 'obstacle' (a plain box) or 'light' (a traffic light `height_m` high whose lamps look
    along `yaw_rad`; `colour_bgr` is that of the lamp which is lit).
    """

    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float = 4.7
    width_m: float = 2.0
    height_m: float = 1.45
    colour_bgr: tuple = (40, 40, 160)
    kind: str = "car"

    def __post_init__(self):
        if not np.all(np.isfinite([self.x_m, self.y_m, self.yaw_rad])):
            raise ValueError(f"box: pose ({self.x_m}, {self.y_m}, {self.yaw_rad}) is not finite")
        if not all(np.isfinite(v) and v > 0 for v in (self.length_m, self.width_m, self.height_m)):
            raise ValueError("box: length_m, width_m and height_m must be positive")
        if self.kind not in KINDS:
            raise ValueError(f"box: kind '{self.kind}' is none of {', '.join(KINDS)}")


# ------------------------------------------------------------------ ground

TILE_PX = 256
WINDOW_TILES = 3
FINEST_TEXEL_M = 0.025
SUBROWS = (1, 2, 4, 8, 4, 4)        # samples a row, one entry a resolution; powers of two
SUPERSAMPLES = 2                    # of a texel, either way, when a tile is rasterised
CACHED_TILES = 96
FIXED_POINT_BITS = 4
ROADWAY = 5                         # bands of a tile painted before the roadway
GRASS_BGR = np.array([50.0, 104.0, 92.0])
ASPHALT_BGR = np.array([88.0, 85.0, 83.0])
HAZE_BGR = np.array([214.0, 202.0, 190.0])
ASPHALT, PAINT, KERB, TRACK = 0.40, 1.0, 0.66, 0.365  # brightness, as parts of paint
SHADOW_M_PER_M = np.array([0.55, -0.45])              # shadow of a thing one metre high
SHADE = 0.58


def _lattice_noise(seed: int, octave: int, size_px: int, repeats: int) -> np.ndarray:
    """Smooth periodic noise (size_px, size_px) of unit variance; equal seed and octave give the same pattern."""
    lattice = np.random.RandomState(seed * 1009 + octave + 64).normal(size=(32, 32)).astype(np.float32)
    padded = np.pad(np.tile(lattice, (repeats, repeats)), 2, mode="wrap")
    scale = size_px // (32 * repeats)
    big = cv2.resize(padded, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    noise = big[2 * scale:2 * scale + size_px, 2 * scale:2 * scale + size_px]
    return noise / noise.std()


def _ground_textures(level: int, seed: int) -> tuple:
    """Grass and asphalt (512, 512, 4) BGRA, periodic; neighbouring levels share all but one octave of the noise."""
    size = 2 * TILE_PX
    octaves = [_lattice_noise(seed, level - k, size, 2 ** k) for k in (0, 1, 2)]
    grain = np.random.RandomState(seed + 7 * level).normal(size=(size, size)).astype(np.float32)
    fine = (1.0, 0.8, 0.6, 0.4, 0.25, 0.15)[level]
    blades = 0.075 * octaves[0] + fine * (0.07 * octaves[1] + 0.07 * octaves[2]) + (0.06 * grain if level < 2 else 0.0)
    hue = 0.05 * octaves[1] + 0.04 * octaves[0]
    grass = GRASS_BGR * (1.0 + blades[..., None] + hue[..., None] * np.array([-0.6, 0.0, 0.9]))
    stone = 0.022 * octaves[0] + fine * (0.022 * octaves[1] + 0.028 * octaves[2])
    stone = stone + (0.075, 0.03, 0.01, 0.0, 0.0, 0.0)[level] * grain
    asphalt = ASPHALT_BGR * (1.0 + stone[..., None])
    return tuple(cv2.cvtColor(np.clip(t, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA) for t in (grass, asphalt))


def _halve(image: np.ndarray) -> np.ndarray:
    return cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


class _Ground:
    """Tiles of the ground by (level, column, row), rasterised when asked for, the last CACHED_TILES of them kept."""

    def __init__(self, road: Road, scenery, seed: int):
        self.road = road
        self.scenery = scenery
        self.textures = [_ground_textures(level, seed) for level in range(len(SUBROWS))]
        self.cache = OrderedDict()
        self._pieces = [self._index_pieces(road.stations(*limits)) for limits in ((0.004,), (0.015,), (0.05, 24.0))]
        if len(scenery):
            self._outline_shadows(seed)

    def _index_pieces(self, stations: np.ndarray) -> tuple:
        """First and last samples of the pieces (P, 2) to draw, those of repeated laps left out, and where they are."""
        stations = np.column_stack([stations[:-1], stations[1:]])
        stations = stations[~self.road.repeats[stations].all(axis=1)]
        ends = self.road.points_m[stations]
        reach = self.road.left_edge_m + 2.0
        low, high = ends.min(axis=1) - reach, ends.max(axis=1) + reach
        return stations, CellIndex(low, high, max(32.0, float(np.max(high - low)) / 2.0 + 0.1))

    def _outline_shadows(self, seed: int) -> None:
        """Crown outlines (N, 18, 2) and bounding boxes of the shadows that the scenery casts on the ground."""
        position, height = self.scenery.position_m, self.scenery.size_m[:, 2:]
        angle = np.linspace(0.0, 2.0 * np.pi, 18, endpoint=False)
        wobble = np.random.RandomState(seed + 3).uniform(0.85, 1.12, (256, 18))[self.scenery.variant]
        away = SHADOW_M_PER_M / np.hypot(*SHADOW_M_PER_M)
        ring = 0.42 * np.cos(angle)[:, None] * away + 0.30 * np.sin(angle)[:, None] * [-away[1], away[0]]
        crown = position + 0.62 * height * SHADOW_M_PER_M
        self._crowns = crown[:, None] + height[..., None] * wobble[..., None] * ring
        reach = (0.6 * np.max(self.scenery.size_m, axis=1) + 1.0)[:, None]
        tip = position + height * SHADOW_M_PER_M
        self._shadow_low, self._shadow_high = np.minimum(position, tip) - reach, np.maximum(position, tip) + reach
        self._shadows = CellIndex(self._shadow_low, self._shadow_high, 32.0)

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
        size_m = FINEST_TEXEL_M * 2 ** level * TILE_PX
        origin = np.array([column, row]) * size_m
        part = np.s_[row % 2 * TILE_PX:(row % 2 + 1) * TILE_PX, column % 2 * TILE_PX:(column % 2 + 1) * TILE_PX]
        grass, asphalt = (texture[part] for texture in self.textures[level])
        weights = self._road_weights(level, origin, size_m)
        if weights is None:
            tile = grass
        else:
            paved, green = (cv2.merge([plane] * 4) for plane in cv2.split(weights)[:2])
            tile = cv2.add(cv2.multiply(asphalt, paved, scale=1.0 / (ASPHALT * 255.0)),
                           cv2.multiply(grass, green, scale=1.0 / 255.0))
            tile[..., 3] = 255
        shade = self._shade(level, origin, size_m)
        return tile if shade is None else cv2.multiply(tile, shade, scale=1.0 / 255.0)

    def _road_weights(self, level: int, origin: np.ndarray, size_m: float):
        """(TILE_PX, TILE_PX, 3): brightness of the paved part, share of the grass and 0, or None without a road."""
        road = self.road
        stations, index = self._pieces[level // 2]
        pieces = index.near(origin, origin + size_m)
        if len(pieces) == 0:
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
        paint, asphalt, track = ((int(255 * brightness), 0, 0) for brightness in (ink, ASPHALT, TRACK))
        # Painted first to last. From the roadway on (ROADWAY), a stretch of road at a time.
        bands = [(right - MARGIN_M - 1.1, left + MARGIN_M + 1.1, (int(255 * 0.22), 140, 0)),
                 (right - MARGIN_M - 0.25, left + MARGIN_M + 0.25, (int(255 * KERB), 0, 0)),
                 (right - MARGIN_M, left + MARGIN_M, asphalt),
                 (right - half_m, right + half_m, paint), (left - half_m, left + half_m, paint),
                 (right + inset_m, left - inset_m, asphalt)]
        if level < 3:
            bands += [(at - 0.22, at + 0.22, track)
                      for at in (-0.75, 0.75, road.lane_width_m - 0.75, road.lane_width_m + 0.75)]

        def fixed(points):
            return np.round(((points - origin) / texel_m - 0.5) * 2 ** FIXED_POINT_BITS).astype(np.int32)

        first, last = stations[pieces].T
        p0, p1, l0, l1 = (a[None] for a in (road.points_m[first], road.points_m[last],
                                            road.left[first], road.left[last]))
        low, high = (np.array([band[k] for band in bands])[:, None, None] for k in (0, 1))
        corners = np.stack([p0 + low * l0, p1 + low * l1, p1 + high * l1, p0 + high * l0], axis=2)
        quads = fixed(corners)
        seen = np.all((quads.max(axis=2) >= 0) & (quads.min(axis=2) <= side << FIXED_POINT_BITS), axis=2)
        if not seen[0].any():
            return None
        folded = np.minimum(np.sum((corners[:, :, 1] - corners[:, :, 0]) * (p1 - p0), axis=2),
                            np.sum((corners[:, :, 2] - corners[:, :, 3]) * (p1 - p0), axis=2)) < 0.0
        canvas = np.zeros((side, side, 3), np.uint8)  # OpenCV is quick with three channels and slow with two
        cv2.rectangle(canvas, (0, 0), (side, side), (0, 255, 0), -1)

        def lay(band, rows):
            colour, own, tangled = bands[band][2], quads[band], folded[band]
            for k in rows[seen[band, rows]]:
                if tangled[k]:
                    cv2.fillPoly(canvas, own[k:k + 1], colour, edge, FIXED_POINT_BITS)
                else:
                    cv2.fillConvexPoly(canvas, own[k], colour, edge, FIXED_POINT_BITS)

        every = np.arange(len(pieces))
        for band in range(ROADWAY):
            lay(band, every)
        # Over the edge lines of one pass goes the roadway of every other; a later pass also hides earlier dashes.
        # A stretch ends between two dashes, so that no piece of roadway cuts a dash of its own pass.
        stretch_m = 2.0 * DASH_PERIOD_M
        stretch = np.floor((road.s_m[first] + DASH_LENGTH_M) / stretch_m).astype(np.int64)
        numbers, starts = np.unique(stretch, return_index=True)
        s = (stretch_m * numbers[:, None, None] + DASH_PERIOD_M * np.arange(2)[:, None]
             + DASH_LENGTH_M * np.linspace(0.0, 1.0, 4))
        points, normals = road.at(s.ravel())
        rims = [(points + (road.centre_line_m + side_m) * normals).reshape(s.shape + (2,))
                for side_m in (-half_m, half_m)]
        dashes = fixed(np.stack([rims[0][:, :, :-1], rims[0][:, :, 1:], rims[1][:, :, 1:], rims[1][:, :, :-1]], axis=3))
        exists = (s[..., 0] >= road.s_m[0]) & (s[..., -1] <= road.s_m[-1])
        for n, rows in enumerate(np.split(every, starts[1:])):
            for band in range(ROADWAY, len(bands)):
                lay(band, rows)
            for quad in dashes[n][exists[n]].reshape(-1, 4, 2):
                cv2.fillConvexPoly(canvas, quad, paint, edge, FIXED_POINT_BITS)
        return _halve(canvas)

    def _shade(self, level: int, origin: np.ndarray, size_m: float):
        """(TILE_PX, TILE_PX, 4) factor of the shadows of trees and buildings, or None where none falls."""
        if len(self.scenery) == 0:
            return None
        near = self._shadows.near(origin, origin + size_m)
        near = near[np.all((self._shadow_low[near] <= origin + size_m) & (self._shadow_high[near] >= origin), axis=1)]
        if len(near) == 0:
            return None
        scale = size_m / TILE_PX / (1 << FIXED_POINT_BITS)
        half_px = 0.5 * (1 << FIXED_POINT_BITS)
        shade = np.full((TILE_PX, TILE_PX), 255, np.uint8)
        for i in near:
            position, height = self.scenery.position_m[i], float(self.scenery.size_m[i, 2])
            if self.scenery.kind[i] == 0:
                crown = position + 0.62 * height * SHADOW_M_PER_M
                outlines = [self._crowns[i], np.stack([position - 0.15, position + 0.15, crown + 0.15, crown - 0.15])]
            else:
                base = _footprint(position, self.scenery.yaw_rad[i], self.scenery.size_m[i])
                corners = np.concatenate([base, base + height * SHADOW_M_PER_M]) - position
                outlines = [position + cv2.convexHull(corners.astype(np.float32))[:, 0]]
            for outline in outlines:
                cv2.fillPoly(shade, [np.round((outline - origin) / scale - half_px).astype(np.int32)],
                             int(255 * SHADE), cv2.LINE_AA, FIXED_POINT_BITS)
        if int(shade.min()) == 255:
            return None
        if level < 2:
            shade = cv2.blur(shade, (5, 5))
        return cv2.cvtColor(shade, cv2.COLOR_GRAY2BGRA)


def _footprint(position, yaw_rad: float, size) -> np.ndarray:
    """Corners (4, 2) of a rectangle, counter-clockwise."""
    forward = 0.5 * size[0] * np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
    left = 0.5 * size[1] * np.array([-np.sin(yaw_rad), np.cos(yaw_rad)])
    return np.asarray(position) + np.stack([forward + left, left - forward, -forward - left, forward - left])


# ------------------------------------------------------------------ sky

SKY_COLUMNS = 2048
SKY_TOP_RAD = 0.75
SKY_STEP = 4                        # pixels of the picture to one computed of the sky
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
        noise = _lattice_noise(seed + 31, octave, 1024, 2 ** octave).astype(np.float32)
        cover += weight * cv2.remap(noise, np.mod(x, 1023.0).astype(np.float32), np.mod(y, 1023.0).astype(np.float32),
                                    cv2.INTER_LINEAR)
    cover = np.clip((cover - 0.05) / 0.55, 0.0, 1.0) * np.clip(elevation / 0.16, 0.0, 1.0) * 0.85
    height = (elevation / SKY_TOP_RAD) ** 0.6
    clear = HAZE_BGR + (np.array([216.0, 150.0, 92.0]) - HAZE_BGR) * height[..., None]
    sky = clear + (np.array([246.0, 243.0, 240.0]) - clear) * cover[..., None]
    return cv2.cvtColor(np.clip(sky, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)


def _skyline(seed: int) -> np.ndarray:
    """Far trees and roofs (48, 2 SKY_COLUMNS, 4): premultiplied BGRA, last row at the horizon, SKYLINE_RAD high."""
    rows, columns = 48, 2 * SKY_COLUMNS
    rng = np.random.RandomState(seed + 5)
    angle = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    ridge = sum(rng.uniform(0.6, 1.0) / n ** 0.7 * np.sin(n * angle + rng.uniform(0, 6.3))
                for n in (3, 7, 13, 29, 61, 127, 211, 307))
    wood = np.clip(0.46 + 0.12 * ridge, 0.3, 0.95)
    roofs = np.zeros(columns)
    for _ in range(70):
        at, wide = rng.randint(columns), rng.randint(12, 40)
        roofs[np.arange(at, at + wide) % columns] = rng.uniform(0.35, 0.85)
    image = np.zeros((rows, columns, 4), np.float32)
    height = (np.arange(rows)[::-1, None] + 0.5) / rows
    for top, colour in ((roofs, (168, 160, 152)), (wood, (88, 108, 84))):
        cover = np.clip((top - height) * rows / 1.6 + 0.5, 0.0, 1.0)[..., None]
        colour = np.append(np.array(colour, np.float32), 255.0)
        image += cover * (colour - image)
    return np.clip(image, 0, 255).astype(np.uint8)


# ------------------------------------------------------------------ trees

def _tree_sprite(seed: int) -> np.ndarray:
    """A tree (256, 192, 4), premultiplied BGRA, foot in the middle of the lowest row."""
    rng = np.random.RandomState(seed)
    high, wide = 256, 192
    colour = np.zeros((2 * high, 2 * wide, 3), np.float32)
    alpha = np.zeros((2 * high, 2 * wide), np.uint8)
    trunk = np.array([[180, 511], [204, 511], [199, 300], [187, 300]], np.int32)
    cv2.fillPoly(alpha, [trunk], 255)
    cv2.fillPoly(colour, [trunk], (46, 62, 80))
    cv2.fillPoly(colour, [np.array([[194, 511], [204, 511], [199, 300], [194, 300]], np.int32)], (34, 46, 60))
    tint = rng.uniform(0.85, 1.15, 3) * np.array([44.0, 100.0, 70.0])
    blobs = []
    for _ in range(230):
        angle, radius = rng.uniform(0, 2 * np.pi), np.sqrt(rng.uniform(0, 1))
        x, y = 192 + 142 * radius * np.cos(angle), 170 + 138 * radius * np.sin(angle)
        blobs.append((x, y, rng.uniform(14, 36)))
    for x, y, r in sorted(blobs, key=lambda b: b[2], reverse=True):
        lit = 0.62 + 0.5 * np.clip(0.5 - 0.34 * (x - 192) / 142 - 0.62 * (y - 170) / 138, 0, 1)
        lit *= rng.uniform(0.82, 1.16)
        cv2.circle(alpha, (int(x), int(y)), int(r), 255, -1)
        cv2.circle(colour, (int(x), int(y)), int(r), tuple(0.8 * lit * tint), -1)
        cv2.circle(colour, (int(x - 0.2 * r), int(y - 0.25 * r)), int(0.72 * r), tuple(lit * tint), -1)
    image = np.dstack([colour * (alpha[..., None] / 255.0), alpha.astype(np.float32)])
    return np.clip(_halve(image), 0, 255).astype(np.uint8)


# ------------------------------------------------------------------ solid bodies

SUN = np.array([-0.52, 0.42, 0.74])
NEAR_M = 0.4


class _Mesh:
    """Faces of a body in the unit cube (x, y in -0.5..0.5, z in 0..1): corners, colours and draw order."""

    def __init__(self):
        self.corners, self.colours, self.tinted = [], [], []

    def face(self, corners, colour=None) -> None:
        """A flat face, corners counter-clockwise seen from outside; without a colour it has the body's."""
        corners = list(corners)
        self.corners.append(corners + [corners[-1]] * (8 - len(corners)))
        self.colours.append((1.0, 1.0, 1.0) if colour is None else colour)
        self.tinted.append(colour is None)

    def prism(self, low, high, colour=None, base_z=0.0, top_z=1.0, bottom=False) -> None:
        """A frustum on the rectangle `low` (x0, x1, y0, y1) with the rectangle `high` on top."""
        a = [(low[1], low[2]), (low[1], low[3]), (low[0], low[3]), (low[0], low[2])]
        b = [(high[1], high[2]), (high[1], high[3]), (high[0], high[3]), (high[0], high[2])]
        for k in range(4):
            n = (k + 1) % 4
            self.face([(*a[k], base_z), (*a[n], base_z), (*b[n], top_z), (*b[k], top_z)], colour)
        self.face([(*p, top_z) for p in b], colour)
        if bottom:
            self.face([(*p, base_z) for p in reversed(a)], colour)

    def finish(self) -> _Mesh:
        self.corners = np.array(self.corners, float)
        self.colours = np.array(self.colours, float)
        self.tinted = np.array(self.tinted, bool)
        self.normals = np.cross(self.corners[:, 2] - self.corners[:, 0], self.corners[:, 3] - self.corners[:, 1])
        self.glow = np.where(self.colours.max(axis=1) > 254.0, 1.0, 0.0)
        return self


def _inset(quad, left, right, low, high):
    """The part of a quad (bottom pair, top pair) between the given shares of its width and height."""
    a, b, c, d = (np.array(p, float) for p in quad)

    def at(u, v):
        return tuple((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c))
    return [at(left, low), at(right, low), at(right, high), at(left, high)]


def _car_mesh() -> _Mesh:
    m = _Mesh()
    dark, glass, tyre, rim = (28, 28, 28), (74, 62, 50), (30, 30, 30), (150, 150, 150)
    m.face([(-0.47, -0.46, 0.01), (0.47, -0.46, 0.01), (0.47, 0.46, 0.01), (-0.47, 0.46, 0.01)], (22, 22, 22))
    m.prism((-0.47, 0.47, -0.47, 0.47), (-0.49, 0.49, -0.49, 0.49), dark, 0.10, 0.24)
    m.prism((-0.5, 0.5, -0.49, 0.49), (-0.49, 0.49, -0.5, 0.5), None, 0.22, 0.46)
    m.prism((-0.49, 0.49, -0.5, 0.5), (-0.47, 0.42, -0.46, 0.46), None, 0.46, 0.64)
    for y, out in ((-0.502, -1.0), (0.502, 1.0)):
        for x in (-0.30, 0.31):
            for radius, colour in ((0.072, tyre), (0.045, rim)):
                turn = np.arange(8) * np.pi / 4 * -out
                m.face([(x + radius * np.cos(t), y * (1.0 if colour is tyre else 1.002),
                         0.235 + 3.25 * radius * np.sin(t)) for t in turn], colour)
    for y0, y1 in ((-0.46, -0.26), (0.26, 0.46)):
        m.face([(-0.497, y1, 0.45), (-0.497, y0, 0.45), (-0.487, y0, 0.57), (-0.487, y1, 0.57)], (30, 30, 190))
        m.face([(0.498, y0, 0.42), (0.498, y1, 0.42), (0.48, y1, 0.53), (0.48, y0, 0.53)], (235, 240, 240))
    m.face([(-0.503, 0.13, 0.32), (-0.503, -0.13, 0.32), (-0.5, -0.13, 0.41), (-0.5, 0.13, 0.41)], (220, 225, 225))
    m.face([(0.503, -0.13, 0.26), (0.503, 0.13, 0.26), (0.5, 0.13, 0.34), (0.5, -0.13, 0.34)], (220, 225, 225))
    low, high = (-0.40, 0.22, -0.45, 0.45), (-0.27, 0.04, -0.36, 0.36)
    m.prism(low, high, None, 0.63, 1.0)
    first = len(m.corners) - 5
    panes = [_inset(m.corners[first + k][:4], *share) for k, share in
             ((0, (0.06, 0.94, 0.06, 0.86)), (2, (0.06, 0.94, 0.08, 0.84)))]
    for k in (1, 3):
        panes += [_inset(m.corners[first + k][:4], 0.08, 0.47, 0.10, 0.84),
                  _inset(m.corners[first + k][:4], 0.52, 0.90, 0.10, 0.84)]
    for pane in panes:
        m.face(pane, glass)
    return m.finish()


def _pedestrian_mesh() -> _Mesh:
    m = _Mesh()
    skin, trousers, shoes, hair = (140, 165, 205), (92, 66, 50), (40, 40, 45), (36, 48, 62)
    for y, x in ((-0.2, -0.12), (0.2, 0.12)):
        m.prism((x - 0.2, x + 0.3, y - 0.13, y + 0.13), (x - 0.2, x + 0.2, y - 0.13, y + 0.13), shoes, 0.0, 0.05)
        m.prism((x - 0.17, x + 0.17, y - 0.14, y + 0.14), (-0.2, 0.2, y - 0.17, y + 0.17), trousers, 0.05, 0.50)
    m.prism((-0.22, 0.22, -0.36, 0.36), (-0.24, 0.24, -0.42, 0.42), None, 0.48, 0.78)
    m.prism((-0.24, 0.24, -0.42, 0.42), (-0.1, 0.1, -0.16, 0.16), None, 0.78, 0.84)
    for y in (-0.47, 0.47):
        m.prism((-0.1, 0.1, y - 0.07, y + 0.07), (-0.12, 0.12, y - 0.08, y + 0.08), None, 0.46, 0.80, bottom=True)
    m.prism((-0.13, 0.13, -0.13, 0.13), (-0.2, 0.2, -0.19, 0.19), skin, 0.84, 0.92, bottom=True)
    m.prism((-0.2, 0.2, -0.19, 0.19), (-0.12, 0.12, -0.12, 0.12), hair, 0.92, 1.0)
    return m.finish()


def _obstacle_mesh() -> _Mesh:
    m = _Mesh()
    full = (-0.5, 0.5, -0.5, 0.5)
    m.prism(full, full)
    return m.finish()


def _light_mesh(height_m: float, lit_bgr) -> _Mesh:
    """A traffic light in metres: a pole, a dark head, three lamps towards +x, the one of the lit colour bright."""
    m = _Mesh()
    pole, top = 0.06, height_m
    m.prism((-pole, pole, -pole, pole), (-pole, pole, -pole, pole), (86, 92, 90), 0.0, top - 0.2)
    m.prism((-0.12, 0.14, -0.2, 0.2), (-0.12, 0.14, -0.2, 0.2), (34, 38, 36), top - 1.05, top, bottom=True)
    b, g, r = lit_bgr
    place = 1 if r > 120 and g > 120 else (0 if r >= g else 2)
    for k, unlit in enumerate(((20, 20, 62), (18, 56, 62), (24, 56, 20))):
        z = top - 0.2 - 0.32 * k
        turn = np.arange(8) * np.pi / 4
        m.face([(0.145, 0.12 * np.cos(t), z + 0.12 * np.sin(t)) for t in turn],
               tuple(float(v) for v in lit_bgr) if k == place else unlit)
    return m.finish()


WALLS_BGR = ((172, 196, 214), (150, 168, 190), (196, 204, 208), (140, 152, 178), (176, 186, 182), (128, 148, 196))
ROOFS_BGR = ((56, 66, 120), (70, 72, 84), (60, 84, 128))
GLASS_BGR = (96, 82, 70)


class _Building:
    """The faces of a house or a block of flats in the map, in the order to paint them.

    `polygons` (F + P, 4, 3): first the F faces, then the window panes; `panes[k]` is the slice of those on face k.
    `normals` (F + P, 3) point out, and are 0 for panes; `colours` (F + P, 3) BGR.
    """

    def __init__(self, scenery, item: int):
        self._faces, self._normals, self._colours = [], [], []
        self.panes, panes, tints = {}, [], []
        variant, height_m = int(scenery.variant[item]), float(scenery.size_m[item, 2])
        gabled = scenery.kind[item] == 1
        wall, roof = np.array(WALLS_BGR[variant % 6], float), np.array(ROOFS_BGR[variant % 3], float)
        eaves = 0.6 * height_m if gabled else height_m
        corners = _footprint(scenery.position_m[item], scenery.yaw_rad[item], scenery.size_m[item])
        slopes = self._roof_slopes(corners, eaves, height_m) if gabled else []
        for slope in slopes:
            self._add(slope[::-1], roof, 0.55)
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            shade = self._add([(*a, 0.0), (*b, 0.0), (*b, eaves), (*a, eaves)], wall)
            self._add([(*a, 0.0), (*b, 0.0), (*b, 0.4), (*a, 0.4)], 0.6 * wall)
            if not gabled:
                self._add([(*a, eaves - 0.5), (*b, eaves - 0.5), (*b, eaves), (*a, eaves)], 0.72 * wall)
            quads = _windows(a, b, eaves)
            self.panes[len(self._faces) - 1] = (sum(map(len, panes)), len(quads))
            panes.append(quads)
            tints += [shade * np.array(GLASS_BGR, float)] * len(quads)
        for first, second in ((0, 1), (2, 3)) if gabled else ():
            a, b = self._gables[first], self._gables[second]
            peak = (*(0.5 * (a + b)), height_m)
            self._add([(*a, eaves), (*b, eaves), peak, peak], wall)
        for slope in slopes:
            self._add(slope, roof)
        count = len(self._faces)
        self.panes = {k: slice(count + start, count + start + n) for k, (start, n) in self.panes.items()}
        self.polygons = np.concatenate([np.array(self._faces)] + panes)
        self.normals = np.array(self._normals + [np.zeros(3)] * (len(self.polygons) - count))
        self.colours = np.clip(np.array(self._colours + tints), 0.0, 255.0)

    def _add(self, corners, colour, dim: float = 1.0) -> float:
        quad = np.array(corners, float)
        normal = np.cross(quad[1] - quad[0], quad[2] - quad[0])
        normal /= np.linalg.norm(normal)
        shade = dim * (0.66 + 0.38 * max(0.0, float(normal @ SUN)))
        self._faces.append(quad)
        self._normals.append(normal)
        self._colours.append(colour * shade)
        return shade

    def _roof_slopes(self, corners, eaves: float, height_m: float) -> list:
        """The two slopes of a gable roof with overhangs, its ridge between the middles of the two shorter walls."""
        a, b, c, d = self._gables = corners if np.hypot(*(corners[0] - corners[1])) < \
            np.hypot(*(corners[1] - corners[2])) else np.roll(corners, -1, axis=0)
        ridge = np.array([0.5 * (a + b), 0.5 * (c + d)])
        over = 0.5 * (ridge[0] - ridge[1]) / np.hypot(*(ridge[0] - ridge[1]))
        out = 0.45 * (b - a) / np.hypot(*(b - a))
        return [[(*(p + grow + aside), eaves - 0.25), (*(q - grow + aside), eaves - 0.25),
                 (*(end - grow), height_m), (*(start + grow), height_m)]
                for p, q, start, end, grow, aside in ((b, c, ridge[0], ridge[1], over, out),
                                                      (d, a, ridge[1], ridge[0], -over, -out))]


def _windows(a: np.ndarray, b: np.ndarray, height_m: float) -> np.ndarray:
    """Corners (n, 4, 3) of the windows in the wall from `a` to `b` (2,)."""
    length_m = float(np.hypot(*(b - a)))
    columns, floors = max(1, int(length_m / 2.6)), max(1, int(height_m / 2.9))
    u = (np.arange(columns) + 0.5) * length_m / columns - 0.6
    u, z = (grid.ravel()[:, None] for grid in np.meshgrid(u, 3.0 * np.arange(floors) + 1.0))
    u, z = u + [0.0, 1.2, 1.2, 0.0], z + [0.0, 0.0, 1.3, 1.3]
    return np.concatenate([a + (u / length_m)[..., None] * (b - a), z[..., None]], axis=2)


# ------------------------------------------------------------------ the renderer

TREE_RANGE_M = 120.0
BUILDING_RANGE_M = 190.0
PANES_RANGE_M = 85.0
SHADOW_RANGE_M = 55.0
HAZE_RANGE_M = 420.0
CACHED_BUILDINGS = 256


class Renderer:
    """Draws the road, its surroundings and boxes as the camera of a vehicle sees them.

    The picture depends on the arguments of `render` only, not on what was drawn before. Memory is bounded however
    long the route: CACHED_TILES tiles of 256 kB beside fixed textures. A renderer is for one thread at a time.
    """

    def __init__(self, road: Road, camera_model: CameraModel | None = None, seed: int = 0):
        self.camera = camera_model = CameraModel() if camera_model is None else camera_model
        self.road = road
        self.scenery = road.scenery(seed)
        self._ground = _Ground(road, self.scenery, seed)
        self._windows = [[None, np.zeros((WINDOW_TILES, WINDOW_TILES), bool),
                          np.zeros((WINDOW_TILES * TILE_PX, WINDOW_TILES * TILE_PX, 4), np.uint8)] for _ in SUBROWS]
        self._focal = camera_model.focal_px
        self._plan_rows()
        self._plan_sky(seed)
        if len(self.scenery):
            position = self.scenery.position_m
            self._places = CellIndex(position, position, 128.0)
        self._sprites = [self._pyramid(_tree_sprite(seed + 17 * k)) for k in range(4)]
        self._meshes = {"car": _car_mesh(), "pedestrian": _pedestrian_mesh(), "obstacle": _obstacle_mesh()}
        self._lights = {}
        self._buildings = {}

    def render(self, x_m: float, y_m: float, yaw_rad: float, boxes=(), light: float = 1.0) -> np.ndarray:
        """The picture (height, width, 4) uint8 BGRA, a new array, for a vehicle at that pose (metres, radians).

        `boxes`: the `Box`es to draw, in any order. `light` 0..1 scales the brightness: 1 day, 0 black.
        Raises ValueError for a pose that is not finite or a light outside 0..1.
        """
        if not np.all(np.isfinite([x_m, y_m, yaw_rad])):
            raise ValueError(f"pose ({x_m}, {y_m}, {yaw_rad}) is not finite")
        if not 0.0 <= light <= 1.0:
            raise ValueError(f"light {light} is outside 0..1")
        picture = np.empty((self.camera.height, self.camera.width, 4), np.uint8)
        self._draw_sky(picture, yaw_rad)
        self._draw_ground(picture, x_m, y_m, yaw_rad)
        self._draw_bodies(picture, x_m, y_m, yaw_rad, boxes)
        if light < 1.0:
            picture = cv2.multiply(picture, (light, light, light, 1.0))
        return picture

    # -------------------------------------------------------------- ground

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
        self._first_ground_row = int(np.flatnonzero(rows + 0.5 > cam.horizon_px)[0])
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
        self._near, self._deep = (np.array([b[k] for b in self._bands])[:, None, None] for k in (5, 6))
        self._level_of_row = np.concatenate([np.full((b[2] - b[1]) * b[3], n) for n, b in enumerate(self._bands)])
        self._columns = np.stack([np.ones(cam.width), np.arange(cam.width) - cam.width / 2.0]).astype(np.float32)
        self._map_x = np.empty((start, cam.width), np.float32)
        self._map_y = np.empty_like(self._map_x)
        self._sub = np.empty((start, cam.width, 4), np.uint8)
        self._side = side * (1.0 + 1.0 / cam.width)

        haze = np.minimum(1.0 - np.exp(-distance / HAZE_RANGE_M), 0.55)
        self._far_bgra = tuple(GRASS_BGR) + (255.0,)
        self._hazy = slice(self._first_ground_row, int(np.flatnonzero(distance > 35.0)[-1]) + 1)
        clear = np.broadcast_to((1.0 - haze[self._hazy])[:, None, None], (len(haze[self._hazy]), cam.width, 4))
        veil = clear * 0.0 + np.append(HAZE_BGR * 0.82, 255.0) * haze[self._hazy][:, None, None]
        self._clear, self._veil = np.round(255 * clear).astype(np.uint8), np.round(veil).astype(np.uint8)

    def _draw_ground(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float) -> None:
        cam = self.camera
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        eye = cam.position_in_map(x_m, y_m, yaw_rad)[:2]
        heading = np.array([c, s])
        texel = FINEST_TEXEL_M * 2.0 ** np.array([b[0] for b in self._bands])
        reach = np.array([0.5 * (b[5] + b[6]) for b in self._bands])
        tile_m = texel * TILE_PX
        corner = np.floor((eye + reach[:, None] * heading) / tile_m[:, None]).astype(np.int64) - WINDOW_TILES // 2
        self._fill_windows(corner, tile_m, eye, heading)

        origin = (eye - corner * tile_m[:, None])[self._level_of_row]
        scale = 1.0 / texel[self._level_of_row]
        ax = (origin[:, 0] + c * self._forward) * scale - 0.5
        ay = (origin[:, 1] + s * self._forward) * scale - 0.5
        rows_x = np.stack([ax, s * self._spread * scale], axis=1).astype(np.float32)
        rows_y = np.stack([ay, -c * self._spread * scale], axis=1).astype(np.float32)
        cv2.gemm(rows_x, self._columns, 1.0, None, 0.0, dst=self._map_x)
        cv2.gemm(rows_y, self._columns, 1.0, None, 0.0, dst=self._map_y)

        picture[self._first_ground_row:self._first_tiled_row] = self._far_bgra
        for level, first, last, count, start, _, _ in self._bands:
            rows = last - first
            part = slice(start, start + rows * count)
            target = picture[first:last] if count == 1 else self._sub[part]
            cv2.remap(self._windows[level][2], self._map_x[part], self._map_y[part], cv2.INTER_LINEAR, dst=target,
                      borderMode=cv2.BORDER_REPLICATE)
            while count > 1:
                count //= 2
                half = rows * count
                goal = picture[first:last] if count == 1 else target[:half]
                cv2.addWeighted(target[:half], 0.5, target[half:2 * half], 0.5, 0.0, dst=goal)
        hazy = picture[self._hazy]
        cv2.add(cv2.multiply(hazy, self._clear, scale=1.0 / 255.0), self._veil, dst=hazy)
        hazy[..., 3] = 255
        row = self._first_ground_row
        share = float(np.clip(row + 0.5 - cam.horizon_px, 0.0, 1.0))
        if row > 0 and share < 1.0:
            cv2.addWeighted(picture[row:row + 1], share, self._horizon_sky, 1.0 - share, 0.0, dst=picture[row:row + 1])

    def _fill_windows(self, corner: np.ndarray, tile_m: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> None:
        """Copy into each level's window the tiles that its band of rows can touch."""
        near, deep = self._near, self._deep
        side_m = tile_m[:, None, None]
        step = np.arange(WINDOW_TILES) + 0.5
        x = (corner[:, 0, None, None] + step[None, None, :]) * side_m - eye[0]
        y = (corner[:, 1, None, None] + step[None, :, None]) * side_m - eye[1]
        ahead, aside = heading[0] * x + heading[1] * y, heading[0] * y - heading[1] * x
        reach = 0.52 * (abs(heading[0]) + abs(heading[1])) * side_m
        slant = 0.52 * np.hypot(1.0, self._side) * np.sqrt(2.0) * side_m
        seen = ((ahead + reach >= near) & (ahead - reach <= deep)
                & (np.abs(aside) - self._side * ahead <= slant))
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
                window[2][row * TILE_PX:(row + 1) * TILE_PX, column * TILE_PX:(column + 1) * TILE_PX] = \
                    self._ground.tile(level, key[0] + int(column), key[1] + int(row))
                window[1][row, column] = True

    # -------------------------------------------------------------- sky

    def _plan_sky(self, seed: int) -> None:
        cam = self.camera
        c, s = np.cos(cam.pitch_rad), np.sin(cam.pitch_rad)

        def directions(u, v):
            x, y = np.meshgrid((u - cam.width / 2.0) / cam.focal_px, (v - cam.height / 2.0) / cam.focal_px)
            ahead, up = c - y * s, -(s + y * c)
            return np.arctan2(x, ahead), np.arctan2(up, np.hypot(x, ahead))

        rows = self._first_ground_row
        self._sky_rows = rows
        sky = _panorama(seed)
        self._sky = np.concatenate([sky, sky], axis=1)[:, :SKY_COLUMNS + SKY_COLUMNS // 2 + 4]
        small_rows = min(-(-rows // SKY_STEP), cam.height // SKY_STEP)
        middle = 0.5 * (SKY_STEP - 1)
        azimuth, elevation = directions(SKY_STEP * np.arange(-(-cam.width // SKY_STEP)) + middle,
                                        SKY_STEP * np.arange(small_rows) + middle)
        self._sky_x = (azimuth * SKY_COLUMNS / (2.0 * np.pi)).astype(np.float32)
        self._sky_y = np.clip((1.0 - elevation / SKY_TOP_RAD) * (len(sky) - 1), 0, len(sky) - 1).astype(np.float32)
        line = _skyline(seed)
        self._line = np.concatenate([line, line], axis=1)[:, :3 * SKY_COLUMNS + 4]
        depth = min(rows, int(np.ceil(cam.focal_px * np.tan(SKYLINE_RAD))) + 1)
        self._line_top = rows - depth
        azimuth, elevation = directions(np.arange(cam.width), np.arange(rows - depth, rows))
        self._line_x = (azimuth * SKY_COLUMNS / np.pi).astype(np.float32)
        self._line_y = np.minimum((1.0 - elevation / SKYLINE_RAD) * len(line) - 0.5, len(line) - 1).astype(np.float32)
        self._horizon_sky = np.zeros((1, cam.width, 4), np.uint8)

    def _draw_sky(self, picture: np.ndarray, yaw_rad: float) -> None:
        cam = self.camera
        if self._sky_rows == 0:
            return
        # Columns run to the right, from a quarter turn left of the view at the least.
        turn = np.mod(-yaw_rad, 2.0 * np.pi) / (2.0 * np.pi)
        wrap = 1.0 if turn * SKY_COLUMNS < SKY_COLUMNS / 4 else 0.0
        small = cv2.remap(self._sky, self._sky_x + np.float32((turn + wrap) * SKY_COLUMNS), self._sky_y,
                          cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        rows = SKY_STEP * len(small)
        cv2.resize(small, (cam.width, rows), dst=picture[:rows], interpolation=cv2.INTER_LINEAR)
        line = cv2.remap(self._line, self._line_x + np.float32((turn + wrap) * 2 * SKY_COLUMNS), self._line_y,
                         cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        _blend(picture[self._line_top:self._sky_rows], line)
        self._horizon_sky[:] = picture[self._sky_rows - 1]

    # -------------------------------------------------------------- bodies

    @staticmethod
    def _pyramid(sprite: np.ndarray) -> list:
        levels = [sprite]
        while levels[-1].shape[0] > 8:
            levels.append(_halve(levels[-1]))
        return levels

    def _draw_bodies(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float, boxes) -> None:
        cam = self.camera
        eye = cam.position_in_map(x_m, y_m, yaw_rad)[:2]
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        still = np.zeros(0, np.int64)
        if len(self.scenery):
            still = self._places.near(eye - BUILDING_RANGE_M, eye + BUILDING_RANGE_M)
        position, yaw, size = (a[still] for a in (self.scenery.position_m, self.scenery.yaw_rad, self.scenery.size_m))
        if len(boxes):
            position = np.concatenate([position, [[b.x_m, b.y_m] for b in boxes]])
            yaw = np.concatenate([yaw, [b.yaw_rad for b in boxes]])
            size = np.concatenate([size, [[b.length_m, b.width_m, b.height_m] for b in boxes]])
        if len(position) == 0:
            return
        kind = np.concatenate([self.scenery.kind[still], np.full(len(boxes), 3)])
        radius = 0.5 * np.hypot(size[:, 0], size[:, 1])
        offset = position - eye
        ahead, aside = c * offset[:, 0] + s * offset[:, 1], c * offset[:, 1] - s * offset[:, 0]
        reach = np.where(kind == 0, TREE_RANGE_M, np.where(kind == 3, 400.0, BUILDING_RANGE_M))
        slant = np.hypot(1.0, self._side)
        seen = ((ahead > np.where(kind == 0, 1.0, NEAR_M - radius)) & (ahead < reach)
                & (np.abs(aside) < self._side * ahead + radius * slant))
        rows = np.flatnonzero(seen)
        if len(rows) == 0:
            return
        distance = np.hypot(ahead[rows], aside[rows])
        rows = rows[np.argsort(-distance, kind="stable")]
        forward = np.column_stack([np.cos(yaw[rows]), np.sin(yaw[rows])])
        trim = np.where(kind[rows] == 0, 0.35, 0.5)[:, None]
        along = trim * size[rows, :1] * forward
        across = trim * size[rows, 1:2] * np.column_stack([-forward[:, 1], forward[:, 0]])
        centre = position[rows]
        corners = np.stack([centre + along - across, centre + along + across,
                            centre - along + across, centre - along - across], axis=1)
        view = _View(cam, x_m, y_m, yaw_rad)
        built = rows[(kind[rows] == 1) | (kind[rows] == 2)]
        buildings = self._project_buildings(view, still[built].tolist(), ahead[built])
        loose = rows[kind[rows] == 3]
        bodies = self._project_boxes(view, [boxes[row - len(still)] for row in loose])
        bodies = dict(zip(loose.tolist(), bodies))
        for row in loose[ahead[loose] < SHADOW_RANGE_M]:
            self._draw_shadow(picture, view, boxes[row - len(still)])
        for k in _paint_order(corners, eye, np.array([c, s])):
            row = rows[k]
            if kind[row] == 3:
                self._draw_box(picture, view, bodies[int(row)])
            elif kind[row] == 0:
                self._draw_tree(picture, float(ahead[row]), float(aside[row]), float(size[row, 2]),
                                int(self.scenery.variant[still[row]]))
            else:
                self._draw_building(picture, view, buildings[int(still[row])], float(ahead[row]))

    def _draw_tree(self, picture: np.ndarray, ahead: float, aside: float, height_m: float, variant: int) -> None:
        cam = self.camera
        c, s = math.cos(cam.pitch_rad), math.sin(cam.pitch_rad)
        depth = ahead * c + cam.mount_z_m * s
        scale = self._focal / depth
        foot_u = cam.width / 2.0 - aside * scale
        foot_v = cam.height / 2.0 + scale * (cam.mount_z_m * c - ahead * s)
        high = height_m * scale
        levels = self._sprites[variant % len(self._sprites)]
        level = min(max(0, math.floor(math.log2(levels[0].shape[0] / high) + 0.25)), len(levels) - 1)
        sprite = levels[level]
        per_px = sprite.shape[0] / high
        wide = sprite.shape[1] / per_px
        u0, u1 = max(0, math.floor(foot_u - wide / 2)), min(cam.width, math.ceil(foot_u + wide / 2) + 1)
        v0, v1 = max(0, math.floor(foot_v - high)), min(cam.height, math.ceil(foot_v) + 1)
        if u1 - u0 < 1 or v1 - v0 < 1:
            return
        flip = -1.0 if variant & 4 else 1.0
        inverse = np.array([[flip * per_px, 0.0, (sprite.shape[1] - 1) / 2.0 + flip * per_px * (u0 - foot_u)],
                            [0.0, per_px, sprite.shape[0] - 0.5 + per_px * (v0 - foot_v)]])
        part = cv2.warpAffine(sprite, inverse, (u1 - u0, v1 - v0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        fade = min(1.0, (TREE_RANGE_M - ahead) / 30.0)
        if fade < 1.0:
            part = cv2.multiply(part, (fade, fade, fade, fade))
        _blend(picture[v0:v1, u0:u1], part)

    def _project_buildings(self, view: _View, items: list, ahead: np.ndarray) -> dict:
        """All the buildings of a picture in one go: item -> (building, pixels, near, facing, colours)."""
        buildings = []
        for item in items:
            if item not in self._buildings:
                if len(self._buildings) >= CACHED_BUILDINGS:
                    self._buildings.clear()
                self._buildings[item] = _Building(self.scenery, item)
            buildings.append(self._buildings[item])
        if not buildings:
            return {}
        counts = [len(b.polygons) for b in buildings]
        polygons = np.concatenate([b.polygons for b in buildings])
        colours = np.concatenate([b.colours for b in buildings])
        haze = np.repeat(1.0 - np.exp(-np.maximum(ahead, 0.0) / HAZE_RANGE_M), counts)[:, None]
        colours = (colours + haze * (HAZE_BGR - colours)).tolist()
        facing = ((view.eye - polygons[:, 0]) * np.concatenate([b.normals for b in buildings])).sum(axis=1) > 0.0
        optical = (polygons - view.eye) @ view.turn
        near = optical[..., 2].min(axis=1) < NEAR_M
        if near.any():
            optical[near] = [0.0, 0.0, 1.0]
        pixels = view.pixels(optical)
        ends = np.cumsum(counts)
        return {item: (building, pixels[start:end], near[start:end], np.flatnonzero(facing[start:end]).tolist(),
                       colours[start:end])
                for item, building, start, end in zip(items, buildings, ends - counts, ends)}

    @staticmethod
    def _draw_building(picture: np.ndarray, view: _View, projected: tuple, ahead: float) -> None:
        building, pixels, near, facing, colours = projected
        for k in facing:
            outline = pixels[k]
            if near[k]:
                clipped = _clip_near((building.polygons[k] - view.eye) @ view.turn)
                if clipped is None:
                    continue
                outline = view.pixels(clipped)
            cv2.fillConvexPoly(picture, outline, (*colours[k], 255.0), cv2.LINE_AA, FIXED_POINT_BITS)
            panes = building.panes.get(k)
            if panes is not None and ahead < PANES_RANGE_M:
                whole = list(pixels[panes][~near[panes]])
                if whole:
                    cv2.fillPoly(picture, whole, (*colours[panes.start], 255.0), cv2.LINE_AA, FIXED_POINT_BITS)

    @staticmethod
    def _draw_shadow(picture: np.ndarray, view: _View, box: Box) -> None:
        thin = box.kind == "light"
        base = _footprint((box.x_m, box.y_m), box.yaw_rad,
                          (0.15, 0.15) if thin else (0.96 * box.length_m, 0.96 * box.width_m))
        slope = 0.85 * box.height_m * SHADOW_M_PER_M
        hull = cv2.convexHull(np.concatenate([base, base + slope]).astype(np.float32))[:, 0]
        outline = view.outline(np.column_stack([hull, np.zeros(len(hull))]))
        if outline is None:
            return
        low = np.maximum(outline.min(axis=0) >> FIXED_POINT_BITS, 0)
        high = np.minimum((outline.max(axis=0) >> FIXED_POINT_BITS) + 2, [picture.shape[1], picture.shape[0]])
        if np.any(high <= low):
            return
        factor = np.full((high[1] - low[1], high[0] - low[0], 4), 255, np.uint8)
        dark = int(255 * SHADE)
        cv2.fillConvexPoly(factor, outline - (low << FIXED_POINT_BITS), (dark, dark, dark, 255), cv2.LINE_AA,
                           FIXED_POINT_BITS)
        part = picture[low[1]:high[1], low[0]:high[0]]
        cv2.multiply(part, factor, dst=part, scale=1.0 / 255.0)

    def _project_boxes(self, view: _View, boxes: list) -> list:
        """All the boxes of a picture in one go: for each the outlines, colours and near-plane copies of its faces."""
        meshes = [self._mesh(box) for box in boxes]
        if not meshes:
            return []
        counts = [len(mesh.colours) for mesh in meshes]
        turn = np.array([[[np.cos(b.yaw_rad), np.sin(b.yaw_rad), 0.0], [-np.sin(b.yaw_rad), np.cos(b.yaw_rad), 0.0],
                          [0.0, 0.0, 1.0]] for b in boxes])
        size = np.array([(1.0, 1.0, 1.0) if b.kind == "light" else (b.length_m, b.width_m, b.height_m) for b in boxes])
        place = np.array([(b.x_m, b.y_m, 0.0) for b in boxes])
        paint = np.array([b.colour_bgr for b in boxes], float)
        owner = np.repeat(np.arange(len(boxes)), counts)
        polygons = np.concatenate([(mesh.corners * size[k]) @ turn[k] + place[k] for k, mesh in enumerate(meshes)])
        normals = np.concatenate([(mesh.normals / size[k]) @ turn[k] for k, mesh in enumerate(meshes)])
        normals /= np.sqrt((normals * normals).sum(axis=1))[:, None]
        own = np.concatenate([mesh.colours for mesh in meshes])
        colours = np.where(np.concatenate([mesh.tinted for mesh in meshes])[:, None], paint[owner], own)
        shade = np.maximum(0.62 + 0.42 * np.maximum(normals @ SUN, 0.0), np.concatenate([m.glow for m in meshes]))
        colours = np.minimum(colours * shade[:, None], 255.0).tolist()
        offset = polygons - view.eye
        facing = (normals * offset[:, 0]).sum(axis=1) < 0.0
        optical = offset @ view.turn
        near = optical[..., 2].min(axis=1) < NEAR_M
        pixels = view.pixels(np.where(near[:, None, None], 1.0, optical))
        extent = (pixels.max(axis=1) - pixels.min(axis=1)).max(axis=1)
        facing &= near | (extent > (5 << FIXED_POINT_BITS) // 4)
        depth = (offset.mean(axis=1) ** 2).sum(axis=1)
        drawn = []
        start = 0
        for box, count in zip(boxes, counts):
            faces = start + np.flatnonzero(facing[start:start + count])
            if box.kind == "pedestrian":
                faces = faces[np.argsort(-depth[faces], kind="stable")]
            drawn.append([(pixels[k], optical[k] if near[k] else None, colours[k]) for k in faces.tolist()])
            start += count
        return drawn

    def _mesh(self, box: Box) -> _Mesh:
        if box.kind != "light":
            return self._meshes[box.kind]
        key = (box.height_m, tuple(box.colour_bgr))
        if key not in self._lights:
            if len(self._lights) >= 64:
                self._lights.clear()
            self._lights[key] = _light_mesh(*key)
        return self._lights[key]

    @staticmethod
    def _draw_box(picture: np.ndarray, view: _View, faces: list) -> None:
        for outline, behind, colour in faces:
            if behind is not None:
                clipped = _clip_near(behind)
                if clipped is None:
                    continue
                outline = view.pixels(clipped)
            cv2.fillConvexPoly(picture, outline, (*colour, 255), cv2.LINE_AA, FIXED_POINT_BITS)


class _View:
    """Projection of polygons for one pose, with clipping at the near plane."""

    def __init__(self, camera: CameraModel, x_m: float, y_m: float, yaw_rad: float):
        self.eye = camera.position_in_map(x_m, y_m, yaw_rad)
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        map_from_vehicle = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.turn = map_from_vehicle @ camera.vehicle_from_optical()
        self._focal = camera.focal_px * (1 << FIXED_POINT_BITS)
        self._middle = np.array([camera.width / 2.0, camera.height / 2.0]) * (1 << FIXED_POINT_BITS)

    def pixels(self, optical: np.ndarray) -> np.ndarray:
        return np.round(self._focal * optical[..., :2] / optical[..., 2:] + self._middle).astype(np.int32)

    def outline(self, polygon: np.ndarray):
        """Fixed-point pixels (n, 2) of the visible part of a polygon (m, 3) of the map, or None."""
        optical = (polygon - self.eye) @ self.turn
        if optical[:, 2].min() < NEAR_M:
            optical = _clip_near(optical)
            if optical is None:
                return None
        return self.pixels(optical)


def _clip_near(optical: np.ndarray):
    """The part of a polygon (n, 3) beyond the near plane (Sutherland and Hodgman 1974), or None."""
    kept = []
    previous = optical[-1]
    for point in optical:
        if (point[2] >= NEAR_M) != (previous[2] >= NEAR_M):
            kept.append(previous + (NEAR_M - previous[2]) / (point[2] - previous[2]) * (point - previous))
        if point[2] >= NEAR_M:
            kept.append(point)
        previous = point
    return np.array(kept) if len(kept) >= 3 else None


def _paint_order(corners: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> list:
    """Order to paint upright bodies in, given their footprints (N, 4, 2) counter-clockwise and already far to near.

    One body cannot hide another when a side of the other has the eye in front of it and the whole body behind
    it: then the one behind is painted first (Newell, Newell and Sancha 1972, the plane tests).
    """
    n = len(corners)
    if n < 2:
        return list(range(n))
    edge = np.roll(corners, -1, axis=1) - corners
    normal = np.stack([edge[..., 1], -edge[..., 0]], axis=2)
    level = np.sum(normal * corners, axis=2)
    front = np.sum(normal * eye, axis=2) > level
    height = np.einsum("ifk,jck->ifjc", normal, corners)
    behind = (height <= level[:, :, None, None] + 1e-6).all(axis=3) & front[:, :, None]
    hides = behind.any(axis=1)          # [i, j]: i may hide j, j cannot hide i
    offset = corners - eye
    ahead = np.maximum(offset @ heading, 0.3)
    slope = (heading[0] * offset[..., 1] - heading[1] * offset[..., 0]) / ahead
    low, high = slope.min(axis=1), slope.max(axis=1)
    meet = (low[:, None] < high[None, :]) & (low[None, :] < high[:, None])
    first = hides.T & ~hides & meet     # [j, i]: j must be painted before i
    if not np.any(np.tril(first, -1)):
        return list(range(n))
    order, left = [], np.ones(n, bool)
    waiting = first.sum(axis=0)
    for _ in range(n):
        free = np.flatnonzero(left & (waiting == 0))
        pick = int(free[0]) if len(free) else int(np.flatnonzero(left)[0])
        order.append(pick)
        left[pick] = False
        waiting -= first[pick]
    return order


def _blend(part: np.ndarray, sprite: np.ndarray) -> None:
    """Lay a premultiplied BGRA sprite over a part of the picture."""
    clear = cv2.merge([cv2.bitwise_not(sprite[..., 3])] * 4)
    cv2.add(cv2.multiply(part, clear, scale=1.0 / 255.0), sprite, dst=part)
