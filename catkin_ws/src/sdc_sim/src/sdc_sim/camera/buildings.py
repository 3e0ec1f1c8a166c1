"""Houses and blocks of flats of the camera picture."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from sdc_sim.camera.painting import (
    FIXED_POINT_BITS,
    HAZE_BGR,
    HAZE_RANGE_M,
    SUN,
    footprint,
)
from sdc_sim.camera.rasterizer import NEAR_M, PolygonRasterizer, fill
from sdc_sim.road.scenery import (
    EAVES_SHARE,
    HOUSE,
    ROOF_BELOW_EAVES_M,
    ROOF_BEYOND_EAVES_M,
    Scenery,
)

BUILDING_RANGE_M = 190.0
CACHED_BUILDINGS = 256
# Window panes farther away are smaller than a pixel.
_PANES_RANGE_M = 85.0
_WALLS_BGR = (
    (172, 196, 214),
    (150, 168, 190),
    (196, 204, 208),
    (140, 152, 178),
    (176, 186, 182),
    (128, 148, 196),
)
_ROOFS_BGR = ((56, 66, 120), (70, 72, 84), (60, 84, 128))
_GLASS_BGR = (96, 82, 70)


class BuildingPart(NamedTuple):
    """Polygons of one building that have one colour: a face, or all window panes of a face.

    Attributes:
        polygons: corners (P, 4, 3) in the map [m]
        outlines: outlines (P, 4, 2) in the picture, valid where `beyond`
        beyond: whether all of the polygon is beyond the near plane (P,)
        colour: BGRA
    """

    polygons: np.ndarray
    outlines: np.ndarray
    beyond: np.ndarray
    colour: tuple[float, ...]


class BuildingPainter:
    """Painter of the buildings of the scenery."""

    def __init__(self, scenery: Scenery):
        self._scenery = scenery
        self.cache: dict[int, Building] = {}

    def project(
        self, rasterizer: PolygonRasterizer, items: Sequence[int], ahead_m: np.ndarray
    ) -> dict[int, list[BuildingPart]]:
        """Project all buildings of a picture together, which is faster than one by one.

        Args:
            rasterizer: projection for the pose
            items: numbers of the buildings in the scenery
            ahead_m: their distances along the vehicle's heading (len(items),) [m]

        Returns:
            the visible parts of each building, in the order in which they are painted
        """
        drawn: dict[int, list[BuildingPart]] = {item: [] for item in items}
        parts = self._facing_parts([self._building(item) for item in items], rasterizer, ahead_m)
        if not parts:
            return drawn
        optical = np.concatenate([polygons for _, polygons, _ in parts]) - rasterizer.eye
        optical = optical @ rasterizer.rotation
        beyond = optical[..., 2].min(axis=1) >= NEAR_M
        optical[~beyond] = [0.0, 0.0, 1.0]
        outlines = rasterizer.pixels(optical)
        start = 0
        for number, polygons, colour in parts:
            end = start + len(polygons)
            drawn[items[number]].append(
                BuildingPart(polygons, outlines[start:end], beyond[start:end], colour)
            )
            start = end
        return drawn

    def _building(self, item: int) -> Building:
        if item not in self.cache:
            if len(self.cache) >= CACHED_BUILDINGS:
                self.cache.clear()
            self.cache[item] = Building(self._scenery, item)
        return self.cache[item]

    @staticmethod
    def _facing_parts(
        buildings: list[Building], rasterizer: PolygonRasterizer, ahead_m: np.ndarray
    ) -> list[tuple[int, np.ndarray, tuple[float, ...]]]:
        """Return (number of the building, polygons, colour) of all faces that face the camera."""
        if not buildings:
            return []
        counts = [len(building.polygons) for building in buildings]
        polygons = np.concatenate([building.polygons for building in buildings])
        normals = np.concatenate([building.normals for building in buildings])
        facing = np.flatnonzero(((rasterizer.eye - polygons[:, 0]) * normals).sum(axis=1) > 0.0)
        owner = np.repeat(np.arange(len(buildings)), counts)[facing]
        first = np.cumsum(counts) - counts
        colours = np.concatenate([building.colours for building in buildings])[facing]
        haze = (1.0 - np.exp(-np.maximum(ahead_m, 0.0) / HAZE_RANGE_M))[owner, None]
        colours = (colours + haze * (np.tile(HAZE_BGR, 2) - colours)).tolist()
        parts = []
        for face, number, colour in zip(facing.tolist(), owner.tolist(), colours):
            building, own = buildings[number], face - int(first[number])
            parts.append((number, building.polygons[own : own + 1], (*colour[:3], 255.0)))
            panes = building.panes.get(own)
            if panes is not None and ahead_m[number] < _PANES_RANGE_M and len(panes):
                parts.append((number, panes, (*colour[3:], 255.0)))
        return parts

    @staticmethod
    def draw(
        picture: np.ndarray, rasterizer: PolygonRasterizer, parts: Sequence[BuildingPart]
    ) -> None:
        """Paint one building."""
        for polygons, outlines, beyond, colour in parts:
            if len(polygons) > 1:
                if beyond.any():
                    cv2.fillPoly(
                        picture, list(outlines[beyond]), colour, cv2.LINE_AA, FIXED_POINT_BITS
                    )
                continue
            outline = outlines[0] if beyond[0] else rasterizer.outline(polygons[0])
            if outline is not None:
                fill(picture, outline, colour)


class Building:
    """Faces of a building in the map, in the order in which they are painted.

    Attributes:
        polygons: corners of the faces (F, 4, 3) [m]
        normals: unit vectors out of the faces (F, 3)
        colours: BGR of the face and BGR of its window panes (F, 6)
        panes: corners (P, 4, 3) of the window panes of a face, by the number of the face [m]
    """

    def __init__(self, scenery: Scenery, item: int):
        self._faces: list[np.ndarray] = []
        self._normals: list[np.ndarray] = []
        self._colours: list[np.ndarray] = []
        self.panes: dict[int, np.ndarray] = {}
        variant, height_m = int(scenery.variant[item]), float(scenery.size_m[item, 2])
        wall = np.array(_WALLS_BGR[variant % 6], float)
        corners = footprint(scenery.position_m[item], scenery.yaw_rad[item], scenery.size_m[item])
        if scenery.kind[item] == HOUSE:
            self._add_house(corners, height_m, wall, np.array(_ROOFS_BGR[variant % 3], float))
        else:
            self._add_block(corners, height_m, wall)
        self.polygons, self.normals = np.array(self._faces), np.array(self._normals)
        self.colours = np.clip(np.array(self._colours), 0.0, 255.0)

    def _add_house(
        self, corners: np.ndarray, height_m: float, wall: np.ndarray, roof: np.ndarray
    ) -> None:
        eaves_m = EAVES_SHARE * height_m
        # The gables are the two shorter walls.
        if np.hypot(*(corners[0] - corners[1])) < np.hypot(*(corners[1] - corners[2])):
            gables = corners
        else:
            gables = np.roll(corners, -1, axis=0)
        slopes = _roof_slopes(gables, eaves_m, height_m)
        for slope in slopes:
            self._add(slope[::-1], roof, 0.55)
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            self._add_wall(a, b, eaves_m, wall)
            self.panes[len(self._faces) - 1] = _windows(a, b, eaves_m)
        for a, b in (gables[:2], gables[2:]):
            peak = (*(0.5 * (a + b)), height_m)
            self._add([(*a, eaves_m), (*b, eaves_m), peak, peak], wall)
        for slope in slopes:
            self._add(slope, roof)

    def _add_block(self, corners: np.ndarray, height_m: float, wall: np.ndarray) -> None:
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            self._add_wall(a, b, height_m, wall)
            self._add(
                [(*a, height_m - 0.5), (*b, height_m - 0.5), (*b, height_m), (*a, height_m)],
                0.72 * wall,
            )
            self.panes[len(self._faces) - 1] = _windows(a, b, height_m)

    def _add_wall(self, a: np.ndarray, b: np.ndarray, height_m: float, colour: np.ndarray) -> None:
        """Add a wall from `a` to `b` (2,) and its darker base."""
        self._add([(*a, 0.0), (*b, 0.0), (*b, height_m), (*a, height_m)], colour)
        self._add([(*a, 0.0), (*b, 0.0), (*b, 0.4), (*a, 0.4)], 0.6 * colour)

    def _add(
        self, corners: Sequence[Sequence[float]], colour: np.ndarray, dim: float = 1.0
    ) -> None:
        """Add a face, its colour shaded by the sun."""
        quad = np.array(corners, float)
        normal = np.cross(quad[1] - quad[0], quad[2] - quad[0])
        normal /= np.linalg.norm(normal)
        shade = dim * (0.66 + 0.38 * max(0.0, float(normal @ SUN)))
        self._faces.append(quad)
        self._normals.append(normal)
        self._colours.append(np.concatenate([colour * shade, shade * np.array(_GLASS_BGR, float)]))


def _roof_slopes(
    gables: np.ndarray, eaves_m: float, height_m: float
) -> list[list[tuple[float, ...]]]:
    """Return the two slopes of a gable roof with overhangs.

    Args:
        gables: corners (4, 2) of the house; the first and the last two are the ends of the gables
        eaves_m: height of the eaves [m]
        height_m: height of the ridge [m]
    """
    a, b, c, d = gables
    ridge = np.array([0.5 * (a + b), 0.5 * (c + d)])
    over = 0.5 * (ridge[0] - ridge[1]) / np.hypot(*(ridge[0] - ridge[1]))
    out = ROOF_BEYOND_EAVES_M * (b - a) / np.hypot(*(b - a))
    return [
        [
            (*(p + grow + aside), eaves_m - ROOF_BELOW_EAVES_M),
            (*(q - grow + aside), eaves_m - ROOF_BELOW_EAVES_M),
            (*(end - grow), height_m),
            (*(start + grow), height_m),
        ]
        for p, q, start, end, grow, aside in (
            (b, c, ridge[0], ridge[1], over, out),
            (d, a, ridge[1], ridge[0], -over, -out),
        )
    ]


def _windows(a: np.ndarray, b: np.ndarray, height_m: float) -> np.ndarray:
    """Return the corners (n, 4, 3) of the windows in the wall from `a` to `b` (2,) [m]."""
    length_m = float(np.hypot(*(b - a)))
    columns, floors = max(1, int(length_m / 2.6)), max(1, int(height_m / 2.9))
    u = (np.arange(columns) + 0.5) * length_m / columns - 0.6
    u, z = (grid.ravel()[:, None] for grid in np.meshgrid(u, 3.0 * np.arange(floors) + 1.0))
    u, z = u + [0.0, 1.2, 1.2, 0.0], z + [0.0, 0.0, 1.3, 1.3]
    return np.concatenate([a + (u / length_m)[..., None] * (b - a), z[..., None]], axis=2)
