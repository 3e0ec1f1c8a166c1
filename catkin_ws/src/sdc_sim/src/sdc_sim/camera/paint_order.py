"""Order in which upright bodies are painted, so that near ones hide far ones."""

from __future__ import annotations

import numpy as np

_TOLERANCE = 1e-6
_LEAST_AHEAD_M = 0.3


def paint_order(corners: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> list[int]:
    """Return the order in which to paint bodies.

    A body cannot hide another one if a side of the other has the eye in front of it and the whole
    body behind it: then the body behind is painted first.

    Args:
        corners: footprints (N, 4, 2), counter-clockwise, sorted from far to near [m]
        eye: position (2,) of the camera [m]
        heading: unit vector (2,) of the view

    Returns:
        the numbers of the bodies

    Reference: Newell, Newell and Sancha, "A Solution to the Hidden Surface Problem", ACM 1972,
    plane tests.
    """
    n = len(corners)
    if n < 2:
        return list(range(n))
    hides = _may_hide(corners, eye)
    first = hides.T & ~hides & _overlap(corners, eye, heading)
    if not np.any(np.tril(first, -1)):
        return list(range(n))
    return _topological_order(first)


def _may_hide(corners: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Return [i, j]: whether the plane of a side shows that j cannot hide i (N, N)."""
    n = len(corners)
    edge = corners[:, [1, 2, 3, 0]] - corners
    normal = np.stack([edge[..., 1], -edge[..., 0]], axis=2)
    level = np.sum(normal * corners, axis=2)
    front = np.sum(normal * eye, axis=2) > level
    # One row for each side, one column for each corner: those of all bodies one after the other.
    height = normal.reshape(-1, 2) @ corners.transpose(2, 1, 0).reshape(2, -1)
    most = height.reshape(4 * n, 4, n).max(axis=1).reshape(n, 4, n)
    behind = (most <= level[..., None] + _TOLERANCE) & front[..., None]
    return behind.any(axis=1)


def _overlap(corners: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Return whether two bodies share columns of the picture (N, N)."""
    offset = corners - eye
    ahead = np.maximum(offset @ heading, _LEAST_AHEAD_M)
    slope = (heading[0] * offset[..., 1] - heading[1] * offset[..., 0]) / ahead
    low, high = slope.min(axis=1), slope.max(axis=1)
    return (low[:, None] < high[None, :]) & (low[None, :] < high[:, None])


def _topological_order(first: np.ndarray) -> list[int]:
    """Return an order with j before i for each first[j, i]; cycles are broken at the first body."""
    order, left = [], np.ones(len(first), bool)
    waiting = first.sum(axis=0)
    for _ in range(len(first)):
        free = np.flatnonzero(left & (waiting == 0))
        pick = int(free[0]) if len(free) else int(np.flatnonzero(left)[0])
        order.append(pick)
        left[pick] = False
        waiting -= first[pick]
    return order
