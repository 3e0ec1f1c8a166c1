"""Rasterizer of the road for the tiles of the ground: roadway, kerb, lines and dashes."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from sdc_sim.camera.ground_textures import TILE_PX
from sdc_sim.camera.painting import FIXED_POINT_BITS, halve, touching
from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, LINE_WIDTH_M, MARGIN_M, Road
from sdc_sim.road.road_markings import stations

# Brightness as a share of that of paint.
ASPHALT = 0.40
_PAINT, _KERB, _TRACK = 1.0, 0.66, 0.365
_VERGE_BRIGHTNESS = int(255 * 0.22)
# Share of grass in the verge and in the kerb, 0..255.
_GRASS_SHARES = (140, 0)
# Samples of a texel, either way.
_SUPERSAMPLES = 2
SIDE_PX = TILE_PX * _SUPERSAMPLES
# The bands before this one are painted for the whole tile, the others stretch by stretch.
_ROADWAY = 5
_STRETCH_M = 2.0 * DASH_PERIOD_M
_DASHES = 2  # per stretch
# Greatest distance between road and piece, and greatest length of a piece, for levels 2k and 2k+1.
_PIECE_LIMITS_M = ((0.004, 8.0), (0.015, 8.0), (0.05, 24.0))


def fixed_point(points_px: np.ndarray) -> np.ndarray:
    """Return pixels as OpenCV's fixed-point numbers.

    Args:
        points_px: pixels, 0 at the border of the first pixel and not in its middle
    """
    return np.rint((points_px - 0.5) * 2**FIXED_POINT_BITS).astype(np.int32)


class Canvas(NamedTuple):
    """Place and resolution of the canvas of one tile."""

    origin_m: np.ndarray
    texel_m: float
    level: int

    @property
    def line_type(self) -> int:
        """OpenCV's line type for the edges of polygons."""
        return cv2.LINE_8 if self.level < 2 else cv2.LINE_AA

    def pixels(self, points_m: np.ndarray) -> np.ndarray:
        """Return the pixels of points of the map."""
        return (points_m - self.origin_m) / self.texel_m

    def painted_line(self) -> tuple[float, float]:
        """Return half the width of a line as painted [m], and its brightness as a share of paint.

        A line that is narrower than two samples is painted wider and darker.
        """
        # OpenCV paints the boundary too, half a sample beyond the polygon on either side.
        line_m = max(LINE_WIDTH_M, 2.0 * self.texel_m)
        ink = ASPHALT + (_PAINT - ASPHALT) * LINE_WIDTH_M / line_m
        return 0.5 * (line_m - self.texel_m), ink


class _Pieces:
    """The road in straight pieces, without those of repeated laps."""

    def __init__(self, road: Road, samples: np.ndarray):
        ends = np.column_stack([samples[:-1], samples[1:]])
        first, last = ends[~road.repeats[ends].all(axis=1)].T
        # Begins and ends (P, 2) [m], and unit vectors to the left there.
        self.start, self.end = road.points_m[first], road.points_m[last]
        self.start_left, self.end_left = road.left[first], road.left[last]
        # Number of the stretch of _STRETCH_M that it belongs to (P,). Stretches end between two
        # dashes, so that no piece cuts a dash.
        self.stretch = np.floor((road.s_m[first] + DASH_LENGTH_M) / _STRETCH_M).astype(np.int64)
        along = self.end - self.start
        self._length2 = np.sum(along * along, axis=1)
        self._twist = np.sum(along * (self.end_left - self.start_left), axis=1)
        # Corners (P, 2) of rectangles around all bands of a piece [m].
        reach = road.left_edge_m + 2.0
        self.low = np.minimum(self.start, self.end) - reach
        self.high = np.maximum(self.start, self.end) + reach

    def folds(self, pieces: np.ndarray, edges_m: np.ndarray) -> np.ndarray:
        """Return which bands with edges (2, B) fold over themselves in a tight turn (B, P)."""
        along = self._length2[pieces] + edges_m[..., None] * self._twist[pieces]
        return along.min(axis=0) < 0.0

    def quads(self, pieces: np.ndarray, canvas: Canvas, edges_m: np.ndarray) -> np.ndarray:
        """Return the outlines (B, P, 4, 2), fixed point, of bands of pieces on the canvas.

        Args:
            pieces: numbers of the pieces (P,)
            canvas: place and resolution
            edges_m: right and left edges of the bands (2, B) [m]
        """
        right, left = edges_m[..., None, None] / canvas.texel_m
        start, end = canvas.pixels(self.start[pieces]), canvas.pixels(self.end[pieces])
        start_left, end_left = self.start_left[pieces], self.end_left[pieces]
        corners = (
            *(start + right * start_left, end + right * end_left),
            *(end + left * end_left, start + left * start_left),
        )
        return fixed_point(np.stack(corners, axis=2))


