"""A network of lanes and junctions: what a map of streets contains.

Positions are in the map frame of ROS (x forward, y left, metres), which is that of OpenDRIVE. The y
axis of CARLA points to the right: its (x, y) is (x, -y) here. `network_file` reads a network.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Iterable, Mapping, NamedTuple, Sequence

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.driving import other_level
from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_map.findings import Findings

# What is painted beside a lane. A kerb is no paint.
NONE, BROKEN, SOLID, DOUBLE, KERB = "none", "broken", "solid", "solid solid", "curb"
DRIVING, BICYCLE, WALKING, OTHER = "driving", "bicycle", "walking", "other"
STOP, YIELD = "stop", "yield"

# Centre lines are searched by points so far apart.
_SAMPLE_M = 1.0
# A lane in the opposite direction is as far as one that is so much more distant.
_AGAINST_M = 8.0
_CANDIDATES = 24
# A shorter lane, as between two sections of OpenDRIVE, has no direction [m].
_SHORTEST_M = 1e-3
# A line that runs so close to another one of the same kind is the same line.
_SAME_LINE_M = 0.4
# The lengths of the same line beside both of its lanes differ by less, as a share.
_SAME_LENGTH = 0.1
_AHEAD = 0.01  # share of the length of a line over which its direction is that of its middle
_MITRE = 2.0
# Bodies on two ways are clear of each other when these are so far apart.
_BODY_M = 3.0
# A lane on another level is as far as one that is so much more distant [m].
_OTHER_LEVEL_M = 1e6
# A map whose lanes are all this near to the height 0 is flat [m].
_FLAT_M = 0.05


@dataclass(frozen=True)
class RoadLane:
    """One lane, in its direction of travel."""

    id: str  # its name, that of SUMO
    points_m: np.ndarray = field(repr=False)  # (N, 2) centre line [m]
    width_m: float
    speed_limit_mps: float
    left_marking: str = NONE  # line on its left: NONE, BROKEN, SOLID, DOUBLE or KERB
    right_marking: str = NONE  # line on its right
    predecessors: tuple[str, ...] = ()  # lanes that lead into it
    successors: tuple[str, ...] = ()  # lanes into which it leads
    left: str = ""  # lane of the same direction on its left to which a car may change, "" if none
    right: str = ""  # the same on its right
    kind: str = DRIVING  # DRIVING, BICYCLE, WALKING or OTHER
    junction: str = ""  # the junction in which it lies, "" outside
    # (N,) height at the points [m]
    z_m: np.ndarray = field(default_factory=lambda: np.zeros(1), repr=False)
    s_m: np.ndarray = field(init=False, repr=False)  # (N,) arc length at the points [m]

    def __post_init__(self) -> None:
        object.__setattr__(self, "s_m", arc_lengths(self.points_m))
        object.__setattr__(self, "z_m", np.broadcast_to(self.z_m, len(self.s_m)))

    @cached_property
    def line(self) -> Polyline:
        """The centre line, for searches."""
        return Polyline(self.points_m.tolist(), extend=False)

    @property
    def length_m(self) -> float:
        """Length of the centre line [m]."""
        return float(self.s_m[-1])

    @property
    def samples_m(self) -> np.ndarray:
        """Arc lengths about 1 m apart, from the start to the end [m]."""
        return np.linspace(0.0, self.length_m, int(self.length_m / _SAMPLE_M) + 2)

    def at(self, s_m: np.ndarray) -> np.ndarray:
        """Return the points (M, 2) of the centre line at arc lengths (M,), clamped to it [m]."""
        return interpolate(s_m, self.s_m, self.points_m)

    def heading_at(self, s_m: float) -> float:
        """Return the direction of the centre line at an arc length [rad]."""
        return self.line.direction_at(s_m)

    def height_at(self, s_m: np.ndarray | float) -> np.ndarray:
        """Return the height at an arc length, or at several, clamped to the line [m]."""
        return np.interp(s_m, self.s_m, self.z_m)

    @cached_property
    def thinned(self) -> RoadLane:
        """The lane with points that are about 1 m apart, or farther.

        Where a file has corners, the lines beside a lane would fold between points that are closer.
        """
        rows = np.unique([*np.searchsorted(self.s_m, self.samples_m), len(self.s_m) - 1])
        return replace(self, points_m=self.points_m[rows], z_m=self.z_m[rows])

    def beside(self, offset_m: float) -> np.ndarray:
        """Return the line (N, 2) parallel to the centre line, positive to the left [m]."""
        normal = left_normals(self.points_m)
        steps = np.diff(self.points_m, axis=0)
        steps /= np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
        # At a bend the line is farther from the corner than from the segments.
        mitre = np.ones(len(normal))
        mitre[:-1] = np.abs(steps[:, 0] * normal[:-1, 1] - steps[:, 1] * normal[:-1, 0])
        return self.points_m + offset_m / np.maximum(mitre, 1.0 / _MITRE)[:, None] * normal

    @property
    def area_m(self) -> np.ndarray:
        """Outline (N, 2) of the lane [m]."""
        half_m = 0.5 * self.width_m
        return np.vstack([self.beside(half_m), self.beside(-half_m)[::-1]])


class Connection(NamedTuple):
    """One way through a junction."""

    start: str  # lane before the junction
    through: tuple[str, ...]  # lanes in the junction, in order
    end: str  # lane after it
    direction: str  # "s"traight, "l"eft, "r"ight, "t"urn around, as SUMO abbreviates them
    # Connections of the junction, by index, that have right of way over it.
    gives_way_to: tuple[int, ...] = ()
    signal: int = -1  # index of its state in the phases of the junction, -1 without a light
    line: str = ""  # STOP or YIELD where the road has such a line before it, else ""


@dataclass(frozen=True)
class Junction:
    """A junction of lanes."""

    id: str  # its name
    kind: str  # as SUMO names it: traffic_light, priority, right_before_left, allway_stop, ...
    polygon_m: np.ndarray = field(repr=False)  # (N, 2) outline [m]
    connections: tuple[Connection, ...] = ()  # the ways through it
    # (duration [s], letter G, g, y or r of each signal) of the program of its lights.
    phases: tuple[tuple[float, str], ...] = ()
    offset_s: float = 0.0  # time at which the first phase begins for the first time [s]

    def first(self, way: Connection) -> tuple[Connection, ...]:
        """Return the ways that have right of way over a way; of lights, those with green, too."""
        others = (self.connections[index] for index in way.gives_way_to)
        return tuple(one for one in others if self._may_meet(way, one))

    def _may_meet(self, one: Connection, other: Connection) -> bool:
        if not self.phases or min(one.signal, other.signal) < 0:
            return True
        return any({state[one.signal], state[other.signal]} <= {*"Gg"} for _, state in self.phases)


class Way(NamedTuple):
    """A way on from the lane before a junction."""

    connection: Connection
    first: tuple[Connection, ...]  # those that have right of way over it
    junction: str  # id of the junction


class Line(NamedTuple):
    """A painted line or a kerb: points (N, 2) [m], BROKEN, SOLID, DOUBLE or KERB, heights [m]."""

    points_m: np.ndarray
    kind: str
    z_m: np.ndarray


class LanePlace(NamedTuple):
    """The place on a lane that is nearest to a pose."""

    lane: str  # id of the lane
    s_m: float  # arc length of the place [m]
    cross_track_m: float  # distance of the pose, positive to the left of the lane [m]
    heading_error_rad: float  # heading of the pose minus that of the lane, in -pi..pi [rad]


class Network:
    """Lanes and junctions."""

    def __init__(
        self,
        name: str,
        lanes: Iterable[RoadLane],
        junctions: Iterable[Junction] = (),
        crosswalks: Iterable[np.ndarray] = (),
        bays: Iterable[np.ndarray] = (),
        bus_stops: Iterable[np.ndarray] = (),
        right_hand: Network | None = None,
    ):
        """Index the lanes.

        Raises:
            ValueError: there is no lane for cars
        """
        self.name = name
        # These streets with traffic on the right, for which the rules of the road are written: this
        # network, or that of which it is the mirror image; and the factor of y and angles there.
        self.right_hand, self.y_sign = right_hand or self, -1.0 if right_hand else 1.0
        self.lanes: Mapping[str, RoadLane] = {lane.id: lane for lane in lanes}
        self.junctions: Mapping[str, Junction] = {one.id: one for one in junctions}
        self.is_flat = not any(np.abs(one.z_m).max() > _FLAT_M for one in self.lanes.values())
        self.ground = None if self.is_flat else self.ground_at
        self.ways: dict[str, list[Way]] = {}  # by the lane before a junction
        for junction in self.junctions.values():
            for one in junction.connections:
                first = tuple(way for way in junction.first(one) if not self.is_over(one, way))
                self.ways.setdefault(one.start, []).append(Way(one, first, junction.id))
        self._clear_m: dict[tuple[Connection, Connection], float] = {}
        self.crosswalks = tuple(crosswalks)  # polygons (N, 2) [m]
        # Parking bays (4, 2), the first two corners at the lane, and areas of bus stops (4, 2), the
        # first two corners at the outer edge of a lane [m].
        self.bays, self.bus_stops = tuple(bays), tuple(bus_stops)
        self.findings = Findings()  # what the file has otherwise
        self.net_path = ""  # file of SUMO's network
        self.driving = [lane for lane in self.lanes.values() if lane.kind == DRIVING]
        if not self.driving:
            raise ValueError(f"the map {name} has no lane for cars")
        points = np.vstack([lane.points_m for lane in self.driving])
        # Least x, least y, greatest x and greatest y of the lanes.
        self.bounds_m = (*points.min(axis=0).tolist(), *points.max(axis=0).tolist())
        # Segments (2, 2) across the ends of lanes [m], and STOP or YIELD.
        self.stop_lines = tuple(self._stop_lines())
        if right_hand is not None:
            return  # It has the index of places.
        long = [(lane, lane.samples_m) for lane in self.driving if lane.length_m > _SHORTEST_M]
        self._s_m = np.concatenate([s for _, s in long])
        self._lanes = [lane for lane, s in long for _ in s]
        headings = [_heading(lane.points_m, lane.s_m, s) for lane, s in long]
        self._heading_rad = np.concatenate(headings)
        self._z_m = np.concatenate([lane.height_at(s) for lane, s in long])
        self._tree = cKDTree(np.vstack([lane.at(s) for lane, s in long]))

    def clear_m(self, way: Connection, other: Connection) -> float:
        """Return the distance along a way through a junction after which it is clear of another."""
        if (way, other) not in self._clear_m:
            points, theirs = self._sampled(way)[:, :2], self._sampled(other)[:, :2]
            near = np.hypot(*(points[:, None] - theirs).transpose(2, 0, 1)).min(axis=1) < _BODY_M
            s_m = arc_lengths(points)
            self._clear_m[way, other] = float(s_m[near][-1] if near.any() else s_m[-1])
        return self._clear_m[way, other]

    def _sampled(self, way: Connection) -> np.ndarray:
        """Return points (N, 3) along a way through a junction [m]."""
        points = [] if way.through else [np.zeros((1, 3))]
        for lane in (self.lanes[name] for name in way.through):
            s_m = lane.samples_m
            points.append(np.column_stack([lane.at(s_m), lane.height_at(s_m)]))
        return np.vstack(points)

    def is_over(self, way: Connection, other: Connection) -> bool:
        """Return whether a way through a junction leads over or under another one."""
        if self.is_flat:
            return False
        apart = self._sampled(way)[:, None] - self._sampled(other)
        heights_m = apart[np.hypot(apart[..., 0], apart[..., 1]) < _BODY_M, 2]
        return len(heights_m) > 0 and bool(other_level(heights_m, 0.0).all())

    def straight_on(self, lane: RoadLane) -> RoadLane | None:
        """Return the lane after this one that turns least, None at a dead end."""
        end_rad = lane.heading_at(lane.length_m)
        following = [self.lanes[name] for name in lane.successors]
        turns = [abs(wrap_angle(one.heading_at(0.0) - end_rad)) for one in following]
        return following[turns.index(min(turns))] if following else None

    def nearest(
        self,
        x_m: float,
        y_m: float,
        yaw_rad: float | None = None,
        within_m: float = math.inf,
        z_m: float = math.nan,
    ) -> LanePlace | None:
        """Return the place on the nearest lane for cars, None if there is none so near.

        Args:
            x_m: position [m]
            y_m: position [m]
            yaw_rad: heading; lanes of the opposite direction count as more distant [rad]
            within_m: greatest distance [m]
            z_m: height, NaN: unknown; lanes of other levels are far away [m]
        """
        if self.right_hand is not self:
            yaw_rad = None if yaw_rad is None else -yaw_rad
            found = self.right_hand.nearest(x_m, -y_m, yaw_rad, within_m, z_m)
            return found and LanePlace(*found[:2], -found.cross_track_m, -found.heading_error_rad)
        candidates = 4 * _CANDIDATES
        if self.is_flat:  # a car that measures another height is on its lane, too
            candidates, z_m = _CANDIDATES, math.nan
        distance_m, rows = self._tree.query((x_m, y_m), min(candidates, len(self._s_m)))
        over_m = _OTHER_LEVEL_M * other_level(self._z_m[rows], z_m)
        cost = distance_m + over_m
        if yaw_rad is not None:
            cost += _AGAINST_M * 0.5 * (1.0 - np.cos(self._heading_rad[rows] - yaw_rad))
        best = int(np.argmin(cost))
        row = int(rows[best])
        lane, s_m = self._lanes[row], float(self._s_m[row])
        place = lane.line.project(x_m, y_m, s_m, 2.0 * _SAMPLE_M, 2.0 * _SAMPLE_M)
        if place.distance_m + over_m[best] > within_m:
            return None
        error = 0.0 if yaw_rad is None else yaw_rad - lane.heading_at(place.s_m)
        error = math.remainder(error, 2.0 * math.pi)
        return LanePlace(lane.id, place.s_m, place.cross_track_m, error)

    def height_of(self, place: LanePlace) -> float:
        """Return the height of a place [m]."""
        return float(self.lanes[place.lane].height_at(place.s_m))

    def ground_at(
        self, x_m: float, y_m: float, yaw_rad: float, z_m: float = math.nan
    ) -> tuple[float, float]:
        """Return height [m] and pitch [rad], positive downhill, of the lane at a pose.

        The lane is one on the level of `z_m`, the last height of what is there [m].
        """
        place = self.nearest(x_m, y_m, yaw_rad, z_m=z_m)
        assert place is not None
        lane = self.lanes[place.lane]
        segment, _ = lane.line.segment_at(place.s_m)
        rise_m = float(lane.z_m[segment + 1] - lane.z_m[segment])
        slope = rise_m / max(lane.line.lengths[segment], 1e-9) * math.cos(place.heading_error_rad)
        return self.height_of(place), -math.atan(slope)

    def oncoming_lane(
        self, lane: RoadLane, pose: Sequence[float], within_m: float, turned_rad: float
    ) -> RoadLane | None:
        """Return the lane of the other direction beside a lane, outside junctions.

        Args:
            lane: the lane
            pose: x, y [m] and heading [rad] of a place on it
            within_m: greatest distance of the other lane from a lane's width beside the place [m]
            turned_rad: greatest difference from the opposite direction [rad]
        """
        x, y, yaw = pose
        z_m = float(lane.height_at(lane.line.nearest(x, y).s_m))
        left_m = self.y_sign * lane.width_m
        x, y = x - left_m * math.sin(yaw), y + left_m * math.cos(yaw)
        found = self.nearest(x, y, yaw + math.pi, within_m, z_m)
        if found is None or abs(found.heading_error_rad) > turned_rad:
            return None
        beside = self.lanes[found.lane]
        return None if beside.junction else beside

    def lines(self) -> list[Line]:
        """Return what is painted along the lanes, and the kerbs; a shared line only once."""
        found: dict[str, list[tuple[float, ...]]] = {}
        lines = []
        for lane in self.driving:
            smooth = lane.thinned
            for side, kind in ((0.5, lane.left_marking), (-0.5, lane.right_marking)):
                if kind == NONE or len(lane.points_m) < 2:
                    continue
                line = Line(smooth.beside(side * lane.width_m), kind, smooth.z_m)
                s_m = arc_lengths(line.points_m)
                length_m = float(s_m[-1])
                middle, ahead = interpolate(
                    np.array([0.5, 0.5 + _AHEAD]) * length_m, s_m, line.points_m
                )
                row = (*middle, length_m)
                others = found.setdefault(kind, [])
                if not _is_among(others, row, (ahead - middle) / (_AHEAD * length_m)):
                    others.append(row)
                    lines.append(line)
        return lines

    def _stop_lines(self) -> Iterable[tuple[np.ndarray, str]]:
        for junction in self.junctions.values():
            kinds = {one.start: one.line for one in junction.connections if one.line}
            for name, kind in kinds.items():
                lane = self.lanes[name]
                direction = lane.heading_at(lane.length_m)
                left = 0.5 * lane.width_m * np.array([-math.sin(direction), math.cos(direction)])
                end = lane.points_m[-1]
                yield np.array([end - left, end + left]), kind


def _is_among(lines: list[tuple[float, ...]], line: tuple[float, ...], along: np.ndarray) -> bool:
    """Return whether a line is one of others of its kind.

    Those of both lanes beside it have other lengths in a bend, so that their middles differ.

    Args:
        lines: x and y of the middle of each other line, and its length [m]
        line: the same of the line
        along: its direction at its middle, a unit vector
    """
    if not lines:
        return False
    apart = np.array(lines) - line
    along_m, across_m = np.abs(apart[:, :2] @ np.array([along, [-along[1], along[0]]]).T).T
    longer_m = along_m + np.abs(apart[:, 2])
    is_near = (along_m < _SAME_LINE_M) | (longer_m < _SAME_LENGTH * line[2])
    return bool((is_near & (across_m < _SAME_LINE_M)).any())


def edge_of(lane: str) -> str:
    """Return the edge, as SUMO calls the lanes beside one another, of the lane with this id."""
    return lane.rpartition("_")[0]


def part_of(points_m: np.ndarray, s_m: np.ndarray, start_m: float, end_m: float) -> np.ndarray:
    """Return the part (M, 2) of a line with points (N, 2) at `s_m` (N,) between two places [m]."""
    inside = s_m[(s_m > start_m) & (s_m < end_m)]
    return interpolate(np.array([start_m, *inside, end_m]), s_m, points_m)


def left_normals(points_m: np.ndarray) -> np.ndarray:
    """Return unit vectors (N, 2) to the left of a line at its points (N, 2)."""
    steps = np.diff(points_m, axis=0)
    steps /= np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
    tangent = np.vstack([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    return normal / np.maximum(np.hypot(*normal.T), 1e-9)[:, None]


def _heading(points: np.ndarray, s: np.ndarray, at: np.ndarray) -> np.ndarray:
    segment = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(points) - 2)
    step = points[segment + 1] - points[segment]
    return np.arctan2(step[:, 1], step[:, 0])
