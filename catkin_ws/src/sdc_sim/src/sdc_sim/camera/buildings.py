"""Houses and blocks of flats of the camera picture."""

from __future__ import annotations

from typing import Iterator, Sequence, Tuple

import numpy as np

from sdc_sim.camera.painting import SUN, footprint
from sdc_sim.camera.rasterizer import Solid
from sdc_sim.road.scenery import (
    EAVES_SHARE,
    HOUSE,
    ROOF_BELOW_EAVES_M,
    ROOF_BEYOND_EAVES_M,
    Scenery,
)
from sdc_sim.yaml_document import packaged_config

_COLOURS = packaged_config("building_colours")
# A hedge as high as the camera covers the foot of each wall, and the windows are above it: walls
# and windows would have steep edges below the horizon, as markings have.
_HEDGE_M = 1.7

# Polygons (k, 4, 3) of a face or of all its panes, its normal, its colour, and whether it is panes.
_Part = Tuple[np.ndarray, np.ndarray, np.ndarray, bool]


def building(scenery: Scenery, item: int) -> Solid:
    """Return the faces of a building of the scenery, and the panes of its windows."""
    variant, height_m = int(scenery.variant[item]), float(scenery.size_m[item, 2])
    wall = np.array(_COLOURS["walls"][variant % 6], float)
    corners = footprint(scenery.position_m[item], scenery.yaw_rad[item], scenery.size_m[item])
    if scenery.kind[item] == HOUSE:
        parts = _house(corners, height_m, wall, np.array(_COLOURS["roofs"][variant % 3], float))
    else:
        parts = _block(corners, height_m, wall)
    polygons, normals, bgr, is_pane = zip(*parts)
    counts = [len(part) for part in polygons]
    repeated = (np.repeat(np.array(values), counts, axis=0) for values in (normals, bgr, is_pane))
    return Solid(np.concatenate(polygons), *repeated)


def _house(
    corners: np.ndarray, height_m: float, wall: np.ndarray, roof: np.ndarray
) -> Iterator[_Part]:
    """Yield the faces in the order in which they are painted."""
    eaves_m = EAVES_SHARE * height_m
    # The gables are the two shorter walls.
    if np.hypot(*(corners[0] - corners[1])) < np.hypot(*(corners[1] - corners[2])):
        gables = corners
    else:
        gables = np.roll(corners, -1, axis=0)
    slopes = _roof_slopes(gables, eaves_m, height_m)
    for slope in slopes:
        yield _face(slope[::-1], roof, 0.55)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        yield from _wall(a, b, eaves_m, wall)
        yield _panes(a, b, eaves_m)
    for a, b in (gables[:2], gables[2:]):
        peak = (*(0.5 * (a + b)), height_m)
        yield _face([(*a, eaves_m), (*b, eaves_m), peak, peak], wall)
    for slope in slopes:
        yield _face(slope, roof)


def _block(corners: np.ndarray, height_m: float, wall: np.ndarray) -> Iterator[_Part]:
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        yield from _wall(a, b, height_m, wall)
        yield _upright(a, b, height_m - 0.5, height_m, 0.72 * wall)
        yield _panes(a, b, height_m)


def _wall(a: np.ndarray, b: np.ndarray, height_m: float, colour: np.ndarray) -> Iterator[_Part]:
    """Yield a wall from `a` to `b` (2,) and the hedge in front of it."""
    yield _upright(a, b, 0.0, height_m, colour)
    yield _upright(a, b, 0.0, _HEDGE_M, np.array(_COLOURS["hedge"]))


def _upright(a: np.ndarray, b: np.ndarray, low_m: float, high_m: float, bgr: np.ndarray) -> _Part:
    return _face([(*a, low_m), (*b, low_m), (*b, high_m), (*a, high_m)], bgr)


def _face(corners: Sequence[Sequence[float]], colour: np.ndarray, dim: float = 1.0) -> _Part:
    """Return a face, its colour shaded by the sun."""
    quad = np.array(corners, float)
    normal = np.cross(quad[1] - quad[0], quad[2] - quad[0])
    normal /= np.linalg.norm(normal)
    shade = 0.66 + 0.38 * max(0.0, float(normal @ SUN))
    return quad[None], normal, np.minimum(colour * (dim * shade), 255.0), False


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


def _panes(a: np.ndarray, b: np.ndarray, height_m: float) -> _Part:
    """Return the windows in the wall from `a` to `b` (2,) [m]."""
    length_m = float(np.hypot(*(b - a)))
    columns, floors = max(1, int(length_m / 2.6)), max(1, int(height_m / 2.9))
    u = (np.arange(columns) + 0.5) * length_m / columns - 0.6
    u, z = (grid.ravel()[:, None] for grid in np.meshgrid(u, 3.0 * np.arange(floors) + _HEDGE_M))
    u, z = u + [0.0, 1.2, 1.2, 0.0], z + [0.0, 0.0, 1.3, 1.3]
    panes = np.concatenate([a + (u / length_m)[..., None] * (b - a), z[..., None]], axis=2)
    _, normal, bgr, _ = _face(panes[0], np.array(_COLOURS["glass"]))
    return panes, normal, bgr, True
