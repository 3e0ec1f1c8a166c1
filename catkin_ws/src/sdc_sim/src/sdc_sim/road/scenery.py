"""Trees and buildings next to the road."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

TREE, HOUSE, BLOCK, SIGN = 0, 1, 2, 3
# Variants of a sign; the others are speed limits [km/h].
STOP_SIGN, YIELD_SIGN, PRIORITY_SIGN = 0, 1, 2
# Shapes, for the camera and the lidars. Trees, as shares of their height:
TRUNK_RADIUS_SHARE = 12.0 / 512.0
CROWN_CENTRE_SHARE = 342.0 / 512.0
CROWN_RADIUS_SHARE = 163.0 / 512.0
# Houses: height of the eaves as a share, and by how much the roof is larger than the walls [m].
EAVES_SHARE = 0.6
ROOF_BELOW_EAVES_M = 0.25
ROOF_BEYOND_EAVES_M = 0.45
_GAP_M = 0.5


@dataclass(frozen=True)
class Scenery:
    """Trees, buildings and signs, one row each."""

    kind: np.ndarray  # (N,) TREE, HOUSE, BLOCK (of flats) or SIGN
    position_m: np.ndarray  # (N, 2) centre on the ground [m]
    yaw_rad: np.ndarray  # (N,) direction of the length [rad]
    size_m: np.ndarray  # (N, 3) length, width, height [m]
    variant: (
        np.ndarray
    )  # (N,) a number in 0..255 that selects colours and shapes; of a sign which one it is

    def __len__(self) -> int:
        return len(self.kind)


def generate_scenery(
    place_at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    slots_m: np.ndarray,
    edges_m: tuple[float, float],
    on_road: Callable[[np.ndarray, float], np.ndarray],
    seed: int,
) -> Scenery:
    """Return trees and buildings next to a road, none on any pass of it.

    Args:
        place_at: returns route points (N, 2) and unit vectors to the left at arc lengths (N,) [m]
        slots_m: (M,) arc lengths, each for a pair of objects to the right and to the left [m]
        edges_m: lateral offsets of the right and the left edge of the asphalt [m]
        on_road: returns which points (N, 2) are on the road widened by a margin [m]
        seed: seed of the random numbers
    """
    rng = np.random.RandomState(seed)
    count = 2 * len(slots_m)
    s = np.repeat(slots_m, 2) + rng.uniform(-3.0, 3.0, count)
    side = np.tile([-1.0, 1.0], len(slots_m))
    points, left = place_at(s)
    kind = _kinds(rng, slots_m)
    size = _sizes(rng, kind)
    setback = np.where(kind == TREE, rng.uniform(2.5, 9.0, count), rng.uniform(5.0, 9.0, count))
    depth = np.where(kind == TREE, 0.0, 0.5 * size[:, 1])
    position = points + (np.tile(edges_m, len(slots_m)) + side * (setback + depth))[:, None] * left
    yaw = np.arctan2(-left[:, 0], left[:, 1])
    every = Scenery(kind, position, yaw, size, rng.randint(0, 256, count))

    # Trees keep a distance from the asphalt with their trunk, buildings with all their walls.
    fits = (kind != TREE) | ~on_road(position, 1.5)
    built = np.flatnonzero(kind != TREE)
    grid = np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 4))
    u, v = (shares.ravel() for shares in grid)
    ahead, aside = u * size[built, :1], v * size[built, 1:2]
    left = left[built, None]
    probes = position[built, None] + aside[..., None] * left
    probes += ahead[..., None] * np.stack([left[..., 1], -left[..., 0]], axis=-1)
    fits[built] = ~on_road(probes.reshape(-1, 2), 2.5).reshape(len(built), -1).any(axis=1)
    beside = chosen(every, np.flatnonzero(fits))
    return chosen(beside, _without_overlap(beside))


def chosen(table: Any, rows: np.ndarray) -> Any:
    """Return these rows of a dataclass whose fields are arrays."""
    fields = dataclasses.fields(table)
    return type(table)(*(getattr(table, field.name)[rows] for field in fields))


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
