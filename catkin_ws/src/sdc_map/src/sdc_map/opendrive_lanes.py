"""What netconvert does not read of OpenDRIVE: exact centre lines, and lines beside lanes.

netconvert gives each lane one width and shifts straight roads at their ends only: where a width or
a lane offset changes along a road, its lanes are up to metres beside those of the file.
"""

from __future__ import annotations

import contextlib
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from typing import Iterable, Iterator, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import fresnel

from sdc_map.network import BROKEN, DOUBLE, KERB, NONE, SOLID, part_of

_STEP_M = 0.25
# Ends of lines that are farther from each other do not belong together.
_APART_M = 0.5


class Piece(NamedTuple):
    """A lane in one lane section."""

    s_m: np.ndarray  # (N,) places along the road [m]
    points_m: np.ndarray  # (N, 3) its centre line, in the direction of the road [m]
    before: str  # id of the lane before it along the road
    after: str  # id of the lane after it


class OpenDriveLanes:
    """Lanes of an OpenDRIVE file by road and lane id."""

    def __init__(self, root: ElementTree.Element):
        """Read the tree of a file, that of `read_opendrive`.

        Raises:
            ValueError: it is not valid OpenDRIVE
        """
        # Speed limits along a lane, in no order [m/s].
        self.limits_mps: dict[tuple[str, str], list[float]] = defaultdict(list)
        # Of each lane section of a road, the lanes by their ids.
        self._sections: dict[str, list[dict[str, Piece]]] = defaultdict(list)
        # Start and end along the road [m] and type of what is painted at the outer edge of a lane.
        self._marks: dict[tuple[str, str], list[tuple[float, float, str]]] = defaultdict(list)
        self.lights: list[tuple[str, tuple[float, float]]] = []  # name and place [m] of each
        for road in root.iter("road"):
            with named_road(road):
                self._read(road)

    def _read(self, road: ElementTree.Element) -> None:
        name = road.attrib["id"]
        for section, start, end in sections(road):
            for lane in section.iter("lane"):
                limits = (float(speed.attrib["max"]) for speed in lane.findall("speed"))
                self.limits_mps[name, lane.attrib["id"]] += limits
                marks = lane.findall("roadMark")
                at = [*(float(mark.attrib["sOffset"]) for mark in marks), end - start]
                for mark, first, last in zip(marks, at, at[1:]):
                    row = start + first, start + last, mark.attrib["type"]
                    self._marks[name, lane.attrib["id"]].append(row)
            self._sections[name].append(dict(pieces(road, section, start, end)))
        for signal in road.findall("signals/signal"):
            if signal.get("dynamic") == "yes":
                point_m = point_at(road, float(signal.attrib["s"]))
                self.lights.append((f"signal {signal.get('id')} of road {name}", point_m))

    def length_m(self, road: str) -> float:
        """Return the length of a road [m]."""
        return float(self._sections[road][-1]["0"].s_m[-1])

    def place_m(self, road: str, x_m: float, y_m: float) -> float:
        """Return the place along a road that is nearest to a point of its reference line [m]."""
        reference = [section["0"] for section in self._sections[road]]
        s = np.concatenate([piece.s_m for piece in reference])
        points = np.vstack([piece.points_m[:, :2] for piece in reference])
        row = min(int(np.argmin(np.hypot(*(points - (x_m, y_m)).T))), len(s) - 2)
        step = points[row + 1] - points[row]
        share = (np.array([x_m, y_m]) - points[row]) @ step / max(step @ step, 1e-9)
        s_m = float(s[row] + share * (s[row + 1] - s[row]))
        border_m = min((piece.s_m[0] for piece in reference), key=lambda s: abs(s - s_m))
        return float(border_m) if abs(border_m - s_m) < _STEP_M else s_m

    def line(self, road: str, lane: str, start_m: float, end_m: float) -> np.ndarray | None:
        """Return the centre line (N, 3) of a lane between two places along its road.

        It is in the direction of travel, and within the lane section in the middle of both.
        """
        middle_m = 0.5 * (start_m + end_m)
        for section in self._sections.get(road, ()):
            piece = section.get(lane)
            if piece is not None and piece.s_m[0] <= middle_m <= piece.s_m[-1]:
                ends_m = max(start_m, piece.s_m[0]), min(end_m, piece.s_m[-1])
                points = part_of(piece.points_m, piece.s_m, *ends_m)
                return points if lane.startswith("-") else points[::-1]
        return None

    def through(self, road: str, lane: str) -> np.ndarray | None:
        """Return the centre line (N, 3) along a whole road from a lane of its first section.

        It is in the direction of travel; None if there is no line without a jump.
        """
        lines: list[np.ndarray] = []
        forward = lane.startswith("-")
        for section in self._sections.get(road, [])[:: 1 if forward else -1]:
            if lane not in section:
                return None
            points = section[lane].points_m[:: 1 if forward else -1]
            if lines and np.hypot(*(points[0] - lines[-1][-1])[:2]) > _APART_M:
                return None
            lines.append(points)
            lane = section[lane].after if forward else section[lane].before
        return np.vstack(lines) if lines else None

    def beside(self, road: str, lane: str, start_m: float, end_m: float) -> tuple[str, str]:
        """Return the lines on the left and on the right of a lane between places along its road.

        Each lane has its outer one.
        """
        inner = int(lane) - (1 if int(lane) > 0 else -1)
        left, right = (self._marking(road, one, start_m, end_m) for one in (str(inner), lane))
        return left, right

    def _marking(self, road: str, lane: str, start_m: float, end_m: float) -> str:
        lengths: dict[str, float] = defaultdict(float)
        for first_m, last_m, kind in self._marks.get((road, lane), ()):
            lengths[kind] += max(0.0, min(last_m, end_m) - max(first_m, start_m))
        kind = max(lengths, key=lengths.__getitem__, default=NONE)
        if kind in (NONE, KERB):
            return kind
        return DOUBLE if " " in kind else BROKEN if kind.startswith("b") else SOLID


