"""Traffic signs of the camera picture."""

from __future__ import annotations

import numpy as np

from sdc_sim.camera.rasterizer import Solid
from sdc_sim.road.scenery import PRIORITY_SIGN, STOP_SIGN, YIELD_SIGN, Scenery
from sdc_sim.yaml_document import packaged_config

_RED, _WHITE, _BLACK, _YELLOW = (30, 20, 190), (235, 235, 235), (25, 25, 25), (20, 190, 245)
# Blue, green and red of a pole, 0..255: as bright as grass, so that a pole has no steep edges below
# the horizon.
_GREY = (92, 92, 92)
# The same of the back of a plate.
_BACK = (105, 105, 105)
_PLATE_M, _POLE_M = 0.65, 0.08  # width of a plate and of its pole
_PAINT = packaged_config("signs")


def sign(scenery: Scenery, item: int) -> Solid:
    """Return the faces of a sign of the scenery: its pole, and what is painted on the plate."""
    number, height_m = int(scenery.variant[item]), float(scenery.size_m[item, 2])
    shapes, plate = [], _plate(number)
    for outline, bgr in plate:
        shapes += [(quad, bgr, 1.0) for quad in _quads(np.array(outline, float))]
    shapes += [(quad[::-1], _BACK, -1.0) for quad in _quads(np.array(plate[0][0], float))]
    side, low = _POLE_M / _PLATE_M, 1.0 - 2.0 * height_m / _PLATE_M
    pole = np.array([(-side, low), (side, low), (side, -0.9), (-side, -0.9)])
    shapes = [(pole, _GREY, 1.0), (pole[::-1], _GREY, -1.0), *shapes]
    yaw = float(scenery.yaw_rad[item])
    face, left = np.array([np.cos(yaw), np.sin(yaw), 0]), np.array([-np.sin(yaw), np.cos(yaw), 0])
    middle = np.array([*scenery.position_m[item], height_m - 0.5 * _PLATE_M])
    half_m = 0.5 * _PLATE_M
    # Seen from ahead, left of the sign is to the right.
    corners = [
        middle + half_m * (quad[:, :1] * left + quad[:, 1:] * (0, 0, 1)) for quad, _, _ in shapes
    ]
    normals = [side * face for _, _, side in shapes]
    bgr = np.array([colour for _, colour, _ in shapes], float)
    return Solid(np.array(corners), np.array(normals), bgr, np.zeros(len(bgr), bool))


def _plate(number: int) -> list[tuple]:
    """Return outlines on a plate of -1..1, counter-clockwise, and their colours, back to front."""
    if number == STOP_SIGN:
        text = _text(_PAINT["stop"], 0.3, 0.15)
        return [(_ring(8, 1.0), _WHITE), (_ring(8, 0.92), _RED), *((part, _WHITE) for part in text)]
    if number == YIELD_SIGN:
        triangle = np.array([(0.0, -1.0), (1.0, 0.75), (-1.0, 0.75)])
        return [(triangle, _RED), (0.62 * triangle + (0.0, 0.08), _WHITE)]
    if number == PRIORITY_SIGN:
        diamond = np.array([(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)])
        return [(diamond, _BLACK), (0.95 * diamond, _WHITE), (0.7 * diamond, _YELLOW)]
    digits = [_PAINT["digits"][int(digit)] for digit in str(number)]
    text = _text(digits, 0.3 if len(digits) > 2 else 0.42, 0.22)
    return [(_ring(16, 1.0), _RED), (_ring(16, 0.78), _WHITE), *((digit, _BLACK) for digit in text)]


def _ring(count: int, radius: float) -> np.ndarray:
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _text(characters: list | tuple, width: float, height: float) -> list[np.ndarray]:
    """Return the strokes (4, 2) of characters beside one another."""
    outlines = []
    for place, strokes in enumerate(characters):
        middle = 1.35 * width * (place - 0.5 * (len(characters) - 1))
        for stroke in strokes:
            x0, y0, x1, y1 = _PAINT["strokes"][stroke] * np.array([0.45 * width, height] * 2)
            thick = 0.06 * width + 0.02
            low = np.minimum((x0, y0), (x1, y1)) - thick
            high = np.maximum((x0, y0), (x1, y1)) + thick
            corners = [low, (high[0], low[1]), high, (low[0], high[1])]
            outlines.append(np.array(corners) + (middle, 0.0))
    return outlines


def _quads(outline: np.ndarray) -> list[np.ndarray]:
    """Return a convex outline (N, 2) as quadrilaterals (4, 2)."""
    rows = [[0, i, i + 1, min(i + 2, len(outline) - 1)] for i in range(1, len(outline) - 1, 2)]
    return [outline[row] for row in rows]
