"""Paints what stands on the ground of the camera picture: trees, buildings, cars, people, boxes and traffic lights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import (
    FIXED_POINT_BITS,
    HAZE_BGR,
    HAZE_RANGE_M,
    SHADE,
    SHADOW_M_PER_M,
    blend,
    footprint,
    halve,
)
from sdc_sim.road.road import CellIndex

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


def _tree_sprite(seed: int) -> np.ndarray:
    """A tree (256, 192, 4), premultiplied BGRA, foot in the middle of the lowest row."""
    rng = np.random.RandomState(seed)
    high, wide = 256, 192
    colour = np.zeros((2 * high, 2 * wide, 3), np.float32)
    alpha = np.zeros((2 * high, 2 * wide), np.uint8)
    trunk = np.array([[180, 511], [204, 511], [199, 300], [187, 300]], np.int32)
    cv2.fillPoly(alpha, [trunk], 255)
    cv2.fillPoly(colour, [trunk], (46, 62, 80))
    cv2.fillPoly(
        colour, [np.array([[194, 511], [204, 511], [199, 300], [194, 300]], np.int32)], (34, 46, 60)
    )
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
        cv2.circle(
            colour, (int(x - 0.2 * r), int(y - 0.25 * r)), int(0.72 * r), tuple(lit * tint), -1
        )
    image = np.dstack([colour * (alpha[..., None] / 255.0), alpha.astype(np.float32)])
    return np.clip(halve(image), 0, 255).astype(np.uint8)


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
        self.normals = np.cross(
            self.corners[:, 2] - self.corners[:, 0], self.corners[:, 3] - self.corners[:, 1]
        )
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
    m.face(
        [(-0.47, -0.46, 0.01), (0.47, -0.46, 0.01), (0.47, 0.46, 0.01), (-0.47, 0.46, 0.01)],
        (22, 22, 22),
    )
    m.prism((-0.47, 0.47, -0.47, 0.47), (-0.49, 0.49, -0.49, 0.49), dark, 0.10, 0.24)
    m.prism((-0.5, 0.5, -0.49, 0.49), (-0.49, 0.49, -0.5, 0.5), None, 0.22, 0.46)
    m.prism((-0.49, 0.49, -0.5, 0.5), (-0.47, 0.42, -0.46, 0.46), None, 0.46, 0.64)
    for y, out in ((-0.502, -1.0), (0.502, 1.0)):
        for x in (-0.30, 0.31):
            for radius, colour in ((0.072, tyre), (0.045, rim)):
                turn = np.arange(8) * np.pi / 4 * -out
                m.face(
                    [
                        (
                            x + radius * np.cos(t),
                            y * (1.0 if colour is tyre else 1.002),
                            0.235 + 3.25 * radius * np.sin(t),
                        )
                        for t in turn
                    ],
                    colour,
                )
    for y0, y1 in ((-0.46, -0.26), (0.26, 0.46)):
        m.face(
            [(-0.497, y1, 0.45), (-0.497, y0, 0.45), (-0.487, y0, 0.57), (-0.487, y1, 0.57)],
            (30, 30, 190),
        )
        m.face(
            [(0.498, y0, 0.42), (0.498, y1, 0.42), (0.48, y1, 0.53), (0.48, y0, 0.53)],
            (235, 240, 240),
        )
    m.face(
        [(-0.503, 0.13, 0.32), (-0.503, -0.13, 0.32), (-0.5, -0.13, 0.41), (-0.5, 0.13, 0.41)],
        (220, 225, 225),
    )
    m.face(
        [(0.503, -0.13, 0.26), (0.503, 0.13, 0.26), (0.5, 0.13, 0.34), (0.5, -0.13, 0.34)],
        (220, 225, 225),
    )
    low, high = (-0.40, 0.22, -0.45, 0.45), (-0.27, 0.04, -0.36, 0.36)
    m.prism(low, high, None, 0.63, 1.0)
    first = len(m.corners) - 5
    panes = [
        _inset(m.corners[first + k][:4], *share)
        for k, share in ((0, (0.06, 0.94, 0.06, 0.86)), (2, (0.06, 0.94, 0.08, 0.84)))
    ]
    for k in (1, 3):
        panes += [
            _inset(m.corners[first + k][:4], 0.08, 0.47, 0.10, 0.84),
            _inset(m.corners[first + k][:4], 0.52, 0.90, 0.10, 0.84),
        ]
    for pane in panes:
        m.face(pane, glass)
    return m.finish()


def _pedestrian_mesh() -> _Mesh:
    m = _Mesh()
    skin, trousers, shoes, hair = (140, 165, 205), (92, 66, 50), (40, 40, 45), (36, 48, 62)
    for y, x in ((-0.2, -0.12), (0.2, 0.12)):
        m.prism(
            (x - 0.2, x + 0.3, y - 0.13, y + 0.13),
            (x - 0.2, x + 0.2, y - 0.13, y + 0.13),
            shoes,
            0.0,
            0.05,
        )
        m.prism(
            (x - 0.17, x + 0.17, y - 0.14, y + 0.14),
            (-0.2, 0.2, y - 0.17, y + 0.17),
            trousers,
            0.05,
            0.50,
        )
    m.prism((-0.22, 0.22, -0.36, 0.36), (-0.24, 0.24, -0.42, 0.42), None, 0.48, 0.78)
    m.prism((-0.24, 0.24, -0.42, 0.42), (-0.1, 0.1, -0.16, 0.16), None, 0.78, 0.84)
    for y in (-0.47, 0.47):
        m.prism(
            (-0.1, 0.1, y - 0.07, y + 0.07),
            (-0.12, 0.12, y - 0.08, y + 0.08),
            None,
            0.46,
            0.80,
            bottom=True,
        )
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
    m.prism(
        (-0.12, 0.14, -0.2, 0.2),
        (-0.12, 0.14, -0.2, 0.2),
        (34, 38, 36),
        top - 1.05,
        top,
        bottom=True,
    )
    b, g, r = lit_bgr
    place = 1 if r > 120 and g > 120 else (0 if r >= g else 2)
    for k, unlit in enumerate(((20, 20, 62), (18, 56, 62), (24, 56, 20))):
        z = top - 0.2 - 0.32 * k
        turn = np.arange(8) * np.pi / 4
        m.face(
            [(0.145, 0.12 * np.cos(t), z + 0.12 * np.sin(t)) for t in turn],
            tuple(float(v) for v in lit_bgr) if k == place else unlit,
        )
    return m.finish()


WALLS_BGR = (
    (172, 196, 214),
    (150, 168, 190),
    (196, 204, 208),
    (140, 152, 178),
    (176, 186, 182),
    (128, 148, 196),
)
ROOFS_BGR = ((56, 66, 120), (70, 72, 84), (60, 84, 128))
GLASS_BGR = (96, 82, 70)


class _Building:
    """The faces of a house or a block of flats in the map, in the order to paint them.

    `polygons` (F, 4, 3): its faces; `normals` (F, 3) point out; `colours` (F, 6): BGR of the face and of its window panes.
    `panes[k]` (P, 4, 3): the window panes of face k.
    """

    def __init__(self, scenery, item: int):
        self._faces, self._normals, self._colours = [], [], []
        self.panes = {}
        variant, height_m = int(scenery.variant[item]), float(scenery.size_m[item, 2])
        gabled = scenery.kind[item] == 1
        wall, roof = (
            np.array(WALLS_BGR[variant % 6], float),
            np.array(ROOFS_BGR[variant % 3], float),
        )
        eaves = 0.6 * height_m if gabled else height_m
        corners = footprint(scenery.position_m[item], scenery.yaw_rad[item], scenery.size_m[item])
        slopes = self._roof_slopes(corners, eaves, height_m) if gabled else []
        for slope in slopes:
            self._add(slope[::-1], roof, 0.55)
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            self._add([(*a, 0.0), (*b, 0.0), (*b, eaves), (*a, eaves)], wall)
            self._add([(*a, 0.0), (*b, 0.0), (*b, 0.4), (*a, 0.4)], 0.6 * wall)
            if not gabled:
                self._add(
                    [(*a, eaves - 0.5), (*b, eaves - 0.5), (*b, eaves), (*a, eaves)], 0.72 * wall
                )
            self.panes[len(self._faces) - 1] = _windows(a, b, eaves)
        for first, second in ((0, 1), (2, 3)) if gabled else ():
            a, b = self._gables[first], self._gables[second]
            peak = (*(0.5 * (a + b)), height_m)
            self._add([(*a, eaves), (*b, eaves), peak, peak], wall)
        for slope in slopes:
            self._add(slope, roof)
        self.polygons, self.normals = np.array(self._faces), np.array(self._normals)
        self.colours = np.clip(np.array(self._colours), 0.0, 255.0)

    def _add(self, corners, colour, dim: float = 1.0) -> None:
        quad = np.array(corners, float)
        normal = np.cross(quad[1] - quad[0], quad[2] - quad[0])
        normal /= np.linalg.norm(normal)
        shade = dim * (0.66 + 0.38 * max(0.0, float(normal @ SUN)))
        self._faces.append(quad)
        self._normals.append(normal)
        self._colours.append(np.concatenate([colour * shade, shade * np.array(GLASS_BGR, float)]))

    def _roof_slopes(self, corners, eaves: float, height_m: float) -> list:
        """The two slopes of a gable roof with overhangs, its ridge between the middles of the two shorter walls."""
        a, b, c, d = self._gables = (
            corners
            if np.hypot(*(corners[0] - corners[1])) < np.hypot(*(corners[1] - corners[2]))
            else np.roll(corners, -1, axis=0)
        )
        ridge = np.array([0.5 * (a + b), 0.5 * (c + d)])
        over = 0.5 * (ridge[0] - ridge[1]) / np.hypot(*(ridge[0] - ridge[1]))
        out = 0.45 * (b - a) / np.hypot(*(b - a))
        return [
            [
                (*(p + grow + aside), eaves - 0.25),
                (*(q - grow + aside), eaves - 0.25),
                (*(end - grow), height_m),
                (*(start + grow), height_m),
            ]
            for p, q, start, end, grow, aside in (
                (b, c, ridge[0], ridge[1], over, out),
                (d, a, ridge[1], ridge[0], -over, -out),
            )
        ]


def _windows(a: np.ndarray, b: np.ndarray, height_m: float) -> np.ndarray:
    """Corners (n, 4, 3) of the windows in the wall from `a` to `b` (2,)."""
    length_m = float(np.hypot(*(b - a)))
    columns, floors = max(1, int(length_m / 2.6)), max(1, int(height_m / 2.9))
    u = (np.arange(columns) + 0.5) * length_m / columns - 0.6
    u, z = (grid.ravel()[:, None] for grid in np.meshgrid(u, 3.0 * np.arange(floors) + 1.0))
    u, z = u + [0.0, 1.2, 1.2, 0.0], z + [0.0, 0.0, 1.3, 1.3]
    return np.concatenate([a + (u / length_m)[..., None] * (b - a), z[..., None]], axis=2)


TREE_RANGE_M = 120.0
BUILDING_RANGE_M = 190.0
PANES_RANGE_M = 85.0
SHADOW_RANGE_M = 55.0
CACHED_BUILDINGS = 256
CELL_M = 128.0
BOX = 3  # beside the kinds of Scenery: 0 tree, 1 house, 2 block of flats


class SceneObjects:
    """Paints scenery and boxes, the far ones first."""

    def __init__(self, scenery, cam: CameraModel, seed: int = 0):
        self.camera = cam
        self.scenery = scenery
        self._focal = cam.focal_px
        self._side = np.tan(cam.fov_rad / 2.0) * (1.0 + 1.0 / cam.width)
        self._standing = self._measure(
            scenery.kind, scenery.position_m, scenery.yaw_rad, scenery.size_m
        )
        self._near = (None, None, ())
        if len(scenery):
            self._places = CellIndex(scenery.position_m, scenery.position_m, CELL_M)
        self._sprites = [self._pyramid(_tree_sprite(seed + 17 * k)) for k in range(4)]
        self._meshes = {
            "car": _car_mesh(),
            "pedestrian": _pedestrian_mesh(),
            "obstacle": _obstacle_mesh(),
        }
        self._lights = {}
        self._buildings = {}

    @staticmethod
    def _pyramid(sprite: np.ndarray) -> list:
        levels = [sprite]
        while levels[-1].shape[0] > 8:
            levels.append(halve(levels[-1]))
        return levels

    def _measure(self, kind, position, yaw, size) -> tuple:
        """What tells whether a body is seen, a row each: kind, position (N, 2), footprint (N, 4, 2), least and largest distance
        ahead, and how far it reaches aside."""
        radius = 0.5 * np.hypot(size[:, 0], size[:, 1])
        least = np.where(kind == 0, 1.0, NEAR_M - radius)
        largest = np.where(kind == 0, TREE_RANGE_M, np.where(kind == BOX, 400.0, BUILDING_RANGE_M))
        forward = np.column_stack([np.cos(yaw), np.sin(yaw)])
        trim = np.where(kind == 0, 0.35, 0.5)[:, None]
        along = trim * size[:, :1] * forward
        across = trim * size[:, 1:2] * np.column_stack([-forward[:, 1], forward[:, 0]])
        corners = np.stack(
            [
                position + along - across,
                position + along + across,
                position - along + across,
                position - along - across,
            ],
            axis=1,
        )
        return kind, position, corners, least, largest, radius * np.hypot(1.0, self._side)

    def _standing_near(self, eye: np.ndarray) -> tuple:
        """Numbers of the scenery that may be in sight, and its measures; they change only where a cell begins."""
        if not len(self.scenery):
            return np.zeros(0, np.int64), self._standing
        place = tuple(
            math.floor((at + side) / CELL_M)
            for at in eye.tolist()
            for side in (-BUILDING_RANGE_M, BUILDING_RANGE_M)
        )
        if self._near[0] != place:
            still = self._places.near(eye - BUILDING_RANGE_M, eye + BUILDING_RANGE_M)
            self._near = (place, still, tuple(a[still] for a in self._standing))
        return self._near[1:]

    def draw(self, picture: np.ndarray, x_m: float, y_m: float, yaw_rad: float, boxes) -> None:
        cam = self.camera
        eye = cam.position_in_map(x_m, y_m, yaw_rad)[:2]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        still, measures = self._standing_near(eye)
        if len(boxes):
            moving = self._measure(
                np.full(len(boxes), BOX),
                np.array([[b.x_m, b.y_m] for b in boxes]),
                np.array([b.yaw_rad for b in boxes]),
                np.array([[b.length_m, b.width_m, b.height_m] for b in boxes]),
            )
            measures = [np.concatenate(both) for both in zip(measures, moving)]
        kind, position, corners, least, largest, width = measures
        offset = position - eye
        ahead, aside = offset @ (c, s), offset @ (-s, c)
        rows = np.flatnonzero(
            (ahead > least) & (ahead < largest) & (np.abs(aside) < self._side * ahead + width)
        )
        if len(rows) == 0:
            return
        rows = rows[np.argsort(-np.hypot(ahead[rows], aside[rows]), kind="stable")]
        view = _View(cam, x_m, y_m, yaw_rad)
        kinds = kind[rows]
        built = rows[(kinds == 1) | (kinds == 2)]
        buildings = self._project_buildings(view, still[built].tolist(), ahead[built])
        loose = rows[kinds == BOX]
        bodies = self._project_boxes(view, [boxes[row - len(still)] for row in loose])
        bodies = dict(zip(loose.tolist(), bodies))
        for row in loose[ahead[loose] < SHADOW_RANGE_M]:
            self._draw_shadow(picture, view, boxes[row - len(still)])
        kinds, rows = kinds.tolist(), rows.tolist()
        for k in _paint_order(corners[rows], eye, np.array([c, s])):
            row = rows[k]
            if kinds[k] == BOX:
                self._draw_box(picture, view, bodies[row])
            elif kinds[k] == 0:
                self._draw_tree(picture, float(ahead[row]), float(aside[row]), int(still[row]))
            else:
                self._draw_building(picture, view, buildings[int(still[row])])

    def _draw_tree(self, picture: np.ndarray, ahead: float, aside: float, item: int) -> None:
        cam = self.camera
        height_m, variant = float(self.scenery.size_m[item, 2]), int(self.scenery.variant[item])
        c, s = math.cos(cam.pitch_rad), math.sin(cam.pitch_rad)
        depth = ahead * c + cam.mount_z_m * s
        scale = self._focal / depth
        foot_u = cam.width / 2.0 - aside * scale
        foot_v = cam.height / 2.0 + scale * (cam.mount_z_m * c - ahead * s)
        high = height_m * scale
        levels = self._sprites[variant % len(self._sprites)]
        level = min(
            max(0, math.floor(math.log2(levels[0].shape[0] / high) + 0.25)), len(levels) - 1
        )
        sprite = levels[level]
        per_px = sprite.shape[0] / high
        wide = sprite.shape[1] / per_px
        flip = -per_px if variant & 4 else per_px
        u0, u1 = (
            max(0, math.floor(foot_u - wide / 2)),
            min(cam.width, math.ceil(foot_u + wide / 2) + 1),
        )
        v0, v1 = max(0, math.floor(foot_v - high)), min(cam.height, math.ceil(foot_v) + 1)
        if u1 - u0 < 1 or v1 - v0 < 1:
            return
        inverse = np.array(
            [
                [flip, 0.0, (sprite.shape[1] - 1) / 2.0 + flip * (u0 - foot_u)],
                [0.0, per_px, sprite.shape[0] - 0.5 + per_px * (v0 - foot_v)],
            ]
        )
        part = cv2.warpAffine(
            sprite, inverse, (u1 - u0, v1 - v0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        fade = min(1.0, (TREE_RANGE_M - ahead) / 30.0)
        if fade < 1.0:
            part = cv2.multiply(part, (fade, fade, fade, fade))
        blend(picture[v0:v1, u0:u1], part)

    def _project_buildings(self, view: _View, items: list, ahead: np.ndarray) -> dict:
        """All the buildings of a picture in one go: item -> what is to be drawn, as (polygons, outlines, beyond, colour) in turn.

        A part is one face, or all the window panes of a face. Where all is `beyond` the near plane, the outlines are its pixels.
        """
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
        normals = np.concatenate([b.normals for b in buildings])
        facing = np.flatnonzero(((view.eye - polygons[:, 0]) * normals).sum(axis=1) > 0.0)
        owner = np.repeat(np.arange(len(buildings)), counts)[facing]
        first = np.cumsum(counts) - counts
        colours = np.concatenate([b.colours for b in buildings])[facing]
        haze = (1.0 - np.exp(-np.maximum(ahead, 0.0) / HAZE_RANGE_M))[owner, None]
        colours = (colours + haze * (np.tile(HAZE_BGR, 2) - colours)).tolist()
        parts = []
        for face, building, colour in zip(facing.tolist(), owner.tolist(), colours):
            face -= int(first[building])
            parts.append(
                (building, buildings[building].polygons[face : face + 1], (*colour[:3], 255.0))
            )
            panes = buildings[building].panes.get(face)
            if panes is not None and ahead[building] < PANES_RANGE_M and len(panes):
                parts.append((building, panes, (*colour[3:], 255.0)))
        drawn = {item: [] for item in items}
        if not parts:
            return drawn
        optical = (np.concatenate([part[1] for part in parts]) - view.eye) @ view.turn
        beyond = optical[..., 2].min(axis=1) >= NEAR_M
        optical[~beyond] = [0.0, 0.0, 1.0]
        outlines = view.pixels(optical)
        start = 0
        for building, polygons, colour in parts:
            end = start + len(polygons)
            drawn[items[building]].append(
                (polygons, outlines[start:end], beyond[start:end], colour)
            )
            start = end
        return drawn

    @staticmethod
    def _draw_building(picture: np.ndarray, view: _View, parts: list) -> None:
        for polygons, outlines, beyond, colour in parts:
            if len(polygons) > 1:
                if beyond.any():
                    cv2.fillPoly(
                        picture, list(outlines[beyond]), colour, cv2.LINE_AA, FIXED_POINT_BITS
                    )
                continue
            outline = outlines[0] if beyond[0] else view.outline(polygons[0])
            if outline is not None:
                cv2.fillConvexPoly(picture, outline, colour, cv2.LINE_AA, FIXED_POINT_BITS)

    @staticmethod
    def _draw_shadow(picture: np.ndarray, view: _View, box: Box) -> None:
        thin = box.kind == "light"
        base = footprint(
            (box.x_m, box.y_m),
            box.yaw_rad,
            (0.15, 0.15) if thin else (0.96 * box.length_m, 0.96 * box.width_m),
        )
        slope = 0.85 * box.height_m * SHADOW_M_PER_M
        hull = cv2.convexHull(np.concatenate([base, base + slope]).astype(np.float32))[:, 0]
        outline = view.outline(np.column_stack([hull, np.zeros(len(hull))]))
        if outline is None:
            return
        low = np.maximum(outline.min(axis=0) >> FIXED_POINT_BITS, 0)
        high = np.minimum(
            (outline.max(axis=0) >> FIXED_POINT_BITS) + 2, [picture.shape[1], picture.shape[0]]
        )
        if np.any(high <= low):
            return
        factor = np.full((high[1] - low[1], high[0] - low[0], 4), 255, np.uint8)
        dark = int(255 * SHADE)
        cv2.fillConvexPoly(
            factor,
            outline - (low << FIXED_POINT_BITS),
            (dark, dark, dark, 255),
            cv2.LINE_AA,
            FIXED_POINT_BITS,
        )
        part = picture[low[1] : high[1], low[0] : high[0]]
        cv2.multiply(part, factor, dst=part, scale=1.0 / 255.0)

    def _project_boxes(self, view: _View, boxes: list) -> list:
        """All the boxes of a picture in one go: for each the outlines, colours and near-plane copies of its faces."""
        meshes = [self._mesh(box) for box in boxes]
        if not meshes:
            return []
        counts = [len(mesh.colours) for mesh in meshes]
        turn = np.array(
            [
                [
                    [np.cos(b.yaw_rad), np.sin(b.yaw_rad), 0.0],
                    [-np.sin(b.yaw_rad), np.cos(b.yaw_rad), 0.0],
                    [0.0, 0.0, 1.0],
                ]
                for b in boxes
            ]
        )
        size = np.array(
            [
                (1.0, 1.0, 1.0) if b.kind == "light" else (b.length_m, b.width_m, b.height_m)
                for b in boxes
            ]
        )
        place = np.array([(b.x_m, b.y_m, 0.0) for b in boxes])
        paint = np.array([b.colour_bgr for b in boxes], float)
        owner = np.repeat(np.arange(len(boxes)), counts)
        polygons = np.concatenate(
            [(mesh.corners * size[k]) @ turn[k] + place[k] for k, mesh in enumerate(meshes)]
        )
        normals = np.concatenate(
            [(mesh.normals / size[k]) @ turn[k] for k, mesh in enumerate(meshes)]
        )
        normals /= np.sqrt((normals * normals).sum(axis=1))[:, None]
        own = np.concatenate([mesh.colours for mesh in meshes])
        colours = np.where(
            np.concatenate([mesh.tinted for mesh in meshes])[:, None], paint[owner], own
        )
        shade = np.maximum(
            0.62 + 0.42 * np.maximum(normals @ SUN, 0.0), np.concatenate([m.glow for m in meshes])
        )
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
            faces = start + np.flatnonzero(facing[start : start + count])
            if box.kind == "pedestrian":
                faces = faces[np.argsort(-depth[faces], kind="stable")]
            drawn.append(
                [(pixels[k], optical[k] if near[k] else None, colours[k]) for k in faces.tolist()]
            )
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
        return np.round(self._focal * optical[..., :2] / optical[..., 2:] + self._middle).astype(
            np.int32
        )

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
            kept.append(
                previous + (NEAR_M - previous[2]) / (point[2] - previous[2]) * (point - previous)
            )
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
    hides = behind.any(axis=1)  # [i, j]: i may hide j, j cannot hide i
    offset = corners - eye
    ahead = np.maximum(offset @ heading, 0.3)
    slope = (heading[0] * offset[..., 1] - heading[1] * offset[..., 0]) / ahead
    low, high = slope.min(axis=1), slope.max(axis=1)
    meet = (low[:, None] < high[None, :]) & (low[None, :] < high[:, None])
    first = hides.T & ~hides & meet  # [j, i]: j must be painted before i
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