def pieces(
    road: ElementTree.Element, section: ElementTree.Element, start_m: float, end_m: float
) -> Iterable[tuple[str, Piece]]:
    """Return ids and lanes of a section, and the reference line as that of lane 0."""
    s = np.linspace(start_m, end_m, int((end_m - start_m) / _STEP_M) + 2)
    points, heading = reference_line(road, s)
    heights = piecewise_cubic(road.findall("elevationProfile/elevation"), "s", s)
    points = np.column_stack([points, heights])
    left = np.column_stack([-np.sin(heading), np.cos(heading), np.zeros(len(s))])
    offset = piecewise_cubic(road.findall("lanes/laneOffset"), "s", s)
    yield "0", Piece(s, points, "0", "0")
    for side, sign in (("left", 1.0), ("right", -1.0)):
        edge = offset
        lanes = section.findall(side + "/lane")
        for lane in sorted(lanes, key=lambda one: abs(int(one.attrib["id"]))):
            width = sign * piecewise_cubic(lane.findall("width"), "sOffset", s - start_m)
            number = lane.attrib["id"]
            links = (lane.find("link/" + way) for way in ("predecessor", "successor"))
            ids = (number if link is None else link.attrib["id"] for link in links)
            line = points + (edge + 0.5 * width)[:, None] * left
            kept = _ahead(line[:, :2], np.column_stack([left[:, 1], -left[:, 0]]))
            yield number, Piece(s[kept], line[kept], *ids)
            edge = edge + width


def _ahead(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the rows of the points of a lane that are ahead of those before.

    Inside a corner, and inside a bend of the road closer than the lane, the others are not.
    """
    rows = np.arange(len(points))
    if (np.sum(np.diff(points, axis=0) * directions[1:], axis=1) > 0.0).all():
        return rows
    kept = [0]
    for row in rows[1:]:
        if (points[row] - points[kept[-1]]) @ directions[row] > 0.0:
            kept.append(row)
    return np.array([*kept[: max(len(kept) - 1, 1)], rows[-1]])


@contextlib.contextmanager
def named_road(road: ElementTree.Element) -> Iterator[None]:
    """Raise ValueError with the name of a road for what is missing or wrong in it."""
    try:
        yield
    except (LookupError, ValueError) as error:
        reason = f"an element lacks {error}" if isinstance(error, LookupError) else error
        raise ValueError(f"road {road.get('id')}: {reason}; correct it there") from None


def sections(road: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, float, float]]:
    """Return the lane sections of a road with their start and end along it [m]."""
    found = road.findall("lanes/laneSection")
    ends = [*(float(section.attrib["s"]) for section in found), float(road.attrib["length"])]
    if any(end < start - _STEP_M for start, end in zip(ends, ends[1:])):
        raise ValueError(f"its lane sections and its end are at {ends} m, in a wrong order")
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
    if not pieces:
        raise ValueError("has no geometry")
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
