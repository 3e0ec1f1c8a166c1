"""Trees and buildings next to the road."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial import cKDTree

from sdc_sim.road.spatial_index import cell_keys, cells_of

TREE, HOUSE, BLOCK = 0, 1, 2
# Shapes, for the camera and the lidars. Trees, as shares of their height:
TRUNK_RADIUS_SHARE = 12.0 / 512.0
CROWN_CENTRE_SHARE = 342.0 / 512.0
CROWN_RADIUS_SHARE = 163.0 / 512.0
# Houses: height of the eaves as a share, and by how much the roof is larger than the walls [m].
EAVES_SHARE = 0.6
ROOF_BELOW_EAVES_M = 0.25
ROOF_BEYOND_EAVES_M = 0.45
_SLOT_M = 11.0
_MAX_SLOTS = 20_000
_SAMPLE_CELL_M = 3.0
_CROWDED_CELL_M = 24.0
_FARTHEST_M = 12.0
_GAP_M = 0.5


@dataclass(frozen=True)
class Scenery:
    """Trees and buildings, one row each.

    Attributes:
        kind: (N,) TREE, HOUSE or BLOCK (of flats)
        position_m: (N, 2) centre on the ground [m]
        yaw_rad: (N,) direction of the length [rad]
        size_m: (N, 3) length, width, height [m]
        variant: (N,) a number in 0..255 that selects colours and shapes
    """

    kind: np.ndarray
    position_m: np.ndarray
    yaw_rad: np.ndarray
    size_m: np.ndarray
    variant: np.ndarray

    def __len__(self) -> int:
        return len(self.kind)


class RoadSamples(Protocol):
    """The samples of a road; see Road."""

    points_m: np.ndarray
    s_m: np.ndarray
    heading_rad: np.ndarray
    left: np.ndarray
    length_m: float

    def at(self, s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points on the line and unit vectors to the left."""
        raise NotImplementedError


def generate_scenery(
    line: RoadSamples,
    right_edge_m: float,
    left_edge_m: float,
    on_road: Callable[[np.ndarray, float], np.ndarray],
    seed: int,
) -> Scenery:
    """Return trees and buildings next to a road, none on any pass of it.

    Args:
        line: the samples of the road
        right_edge_m: lateral offset of the right edge of the asphalt [m]
        left_edge_m: lateral offset of the left edge of the asphalt [m]
        on_road: returns which points (N, 2) lie on the road widened by a margin [m]
        seed: seed of the random numbers
    """
    rng = np.random.RandomState(seed)
    slots = np.arange(line.s_m[0], line.s_m[-1], max(_SLOT_M, line.length_m / _MAX_SLOTS))
    count = 2 * len(slots)
    s = np.repeat(slots, 2) + rng.uniform(-3.0, 3.0, count)
    side = np.tile([-1.0, 1.0], len(slots))
    points, left = line.at(s)
    kind = _kinds(rng, slots)
    size = _sizes(rng, kind)
    setback = np.where(kind == TREE, rng.uniform(2.5, 9.0, count), rng.uniform(5.0, 9.0, count))
    edge = np.where(side < 0, right_edge_m, left_edge_m)
    depth = np.where(kind == TREE, 0.0, 0.5 * size[:, 1])
    position = points + (edge + side * (setback + depth))[:, None] * left
    yaw = np.arctan2(-left[:, 0], left[:, 1])
    every = Scenery(kind, position, yaw, size, rng.randint(0, 256, count))

    clearance = _Clearance(line, right_edge_m, left_edge_m)
    needed = np.where(kind == TREE, 1.5, 4.0 + depth)
    fits = clearance(position) >= np.minimum(needed, 11.0)
    along = np.column_stack([left[:, 1], -left[:, 0]])
    for u, v in ((0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)):
        corner = position + u * size[:, :1] * along + v * size[:, 1:2] * left
        fits &= (kind == TREE) | (clearance(corner) >= 2.5)
    chosen = _rows(every, np.flatnonzero(fits))
    chosen = _rows(chosen, np.flatnonzero(_is_free(chosen, line, on_road)))
    return _rows(chosen, _without_overlap(chosen))


def _rows(scenery: Scenery, rows: np.ndarray) -> Scenery:
    return Scenery(*[values[rows] for values in vars(scenery).values()])


def _kinds(rng: np.random.RandomState, slots: np.ndarray) -> np.ndarray:
    """Return two kinds for each slot; towns alternate with countryside, which has more trees."""
    town = np.repeat(np.sin(slots / 170.0 + rng.uniform(0, 6)) + 0.3, 2)
    draw = rng.uniform(size=len(town))
    building = np.where(rng.uniform(size=len(town)) < 0.5 + 0.2 * town, BLOCK, HOUSE)
    return np.where(draw < 0.22 + 0.2 * town, building, TREE)


