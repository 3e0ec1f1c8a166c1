"""What netconvert does not read of OpenDRIVE: exact centre lines, and lines beside lanes.

netconvert gives each lane one width and shifts straight roads at their ends only: where a width or
a lane offset changes along a road, its lanes are up to metres beside those of the file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from typing import Iterable

import numpy as np
from scipy.interpolate import interp1d
from scipy.spatial import cKDTree
from scipy.special import fresnel

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_map.network import BROKEN, DOUBLE, KERB, NONE, SOLID
from sdc_map.opendrive_file import sections

_STEP_M = 0.25
# Centre lines of netconvert that are farther from the exact one are replaced.
_TOLERANCE_M = 0.01


class OpenDriveLanes:
    """Lanes of an OpenDRIVE file by road and lane id."""

    def __init__(self, root: ElementTree.Element):
        """Read the tree of a file, that of `read_opendrive`.

        Raises:
            ElementTree.ParseError, KeyError, ValueError: it is not valid OpenDRIVE
        """
        # Speed limits along a lane, in no order [m/s].
        self.limits_mps: dict[tuple[str, str], list[float]] = defaultdict(list)
        self._lines: dict[tuple[str, str], list[np.ndarray]] = defaultdict(list)
        marked: dict = defaultdict(lambda: defaultdict(float))  # length of each marking
        for road in root.iter("road"):
            name = road.attrib["id"]
            for section, start, end in sections(road):
                for lane in section.iter("lane"):
                    limits = (float(speed.attrib["max"]) for speed in lane.findall("speed"))
                    self.limits_mps[name, lane.attrib["id"]] += limits
                    marks = lane.findall("roadMark")
                    at = [*(float(mark.attrib["sOffset"]) for mark in marks), end - start]
                    for mark, first, last in zip(marks, at, at[1:]):
                        marked[name, lane.attrib["id"]][mark.attrib["type"]] += last - first
                for number, line in _centre_lines(road, section, start, end):
                    self._lines[name, number].append(line)
        self._markings = {key: max(own, key=own.__getitem__) for key, own in marked.items()}

    def exact(self, road: str, lane: str, points_m: np.ndarray) -> np.ndarray:
        """Return a centre line (N, 2), moved to the exact one if it is beside it [m]."""
        lines = self._lines.get((road, lane))
        if not lines or len(points_m) < 2:
            return points_m
        line = np.vstack(lines)
        s = arc_lengths(points_m)
        at = np.linspace(0.0, s[-1], int(s[-1] / (2.0 * _STEP_M)) + 2)
        dense = interpolate(at, s, points_m)
        _, nearest = cKDTree(line).query(dense)
        best, distance = dense, np.full(len(dense), np.inf)
        for first in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(line) - 2)):
            step = line[first + 1] - line[first]
            square = np.maximum(np.sum(step * step, axis=1), 1e-12)
            share = np.clip(np.sum((dense - line[first]) * step, axis=1) / square, 0.0, 1.0)
            foot = line[first] + share[:, None] * step
            away = np.hypot(*(dense - foot).T)
            best = np.where((away < distance)[:, None], foot, best)
            distance = np.minimum(away, distance)
        return best if distance.max() > _TOLERANCE_M else points_m

    def beside(self, road: str, lane: str) -> tuple[str, str]:
        """Return the lines on the left and on the right of a lane; each lane has its outer one."""
        inner = int(lane) - (1 if int(lane) > 0 else -1)
        return self._marking(road, str(inner)), self._marking(road, lane)

    def _marking(self, road: str, lane: str) -> str:
        kind = self._markings.get((road, lane), NONE)
        if kind in (NONE, KERB):
            return kind
        return DOUBLE if " " in kind else BROKEN if kind.startswith("b") else SOLID


def _centre_lines(
    road: ElementTree.Element, section: ElementTree.Element, start_m: float, end_m: float
) -> Iterable[tuple[str, np.ndarray]]:
    """Return id and centre line (N, 2) of the lanes of a section, in the direction of the road."""
    s = np.linspace(start_m, end_m, int((end_m - start_m) / _STEP_M) + 2)
    points, heading = _reference_line(road, s)
    left = np.column_stack([-np.sin(heading), np.cos(heading)])
    offset = _cubic(road.findall("lanes/laneOffset"), "s", s)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        edge = offset
        lanes = section.findall(side + "/lane")
        for lane in sorted(lanes, key=lambda one: abs(int(one.attrib["id"]))):
            width = sign * _cubic(lane.findall("width"), "sOffset", s - start_m)
            yield lane.attrib["id"], points + (edge + 0.5 * width)[:, None] * left
            edge = edge + width


def _cubic(pieces: list[ElementTree.Element], key: str, s: np.ndarray) -> np.ndarray:
    """Return a piecewise cubic at places (N,); pieces begin at their `key`."""
    if not pieces:
        return np.zeros(len(s))
    table = np.array([[float(one.attrib[name]) for name in (key, *"abcd")] for one in pieces])
    start, a, b, c, d = table[np.maximum(np.searchsorted(table[:, 0], s + 1e-9) - 1, 0)].T
    t = s - start
    return a + t * (b + t * (c + t * d))


def _reference_line(road: ElementTree.Element, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (N, 2) and headings (N,) of the reference line at arc lengths (N,)."""
    pieces = road.findall("planView/geometry")
    starts = np.array([float(one.attrib["s"]) for one in pieces])
    of = np.maximum(np.searchsorted(starts, s + 1e-9) - 1, 0)
    place, heading = np.zeros(len(s), complex), np.zeros(len(s))
    for number in np.unique(of):
        piece, rows = pieces[number], of == number
        x, y, turn, length = (float(piece.attrib[name]) for name in ("x", "y", "hdg", "length"))
        along, angle = _shape(piece[0], s[rows] - starts[number], length)
        place[rows], heading[rows] = complex(x, y) + np.exp(1j * turn) * along, turn + angle
    return np.column_stack([place.real, place.imag]), heading


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
    if shape.tag == "poly3":
        u = np.linspace(0.0, length_m, int(length_m / 0.1) + 2)
        at = arc_lengths(np.column_stack([u, _polynomial(number, "", u)]))
        p = interp1d(at, u, fill_value="extrapolate")(t)
        return p + 1j * _polynomial(number, "", p), np.arctan(_slope(number, "", p))
    if shape.tag != "paramPoly3":
        raise ValueError(f"unknown geometry {shape.tag}")
    p = t if shape.get("pRange") == "arcLength" else t / length_m
    u, v = (_polynomial(number, axis, p) for axis in "UV")
    return u + 1j * v, np.arctan2(_slope(number, "V", p), _slope(number, "U", p))


def _polynomial(number: dict[str, float], axis: str, p: np.ndarray) -> np.ndarray:
    a, b, c, d = (number[name + axis] for name in "abcd")
    return a + p * (b + p * (c + p * d))


def _slope(number: dict[str, float], axis: str, p: np.ndarray) -> np.ndarray:
    return number["b" + axis] + p * (2.0 * number["c" + axis] + 3.0 * p * number["d" + axis])
