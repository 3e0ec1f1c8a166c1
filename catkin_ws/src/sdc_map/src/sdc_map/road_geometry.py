"""Reference lines and piecewise cubics of roads of OpenDRIVE."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Iterator

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import fresnel


def sections(road: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, float, float]]:
    """Return the lane sections of a road with their start and end along it [m]."""
    found = road.findall("lanes/laneSection")
    ends = [*(float(section.attrib["s"]) for section in found), float(road.attrib["length"])]
    return zip(found, ends, ends[1:])


def cubics(pieces: list[ElementTree.Element], key: str) -> np.ndarray:
    """Return start and coefficients (N, 5) of the pieces of a piecewise cubic."""
    rows = [[float(piece.attrib[name]) for name in (key, *"abcd")] for piece in pieces]
    return np.array(rows).reshape(-1, 5)


def piecewise_cubic(pieces: list[ElementTree.Element], key: str, s: np.ndarray) -> np.ndarray:
    """Return a piecewise cubic at places (N,); pieces begin at their `key`."""
    if not pieces:
        return np.zeros(len(s))
    table = cubics(pieces, key)
    start, a, b, c, d = table[np.maximum(np.searchsorted(table[:, 0], s + 1e-9) - 1, 0)].T
    t = s - start
    return a + t * (b + t * (c + t * d))


def reference_line(road: ElementTree.Element, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (N, 2) and headings (N,) of the reference line at arc lengths (N,)."""
    pieces = road.findall("planView/geometry")
    starts = np.array([float(piece.attrib["s"]) for piece in pieces])
    of = np.maximum(np.searchsorted(starts, s + 1e-9) - 1, 0)
    place, heading = np.zeros(len(s), complex), np.zeros(len(s))
    for number in np.unique(of):
        piece, rows = pieces[number], of == number
        x, y, turn, length = (float(piece.attrib[name]) for name in ("x", "y", "hdg", "length"))
        along, angle = _shape(piece[0], s[rows] - starts[number], length)
        place[rows], heading[rows] = complex(x, y) + np.exp(1j * turn) * along, turn + angle
    return np.column_stack([place.real, place.imag]), heading


def point_at(road: ElementTree.Element, s_m: float) -> tuple[float, float]:
    """Return x and y of the reference line at an arc length [m]."""
    x_m, y_m = reference_line(road, np.array([s_m]))[0][0].tolist()
    return x_m, y_m


def _shape(shape: ElementTree.Element, t: np.ndarray, length_m: float) -> tuple:
    """Return places, as complex numbers, and directions at arc lengths along a shape."""
    if shape.tag == "line":
        return t + 0j, np.zeros(len(t))
    number = {name: float(value) for name, value in shape.attrib.items() if name != "pRange"}
    if shape.tag in ("arc", "spiral"):
        first = number.get("curvature", number.get("curvStart", 0.0))
        change = (number.get("curvEnd", first) - first) / length_m
        angle = first * t + 0.5 * change * t * t
        if abs(change) < 1e-9:
            return (t + 0j if abs(first) < 1e-9 else 1j * (1.0 - np.exp(1j * angle)) / first), angle
        # The integral of exp(i (k t + c t^2 / 2)) by completing the square.
        scale = np.sqrt(np.pi / abs(change))
        sine, cosine = fresnel((np.append(0.0, t) + first / change) / scale)
        spiral = scale * (cosine + 1j * np.sign(change) * sine)
        return np.exp(-0.5j * first * first / change) * (spiral[1:] - spiral[0]), angle
    if shape.tag not in ("poly3", "paramPoly3"):
        raise ValueError(f"unknown geometry {shape.tag}")
    if shape.tag == "poly3":
        number = {name + "V": value for name, value in number.items()}
        number.update(aU=0.0, bU=1.0, cU=0.0, dU=0.0)
    curve = Polynomial([complex(number[name + "U"], number[name + "V"]) for name in "abcd"])
    has_length = shape.tag == "poly3" or shape.get("pRange") == "arcLength"
    # The parameter is neither an arc length nor a share of it in all files.
    p = np.linspace(0.0, length_m if has_length else 1.0, int(length_m / 0.1) + 2)
    p = np.interp(t, np.append(0.0, np.cumsum(np.abs(np.diff(curve(p))))), p)
    return curve(p), np.angle(curve.deriv()(p))