def _sizes(rng: np.random.RandomState, kind: np.ndarray) -> np.ndarray:
    """Return length, width and height (N, 3) [m]."""
    count = len(kind)
    height = rng.uniform(5.0, 9.5, count)
    trees = np.column_stack([0.75 * height, 0.75 * height, height])
    houses = np.column_stack(
        [rng.uniform(9, 13, count), rng.uniform(7, 9, count), rng.uniform(6.5, 8.5, count)]
    )
    length, width = rng.uniform(13, 20, count), rng.uniform(10, 13, count)
    blocks = np.column_stack([length, width, 3.1 * rng.randint(3, 7, count) + 0.8])
    return np.choose(kind[:, None], [trees, houses, blocks])


class _Clearance:
    """The free distance to the asphalt, from one sample of the road in each cell.

    One sample a cell keeps scenery off the road quickly, however many laps there are.
    """

    def __init__(self, line: RoadSamples, right_edge_m: float, left_edge_m: float):
        self._line = line
        self._edges_m = right_edge_m, left_edge_m
        keys = cell_keys(cells_of(line.points_m, _SAMPLE_CELL_M))
        self._keys, self._samples = np.unique(keys, return_index=True)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Return the free distances (N,) of points (N, 2), at most 12, accurate to 0.5 [m]."""
        line, (right_edge_m, left_edge_m) = self._line, self._edges_m
        free = np.full(len(points), _FARTHEST_M)
        cells = cells_of(points, _SAMPLE_CELL_M)
        width_m = left_edge_m
        reach = int(np.ceil((_FARTHEST_M + width_m) / _SAMPLE_CELL_M))
        steps = np.arange(-reach, reach + 1)
        for dx, dy in np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2):
            if (max(abs(dx), abs(dy)) - 1) * _SAMPLE_CELL_M > _FARTHEST_M + width_m:
                continue
            keys = cell_keys(cells + (dx, dy))
            slot = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
            hit = np.flatnonzero(self._keys[slot] == keys)
            sample = self._samples[slot[hit]]
            offset = points[hit] - line.points_m[sample]
            left = line.left[sample]
            lateral = np.sum(offset * left, axis=1)
            along = np.sum(offset * np.column_stack([left[:, 1], -left[:, 0]]), axis=1)
            aside = np.maximum(lateral - left_edge_m, right_edge_m - lateral)
            beyond = np.maximum(np.abs(along) - _SAMPLE_CELL_M, 0.0)
            np.minimum.at(free, hit, np.hypot(np.maximum(aside, 0.0), beyond))
        return free


def _crowded_cells(line: RoadSamples) -> np.ndarray:
    """Return the keys of the cells that the road enters repeatedly or in which it turns sharply."""
    keys = cell_keys(cells_of(line.points_m, _CROWDED_CELL_M))
    entered = np.append(True, np.diff(keys) != 0)
    found, visits = np.unique(keys[entered], return_counts=True)
    sharp = keys[:-1][np.abs(np.diff(np.unwrap(line.heading_rad))) > 0.2]
    return np.unique(np.concatenate([found[visits > 1], sharp]))


def _is_free(scenery: Scenery, line: RoadSamples, on_road: Callable) -> np.ndarray:
    """Return which rows are off every pass of the road.

    The check is exact and therefore slow: only rows near crowded cells need it, because
    `_Clearance` knows one pass a cell.
    """
    free = np.ones(len(scenery), bool)
    cells = cells_of(scenery.position_m, _CROWDED_CELL_M)
    around = np.stack([cell_keys(cells + (i, j)) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    doubtful = np.isin(around, _crowded_cells(line)).any(axis=0)
    free[doubtful] = ~on_road(scenery.position_m[doubtful], 1.2)
    built = np.flatnonzero((scenery.kind != TREE) & free & doubtful)
    u, v = (
        grid.ravel() for grid in np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 4))
    )
    x, y = u * scenery.size_m[built, :1], v * scenery.size_m[built, 1:2]
    c, s = np.cos(scenery.yaw_rad[built])[:, None], np.sin(scenery.yaw_rad[built])[:, None]
    probes = scenery.position_m[built][:, None] + np.stack([c * x - s * y, s * x + c * y], axis=2)
    hits = on_road(probes.reshape(-1, 2), 3.0).reshape(len(built), len(u))
    free[built] = ~hits.any(axis=1)
    return free


def _without_overlap(scenery: Scenery) -> np.ndarray:
    """Return the rows, buildings first, that touch no row kept before, in ascending order."""
    if not len(scenery):
        return np.zeros(0, np.int64)
    size, position = scenery.size_m, scenery.position_m
    is_tree = scenery.kind == TREE
    radius = np.where(is_tree, 0.35 * size[:, 0], 0.5 * np.hypot(size[:, 0], size[:, 1]))
    tree = cKDTree(position)
    blocked = np.zeros(len(scenery), bool)
    kept = []
    for i in np.argsort(is_tree, kind="stable").tolist():
        if blocked[i]:
            continue
        kept.append(i)
        near = tree.query_ball_point(position[i], radius[i] + radius.max() + _GAP_M)
        distance = np.sum((position[near] - position[i]) ** 2, axis=1)
        blocked[near] |= distance <= (radius[near] + radius[i] + _GAP_M) ** 2
    return np.sort(kept)
