"""Meshes of cars, pedestrians, obstacles and traffic lights, from config/meshes.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Mapping, Optional, Sequence, Tuple

import numpy as np

from sdc_sim.physics.traffic_lights import HEIGHT_M
from sdc_sim.yaml_document import packaged_config

# Every face has so many corners; a face with fewer repeats its last one.
FACE_CORNERS = 8
_SIDES = ("front", "left", "rear", "right")
_ANGLES_RAD = np.arange(FACE_CORNERS) * np.pi / 4
# Red, yellow and green, from top to bottom.
_UNLIT_LAMPS = ((20, 20, 62), (18, 56, 62), (24, 56, 20))
_Point = Sequence[float]
_Bgr = Sequence[float]
# Corners and colour, None for the colour of the body.
_Face = Tuple[Sequence[_Point], Optional[_Bgr]]


@dataclass(frozen=True)
class Mesh:
    """Flat faces in the order in which they are painted.

    The meshes of cars, pedestrians and obstacles fill the unit cube (x and y in -0.5..0.5, z in
    0..1); that of a traffic light is in metres.
    """

    corners: np.ndarray  # corners of the faces (F, 8, 3), counter-clockwise seen from outside
    colours: np.ndarray  # blue, green, red of the faces (F, 3), 0..255
    tinted: np.ndarray  # whether a face has the colour of the body instead (F,)
    normals: np.ndarray  # vectors out of the faces (F, 3), not normalised
    glow: np.ndarray  # least brightness of a face (F,), 1 for a lamp that is lit


@lru_cache(None)
def table_mesh(kind: str) -> Mesh:
    """Return the mesh of a kind of obstacle that points along x."""
    return _mesh(_table_faces(kind))


@lru_cache(None)
def traffic_light_mesh(lit_bgr: _Bgr) -> Mesh:
    """Return a traffic light in metres: a pole and a head with three lamps that face along x.

    Args:
        lit_bgr: colour of the lamp that is lit; its hue selects which of the three that is
    """
    faces = _table_faces("light")
    _, g, r = lit_bgr
    lit = 1 if r > 120 and g > 120 else (0 if r >= g else 2)
    for k, unlit in enumerate(_UNLIT_LAMPS):
        z = HEIGHT_M - 0.2 - 0.32 * k
        circle: list[_Point] = [
            (0.145, 0.12 * np.cos(t), z + 0.12 * np.sin(t)) for t in _ANGLES_RAD
        ]
        faces.append((circle, tuple(map(float, lit_bgr)) if k == lit else unlit))
    return _mesh(faces)


def _mesh(faces: list[_Face]) -> Mesh:
    """Return the mesh of faces."""
    corners = np.array(
        [[*points, *[points[-1]] * (FACE_CORNERS - len(points))] for points, _ in faces], float
    )
    colours = np.array([(1.0, 1.0, 1.0) if rgb is None else rgb for _, rgb in faces], float)
    return Mesh(
        corners=corners,
        colours=colours,
        tinted=np.array([colour is None for _, colour in faces], bool),
        normals=np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]),
        glow=np.where(colours.max(axis=1) > 254.0, 1.0, 0.0),
    )


def _table_faces(kind: str) -> list[_Face]:
    """Return the faces of a table of config/meshes.yaml, in its order."""
    table = packaged_config("meshes")
    faces: list[_Face] = []
    sides: dict[str, Sequence[_Point]] = {}
    for row in table[kind]:
        if "prism" in row:
            parts = _prism(row)
            sides = dict(zip(_SIDES, parts))
        elif "disc" in row:
            parts = [_disc(row["disc"], row["radii"])]
        elif "pane" in row:
            side, *shares = row["pane"]
            parts = [_pane(sides[side], *shares)]
        else:
            parts = [row["face"]]
        faces += [(part, table["colours"].get(row.get("colour"))) for part in parts]
    return faces


def _prism(row: Mapping[str, Any]) -> list[Sequence[_Point]]:
    """Return the four sides, each from its bottom right corner, the top, and maybe the bottom."""
    base_z, top_z = row["z"]
    a, b = (
        [(x1, y0, z), (x1, y1, z), (x0, y1, z), (x0, y0, z)]
        for (x0, x1, y0, y1), z in ((row["prism"], base_z), (row["top"], top_z))
    )
    faces: list[Sequence[_Point]] = []
    for k in range(4):
        n = (k + 1) % 4
        faces.append([a[k], a[n], b[n], b[k]])
    faces.append(list(b))
    if row.get("bottom"):
        faces.append(a[::-1])
    return faces


def _disc(centre: _Point, radii: _Point) -> list[_Point]:
    """Return the corners of a disc in the plane of x and z that faces away from y = 0."""
    x, y, z = centre
    angles = _ANGLES_RAD if y < 0.0 else -_ANGLES_RAD
    return [(x + radii[0] * np.cos(t), y, z + radii[1] * np.sin(t)) for t in angles]


def _pane(
    side: Sequence[_Point], left: float, right: float, low: float, high: float
) -> list[_Point]:
    """Return the part of a side between these shares of its width and of its height."""
    a, b, c, d = (np.array(p, float) for p in side)

    def at(u: float, v: float) -> _Point:
        return tuple((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c))

    return [at(left, low), at(right, low), at(right, high), at(left, high)]
