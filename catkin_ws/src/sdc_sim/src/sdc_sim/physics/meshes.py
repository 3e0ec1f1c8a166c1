"""Meshes of cars, pedestrians, obstacles and traffic lights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

# Every face has so many corners; a face with fewer repeats its last one.
FACE_CORNERS = 8
# x0, x1, y0, y1
_Rectangle = Sequence[float]
_Bgr = Sequence[float]

_DARK, _GLASS, _TYRE, _RIM = (28, 28, 28), (74, 62, 50), (30, 30, 30), (150, 150, 150)
_UNDERSIDE, _PLATE = (22, 22, 22), (220, 225, 225)
_REAR_LIGHT, _HEADLIGHT = (30, 30, 190), (235, 240, 240)
_SKIN, _TROUSERS, _SHOES, _HAIR = (140, 165, 205), (92, 66, 50), (40, 40, 45), (36, 48, 62)
_POLE, _HEAD = (86, 92, 90), (34, 38, 36)
# Red, yellow and green, from top to bottom.
_UNLIT_LAMPS = ((20, 20, 62), (18, 56, 62), (24, 56, 20))


@dataclass(frozen=True)
class Mesh:
    """Flat faces in the order in which they are painted.

    The meshes of cars, pedestrians and obstacles fill the unit cube (x and y in -0.5..0.5, z in
    0..1); that of a traffic light is in metres.

    Attributes:
        corners: corners of the faces (F, 8, 3), counter-clockwise seen from outside
        colours: blue, green, red of the faces (F, 3), 0..255
        tinted: whether a face has the colour of the body instead (F,)
        normals: vectors out of the faces (F, 3), not normalised
        glow: least brightness of a face (F,), 1 for a lamp that is lit
        prisms: the solid parts (P, 10): rectangles x0, x1, y0, y1 at the bottom and at the top, and
            the heights of both
    """

    corners: np.ndarray
    colours: np.ndarray
    tinted: np.ndarray
    normals: np.ndarray
    glow: np.ndarray
    prisms: np.ndarray


class MeshBuilder:
    """Faces of a mesh that is being built."""

    def __init__(self):
        self._corners: list[list[Sequence[float]]] = []
        self._colours: list[_Bgr] = []
        self._tinted: list[bool] = []
        self._prisms: list[Sequence[float]] = []

    def face(self, corners: Sequence[Sequence[float]], colour: _Bgr | None = None) -> None:
        """Add a face.

        Args:
            corners: at most FACE_CORNERS points, counter-clockwise seen from outside
            colour: blue, green, red; None for the colour of the body
        """
        points = list(corners)
        self._corners.append(points + [points[-1]] * (FACE_CORNERS - len(points)))
        self._colours.append((1.0, 1.0, 1.0) if colour is None else colour)
        self._tinted.append(colour is None)

    def prism(
        self,
        low: _Rectangle,
        high: _Rectangle,
        colour: _Bgr | None = None,
        base_z: float = 0.0,
        top_z: float = 1.0,
        bottom: bool = False,
    ) -> list[list[Sequence[float]]]:
        """Add a frustum: four sides, the top, and the bottom if asked for.

        Args:
            low: rectangle at the bottom
            high: rectangle at the top
            colour: blue, green, red; None for the colour of the body
            base_z: height of the bottom
            top_z: height of the top
            bottom: whether to add the bottom

        Returns:
            the four sides: front, left, rear, right, each from its bottom right corner
        """
        self._prisms.append((*low, *high, base_z, top_z))
        a = [(low[1], low[2]), (low[1], low[3]), (low[0], low[3]), (low[0], low[2])]
        b = [(high[1], high[2]), (high[1], high[3]), (high[0], high[3]), (high[0], high[2])]
        sides: list[list[Sequence[float]]] = []
        for k in range(4):
            n = (k + 1) % 4
            sides.append([(*a[k], base_z), (*a[n], base_z), (*b[n], top_z), (*b[k], top_z)])
            self.face(sides[-1], colour)
        self.face([(*p, top_z) for p in b], colour)
        if bottom:
            self.face([(*p, base_z) for p in reversed(a)], colour)
        return sides

    def mesh(self) -> Mesh:
        """Return the mesh of all faces added so far."""
        corners = np.array(self._corners, float)
        colours = np.array(self._colours, float)
        return Mesh(
            corners=corners,
            colours=colours,
            tinted=np.array(self._tinted, bool),
            normals=np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]),
            glow=np.where(colours.max(axis=1) > 254.0, 1.0, 0.0),
            prisms=np.array(self._prisms, float).reshape(-1, 10),
        )


def car_mesh() -> Mesh:
    """Return a saloon car that points along x."""
    builder = MeshBuilder()
    builder.face(
        [(-0.47, -0.46, 0.01), (0.47, -0.46, 0.01), (0.47, 0.46, 0.01), (-0.47, 0.46, 0.01)],
        _UNDERSIDE,
    )
    builder.prism((-0.47, 0.47, -0.47, 0.47), (-0.49, 0.49, -0.49, 0.49), _DARK, 0.10, 0.24)
    builder.prism((-0.5, 0.5, -0.49, 0.49), (-0.49, 0.49, -0.5, 0.5), None, 0.22, 0.46)
    builder.prism((-0.49, 0.49, -0.5, 0.5), (-0.47, 0.42, -0.46, 0.46), None, 0.46, 0.64)
    _add_wheels(builder)
    _add_lights_and_plates(builder)
    _add_cabin(builder)
    return builder.mesh()


def _add_wheels(builder: MeshBuilder) -> None:
    for y, out in ((-0.502, -1.0), (0.502, 1.0)):
        for x in (-0.30, 0.31):
            for radius, colour, beyond in ((0.072, _TYRE, 1.0), (0.045, _RIM, 1.002)):
                angles = np.arange(8) * np.pi / 4 * -out
                circle = [
                    (x + radius * np.cos(t), y * beyond, 0.235 + 3.25 * radius * np.sin(t))
                    for t in angles
                ]
                builder.face(circle, colour)


def _add_lights_and_plates(builder: MeshBuilder) -> None:
    for y0, y1 in ((-0.46, -0.26), (0.26, 0.46)):
        builder.face(
            [(-0.497, y1, 0.45), (-0.497, y0, 0.45), (-0.487, y0, 0.57), (-0.487, y1, 0.57)],
            _REAR_LIGHT,
        )
        builder.face(
            [(0.498, y0, 0.42), (0.498, y1, 0.42), (0.48, y1, 0.53), (0.48, y0, 0.53)],
            _HEADLIGHT,
        )
    builder.face(
        [(-0.503, 0.13, 0.32), (-0.503, -0.13, 0.32), (-0.5, -0.13, 0.41), (-0.5, 0.13, 0.41)],
        _PLATE,
    )
    builder.face(
        [(0.503, -0.13, 0.26), (0.503, 0.13, 0.26), (0.5, 0.13, 0.34), (0.5, -0.13, 0.34)],
        _PLATE,
    )


def _add_cabin(builder: MeshBuilder) -> None:
    front, left, rear, right = builder.prism(
        (-0.40, 0.22, -0.45, 0.45), (-0.27, 0.04, -0.36, 0.36), None, 0.63, 1.0
    )
    panes = [_inset(front, 0.06, 0.94, 0.06, 0.86), _inset(rear, 0.06, 0.94, 0.08, 0.84)]
    for side in (left, right):
        panes += [_inset(side, 0.08, 0.47, 0.10, 0.84), _inset(side, 0.52, 0.90, 0.10, 0.84)]
    for pane in panes:
        builder.face(pane, _GLASS)


def _inset(
    quad: Sequence[Sequence[float]], left: float, right: float, low: float, high: float
) -> list[Sequence[float]]:
    """Return the part of a quadrilateral between these shares of its width and of its height."""
    a, b, c, d = (np.array(p, float) for p in quad)

    def at(u: float, v: float) -> Sequence[float]:
        return tuple((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c))

    return [at(left, low), at(right, low), at(right, high), at(left, high)]


def pedestrian_mesh() -> Mesh:
    """Return a walking person that faces along x."""
    builder = MeshBuilder()
    for y, x in ((-0.2, -0.12), (0.2, 0.12)):
        builder.prism(
            (x - 0.2, x + 0.3, y - 0.13, y + 0.13),
            (x - 0.2, x + 0.2, y - 0.13, y + 0.13),
            _SHOES,
            0.0,
            0.05,
        )
        builder.prism(
            (x - 0.17, x + 0.17, y - 0.14, y + 0.14),
            (-0.2, 0.2, y - 0.17, y + 0.17),
            _TROUSERS,
            0.05,
            0.50,
        )
    builder.prism((-0.22, 0.22, -0.36, 0.36), (-0.24, 0.24, -0.42, 0.42), None, 0.48, 0.78)
    builder.prism((-0.24, 0.24, -0.42, 0.42), (-0.1, 0.1, -0.16, 0.16), None, 0.78, 0.84)
    for y in (-0.47, 0.47):
        builder.prism(
            (-0.1, 0.1, y - 0.07, y + 0.07),
            (-0.12, 0.12, y - 0.08, y + 0.08),
            None,
            0.46,
            0.80,
            bottom=True,
        )
    head = (-0.2, 0.2, -0.19, 0.19)
    builder.prism((-0.13, 0.13, -0.13, 0.13), head, _SKIN, 0.84, 0.92, bottom=True)
    builder.prism(head, (-0.12, 0.12, -0.12, 0.12), _HAIR, 0.92, 1.0)
    return builder.mesh()


def obstacle_mesh() -> Mesh:
    """Return a plain box."""
    builder = MeshBuilder()
    full = (-0.5, 0.5, -0.5, 0.5)
    builder.prism(full, full)
    return builder.mesh()


def traffic_light_mesh(height_m: float, lit_bgr: _Bgr) -> Mesh:
    """Return a traffic light in metres: a pole and a head with three lamps that face along x.

    Args:
        height_m: height of the top [m]
        lit_bgr: colour of the lamp that is lit; its hue selects which of the three that is
    """
    builder = MeshBuilder()
    pole, top = (-0.06, 0.06, -0.06, 0.06), height_m
    head = (-0.12, 0.14, -0.2, 0.2)
    builder.prism(pole, pole, _POLE, 0.0, top - 0.2)
    builder.prism(head, head, _HEAD, top - 1.05, top, bottom=True)
    _, g, r = lit_bgr
    lit = 1 if r > 120 and g > 120 else (0 if r >= g else 2)
    angles = np.arange(8) * np.pi / 4
    for k, unlit in enumerate(_UNLIT_LAMPS):
        z = top - 0.2 - 0.32 * k
        circle = [(0.145, 0.12 * np.cos(t), z + 0.12 * np.sin(t)) for t in angles]
        builder.face(circle, tuple(float(v) for v in lit_bgr) if k == lit else unlit)
    return builder.mesh()
