"""Everything above the ground in the camera picture: scenery and boxes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Sequence

import numpy as np

from sdc_sim.camera.air import Air
from sdc_sim.camera.boxes import Box, box_solid, draw_box_shadow
from sdc_sim.camera.buildings import building
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import footprint
from sdc_sim.camera.rasterizer import NEAR_M, PolygonRasterizer, paint, project
from sdc_sim.camera.signs import sign
from sdc_sim.camera.trees import TREE_RANGE_M, TreePainter
from sdc_sim.road.scenery import SIGN, TREE, Scenery

# One more kind next to those of Scenery.
_BOX = SIGN + 1
_BOX_RANGE_M = 400.0
_BUILDING_RANGE_M = 190.0
_SHADOW_RANGE_M = 55.0
_CACHED_BUILDINGS = 256
# Of the order in which bodies are painted.
_TOLERANCE = 1e-6
_LEAST_AHEAD_M = 0.3


class _Bodies(NamedTuple):
    """What decides whether bodies are visible, one row each."""

    kind: np.ndarray  # TREE, HOUSE, BLOCK, SIGN or _BOX (N,)
    position_m: np.ndarray  # centre in the map (N, 2)
    corners_m: np.ndarray  # footprint in the map (N, 4, 2), counter-clockwise
    least_ahead_m: np.ndarray  # nearest centre along the heading at which a body is drawn (N,)
    most_ahead_m: np.ndarray  # farthest one (N,)
    reach_aside_m: np.ndarray  # how far the centre may be beyond the side of the view (N,)


class SceneObjects:
    """Painter of trees, buildings and boxes, from far to near."""

    def __init__(self, scenery: Scenery, camera: CameraModel, air: Air, seed: int = 0):
        self.scenery = scenery
        self._trees = TreePainter(scenery, camera, seed, air.weather)
        self._building = lru_cache(_CACHED_BUILDINGS)(
            lambda item: (sign if scenery.kind[item] == SIGN else building)(scenery, item)
        )
        self._camera = camera
        self._air = air
        self._side = np.tan(camera.fov_rad / 2.0) * (1.0 + 1.0 / camera.width)
        self._fixed = self._bodies(
            scenery.kind, scenery.position_m, scenery.yaw_rad, scenery.size_m
        )

    def _bodies(
        self, kind: np.ndarray, position: np.ndarray, yaw: np.ndarray, size: np.ndarray
    ) -> _Bodies:
        radius = 0.5 * np.hypot(size[:, 0], size[:, 1])
        tree = kind == TREE
        least = np.where(tree, 1.0, NEAR_M - radius)
        largest = np.where(
            tree | (kind == SIGN),
            TREE_RANGE_M,
            np.where(kind == _BOX, _BOX_RANGE_M, _BUILDING_RANGE_M),
        )
        corners = footprint(position, yaw, np.where(tree, 0.7, 1.0)[:, None] * size)
        return _Bodies(kind, position, corners, least, largest, radius * np.hypot(1.0, self._side))

    def draw(
        self,
        picture: np.ndarray,
        pose: Sequence[float],
        boxes: Sequence[Box] = (),
        time_s: float = 0.0,
    ) -> None:
        """Paint all visible objects over the ground and the sky.

        Args:
            picture: BGRA picture (height, width, 4)
            pose: x [m], y [m] and heading [rad] of the vehicle in the map
            boxes: the boxes, in any order
            time_s: time of the picture, in which the rain falls [s]
        """
        eye = self._camera.position_in_map(*pose)
        heading = np.array([math.cos(pose[2]), math.sin(pose[2])])
        weather, bodies, first_box = self._air.weather, self._fixed, len(self.scenery)
        if len(boxes):
            moving = self._bodies(
                np.full(len(boxes), _BOX),
                np.array([[box.x_m, box.y_m] for box in boxes]),
                np.array([box.yaw_rad for box in boxes]),
                np.array([[box.length_m, box.width_m, box.height_m] for box in boxes]),
            )
            bodies = _Bodies(*map(np.concatenate, zip(bodies, moving)))
        offset = bodies.position_m - eye[:2]
        ahead, aside = offset @ heading, offset @ (-heading[1], heading[0])
        rows = np.flatnonzero(
            (ahead > bodies.least_ahead_m)
            & (ahead < bodies.most_ahead_m)
            & (np.abs(aside) < self._side * ahead + bodies.reach_aside_m)
        )
        rows = rows[np.argsort(-np.hypot(ahead[rows], aside[rows]), kind="stable")]
        kinds = bodies.kind[rows]
        rasterizer = PolygonRasterizer(self._camera, *pose)
        is_box = kinds == _BOX
        built, box_rows = rows[~is_box & (kinds != TREE)], rows[is_box]
        haze = 1.0 - np.exp(-np.maximum(ahead[built], 0.0) / weather.haze_range_m)
        fog = np.maximum(weather.fog(ahead[box_rows]), 0.0)
        buildings = [self._building(row) for row in built.tolist()]
        visible = [boxes[row - first_box] for row in box_rows.tolist()]
        solids = [box_solid(box, eye) for box in visible]
        faces: dict = {}
        for of_kind, bodies_of_kind, share in ((built, buildings, haze), (box_rows, solids, fog)):
            drawn = project(rasterizer, bodies_of_kind, ahead[of_kind], share, weather.fog_bgr)
            faces.update(zip(of_kind.tolist(), drawn))
        for row, box in zip(box_rows.tolist(), visible):
            if ahead[row] < _SHADOW_RANGE_M:
                draw_box_shadow(picture, rasterizer, box)
        for row in rows[_paint_order(bodies.corners_m[rows], eye[:2], heading)].tolist():
            if row in faces:
                paint(picture, faces[row])
            else:
                self._trees.draw(picture, row, float(ahead[row]), float(aside[row]))
        self._air.finish(picture, pose[0], pose[1], time_s)


def _paint_order(corners: np.ndarray, eye: np.ndarray, heading: np.ndarray) -> list[int]:
    """Return the numbers of bodies in the order in which to paint them.

    A body cannot hide another one if a side of the other has the eye in front of it and the whole
    body behind it: then the body behind is painted first.

    Args:
        corners: footprints (N, 4, 2), counter-clockwise, sorted from far to near [m]
        eye: position (2,) of the camera [m]
        heading: unit vector (2,) of the view

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
