"""What netconvert does not read of OpenDRIVE: exact centre lines, and lines beside lanes.

netconvert gives each lane one width and shifts straight roads at their ends only: where a width or
a lane offset changes along a road, its lanes are up to metres beside those of the file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from typing import Iterable, NamedTuple

import numpy as np

from sdc_map.network import BROKEN, DOUBLE, KERB, NONE, SOLID, part_of
from sdc_map.road_geometry import piecewise_cubic, reference_line, sections

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
            ElementTree.ParseError, KeyError, ValueError: it is not valid OpenDRIVE
        """
        # Speed limits along a lane, in no order [m/s].
        self.limits_mps: dict[tuple[str, str], list[float]] = defaultdict(list)
        # Of each lane section of a road, the lanes by their ids.
        self._sections: dict[str, list[dict[str, Piece]]] = defaultdict(list)
        # Start and end along the road [m] and type of what is painted at the outer edge of a lane.
        self._marks: dict[tuple[str, str], list[tuple[float, float, str]]] = defaultdict(list)
        for road in root.iter("road"):
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