class RoadRasterizer:
    """Rasterizer of a road, tile by tile."""

    def __init__(self, road: Road):
        self._road = road
        self._pieces = [_Pieces(road, stations(road, *limits)) for limits in _PIECE_LIMITS_M]

    def weights(
        self, level: int, origin_m: np.ndarray, size_m: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the brightness of the paved part of a tile, and the share of grass.

        Args:
            level: resolution of the tile
            origin_m: lower corner (2,) of the tile [m]
            size_m: width of the tile [m]

        Returns:
            two planes (TILE_PX, TILE_PX) uint8, or None if no road is on the tile
        """
        store = self._pieces[level // 2]
        near = touching(store.low, store.high, origin_m, origin_m + size_m)
        if len(near) == 0:
            return None
        canvas = Canvas(origin_m, size_m / SIDE_PX, level)
        edges_m, brightness, half_line_m, paint = self._bands(canvas)
        quads = store.quads(near, canvas, edges_m)
        folded = store.folds(near, edges_m)
        paved = np.zeros((SIDE_PX, SIDE_PX), np.uint8)
        green = np.full((SIDE_PX, SIDE_PX), 255, np.uint8)

        def fill(band: int, rows: np.ndarray, plane: np.ndarray, value: int) -> None:
            own, folds, colour = quads[band], folded[band], (value,)
            for k in rows.tolist():
                if folds[k]:
                    cv2.fillPoly(plane, own[k : k + 1], colour, canvas.line_type, FIXED_POINT_BITS)
                else:
                    cv2.fillConvexPoly(plane, own[k], colour, canvas.line_type, FIXED_POINT_BITS)

        every = np.arange(len(near))
        for band in range(_ROADWAY):
            fill(band, every, paved, brightness[band])
        for band, share in enumerate(_GRASS_SHARES):
            fill(band, every, green, share)
        # The roadway of one pass covers the edge lines of every other, and the dashes of earlier
        # ones. The last piece of a stretch may reach into the dashes of the next stretch.
        stretch = store.stretch[near]
        numbers = np.unique(stretch)
        for number, dashes in zip(numbers, self._dashes(numbers, canvas, half_line_m)):
            rows = np.flatnonzero(stretch == number)
            for band in range(_ROADWAY, len(brightness)):
                fill(band, rows, paved, brightness[band])
            for quad in dashes:
                cv2.fillConvexPoly(paved, quad, (paint,), canvas.line_type, FIXED_POINT_BITS)
        return halve(paved), halve(green)

    def _bands(self, canvas: Canvas) -> tuple[np.ndarray, list[int], float, int]:
        """Return the strips along the road, in the order in which they are painted.

        Returns:
            right and left edges, positive left of the route (2, B) [m], brightness, 0..255 (B,),
            and of a line as painted half its width [m] and its brightness
        """
        road, texel_m = self._road, canvas.texel_m
        right, left = road.right_edge_m, road.left_edge_m
        half_m, ink = canvas.painted_line()
        inset_m = half_m + 1.5 * texel_m
        paint, asphalt, track = (int(255 * brightness) for brightness in (ink, ASPHALT, _TRACK))
        bands = [
            (right - MARGIN_M - 1.1, left + MARGIN_M + 1.1, _VERGE_BRIGHTNESS),
            (right - MARGIN_M - 0.25, left + MARGIN_M + 0.25, int(255 * _KERB)),
            (right - MARGIN_M, left + MARGIN_M, asphalt),
            (right - half_m, right + half_m, paint),
            (left - half_m, left + half_m, paint),
            (right + inset_m, left - inset_m, asphalt),
        ]
        if canvas.level < 3:
            width = road.lane_width_m
            bands += [
                (y - 0.22, y + 0.22, track) for y in (-0.75, 0.75, width - 0.75, width + 0.75)
            ]
        right_m, left_m, brightness = zip(*bands)
        return np.array([right_m, left_m]), list(brightness), half_m, paint

    def _dashes(self, numbers: np.ndarray, canvas: Canvas, half_line_m: float) -> list[np.ndarray]:
        """Return the outlines (n, 4, 2), fixed point, of the dashes of each stretch."""
        road = self._road
        s = (
            _STRETCH_M * numbers[:, None, None]
            + DASH_PERIOD_M * np.arange(_DASHES)[:, None]
            + DASH_LENGTH_M * np.linspace(0.0, 1.0, 4)
        )
        points, normals = road.at(s.ravel())
        right, left = (
            canvas.pixels(points + (road.centre_line_m + side_m) * normals).reshape(s.shape + (2,))
            for side_m in (-half_line_m, half_line_m)
        )
        outlines = fixed_point(
            np.stack([right[:, :, :-1], right[:, :, 1:], left[:, :, 1:], left[:, :, :-1]], axis=3)
        )
        ends = s[..., [0, -1]]
        samples = np.minimum(np.searchsorted(road.s_m, ends), len(road.s_m) - 1)
        repeated = road.repeats[samples].all(axis=-1)
        exists = (ends[..., 0] >= road.s_m[0]) & (ends[..., 1] <= road.s_m[-1]) & ~repeated
        return [own[kept].reshape(-1, 4, 2) for own, kept in zip(outlines, exists)]
