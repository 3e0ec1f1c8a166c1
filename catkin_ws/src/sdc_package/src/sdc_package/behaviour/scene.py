"""The scene: every road user once a tick, tracked by its id, in the coordinates of the route."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_map.crossings import Crossing
from sdc_map.network import Network
from sdc_package.behaviour.crosswalks import Crosswalk
from sdc_package.behaviour.offset_path import SAME_M, OffsetPath
from sdc_package.behaviour.road import SAME, RoadAlong
from sdc_package.obstacle_prediction import Obstacles
from sdc_package.street_settings import StreetSettings

# Kinds of road users.
AMBULANCE = "ambulance"
PEDESTRIAN = "pedestrian"
OBSTACLE = "obstacle"
# A road user that is slower stands [m/s].
AT_REST_MPS = 0.5
# Spacing of the places at which ways and speeds are given [m].
GRID_M = 1.0
# A route so much beside itself changes lanes [m].
_CHANGE_M = 1.0


@dataclass
class Track:
    """How a road user with an id has moved."""

    mean_mps: float
    acceleration_mps2: float = 0.0
    has_moved: bool = False
    slow_since_s: float = math.inf  # it holds the car up since then [s]
    rest_since_s: float = math.inf  # and is at rest since then [s]


_UNKNOWN = Track(0.0)


class Tracker:
    """Follows the road users by their ids; without an id, a road user has no history.

    Args:
        mean_s: age of the mean speed with which a speed is compared [s]
    """

    def __init__(self, mean_s: float):
        self._mean_s, self._time_s = mean_s, -math.inf
        self._tracks: dict[int, Track] = {}

    def update(self, obstacles: Obstacles, time_s: float) -> None:
        """Look at the road users; call it once in each plan."""
        keeps_s = self._mean_s**2 / (self._mean_s + max(time_s - self._time_s, 0.0))
        self._time_s, tracks = time_s, {}
        for user in obstacles:
            if not user.id:
                continue
            track = self._tracks.get(user.id) or Track(user.speed_mps)
            track.acceleration_mps2 = (user.speed_mps - track.mean_mps) / self._mean_s
            track.mean_mps = user.speed_mps - keeps_s * track.acceleration_mps2
            track.has_moved |= user.speed_mps > 2.0 * AT_REST_MPS
            tracks[user.id] = track
        self._tracks = tracks

    def of(self, user: DetectedObstacle) -> Track:
        """Return how a road user has moved."""
        return self._tracks.get(user.id, _UNKNOWN)


class Others(NamedTuple):
    """Road users near the route; arrays (A,), places as in RoadAlong."""

    rows: np.ndarray  # index of each in the observation
    s_m: np.ndarray  # arc length along the route [m]
    y_m: np.ndarray  # place across the road [m]
    beside_m: np.ndarray  # distance from the route, positive to the left [m]
    along_mps: np.ndarray  # speed along the route, negative: oncoming [m/s]
    half_length_m: np.ndarray  # half of the size along the route [m]
    half_width_m: np.ndarray  # half of the size across it [m]


class Stop(NamedTuple):
    """A place at which the centre of the car stops."""

    s_m: float
    reason: str


@dataclass
class StreetScene:
    """The road around the car at one time, with places across the road as in RoadAlong."""

    road: RoadAlong
    way: OffsetPath  # where the car drives
    settings: StreetSettings
    network: Network
    obstacles: Obstacles
    tracker: Tracker
    time_s: float
    s_m: float
    speed_mps: float
    lines_m: np.ndarray  # (M,) arc lengths at which junctions begin [m]
    crossings: Sequence[Crossing] = ()  # the one that the car is in, and the next ones
    crosswalks: Sequence[tuple[Crosswalk, DetectedObstacle]] = ()  # those that are in use
    stop: Stop | None = None  # a red light or a stop sign
    has_waited: bool = False  # the car stands at its line for so long that others let it go first

    def __post_init__(self) -> None:
        road, way, s_m = self.road, self.way, self.s_m
        seen, proposing = self.settings.prediction, self.settings.proposals
        self.from_m, self.here = s_m - seen.behind_m, int(seen.behind_m / GRID_M)
        self.sight_m = self.from_m, s_m + seen.ahead_m
        self.grid_m = np.arange(*self.sight_m, GRID_M)
        self.others = others = self._others()
        users = [self.obstacles[row] for row in others.rows.tolist()]
        self._kinds = [user.kind for user in users]
        tracks = [self.tracker.of(user) for user in users]
        self.route_y = np.interp(self.grid_m, road.s_m, road.route_y_m)
        self.most_mps = np.interp(self.grid_m, road.route.s, road.speed_mps)
        self.soon_m = proposing.soon_s * float(self.most_mps[self.here :].max())
        self.soon = slice(self.here, self.here + int(self.soon_m / GRID_M) + 1)
        self.top_mps = float(self.most_mps[self.soon].max())
        self.shifts_mps = max(self.speed_mps, proposing.share * self.top_mps)
        lines_m = self.lines_m
        self.end_m = float(min(lines_m[lines_m > s_m], default=road.route.length_m))
        self.at = road.at(s_m)
        self.width_m = float(road.width_m[self.at])
        self.inside_m = 0.5 * (self.width_m - self.settings.width_m)
        left = road.left[road.at(self.grid_m)]
        self.line_y = np.where(left == SAME, math.inf, self.route_y + self.inside_m + SAME_M)
        self.way_y = self.ways([way.offset_m])[0]
        # How far apart the centres of the car and each other are if they touch.
        self.body_m = body_m = others.half_width_m + 0.5 * self.settings.width_m
        apart_m = np.abs(others.y_m - np.interp(others.s_m, self.grid_m, self.way_y))
        self.blocks = apart_m < body_m
        body_m = body_m + proposing.beside_m
        self._on_route = np.abs(others.beside_m) < body_m
        ahead = (others.s_m > s_m) & (others.s_m < s_m + self.soon_m)
        usual_mps = np.interp(others.s_m, self.grid_m, self.most_mps)
        slow = ahead & (apart_m < body_m) & (others.along_mps < proposing.share * usual_mps)
        self._note_slow(tracks, slow)
        free = self._on_route & ahead & ~self._waiting()
        passable = [n for n in np.flatnonzero(free) if self._may_pass(n, tracks[n])]
        self.passable = sorted(passable, key=lambda n: others.s_m[n])
        comes = (others.s_m < s_m) & (others.along_mps > self.speed_mps)
        self.emergency = [n for n in np.flatnonzero(comes) if self._kinds[n] == AMBULANCE]

    def _others(self) -> Others:
        users, near_m = self.obstacles, self.settings.prediction.beside_m
        poses = [(user.x_m, user.y_m, user.yaw_rad, user.speed_mps) for user in users]
        x_m, y_m, yaw_rad, mps = np.array(poses).reshape(-1, 4).T
        along = self.road.along(self.sight_m, x_m, y_m, yaw_rad, users)
        from_m, to_m = self.sight_m
        near = (np.abs(along.beside_m) < near_m) & (along.s_m > from_m) & (along.s_m < to_m)
        found = along.s_m, along.y_m, along.beside_m, mps * along.cos
        sizes = along.half_length_m, along.half_width_m
        return Others(np.flatnonzero(near), *(part[near] for part in (*found, *sizes)))

    def _note_slow(self, tracks: Sequence[Track], slow: np.ndarray) -> None:
        """Note since when each holds the car up; while the car passes, no one is forgotten."""
        for number, track in enumerate(tracks):
            if track is _UNKNOWN:
                continue
            if slow[number]:
                track.slow_since_s = min(track.slow_since_s, self.time_s)
                at_rest = self.others.along_mps[number] < AT_REST_MPS
                rest_s = min(track.rest_since_s, self.time_s) if at_rest else math.inf
                track.rest_since_s = rest_s
            elif not self.way.until_m:
                track.slow_since_s = track.rest_since_s = math.inf

    def _may_pass(self, n: int, track: Track) -> bool:
        """Return whether a road user holds the car up for so long that it is passed."""
        along_mps, kind, times = self.others.along_mps[n], self._kinds[n], self.settings.proposals
        if kind == PEDESTRIAN or along_mps < -AT_REST_MPS:
            return False
        if kind == OBSTACLE:
            return True
        if along_mps < AT_REST_MPS:
            needed_s = times.stopped_s if track.has_moved else times.at_rest_s
            return self.time_s - track.rest_since_s >= needed_s
        return self.time_s - track.slow_since_s >= times.moves_s

    def _waiting(self) -> np.ndarray:
        """Return which road users wait in a queue before a junction."""
        others, queue_m = self.others, self.settings.proposals.wait_m
        waits, end_m = np.zeros(len(self._kinds), bool), math.inf
        front_m = others.s_m + others.half_length_m
        at_rest = self._on_route & (np.abs(others.along_mps) < AT_REST_MPS)
        for n in np.argsort(-others.s_m):
            if not at_rest[n] or self._kinds[n] == OBSTACLE:
                continue
            to_line_m = self.lines_m - front_m[n]
            is_near = ((to_line_m > -0.5 * queue_m) & (to_line_m < queue_m)).any()
            if is_near or end_m - front_m[n] < queue_m:
                waits[n], end_m = True, others.s_m[n] - others.half_length_m[n]
        return waits

    @property
    def changes_lane(self) -> bool:
        """Whether the route changes lanes soon."""
        return float(np.ptp(self.route_y[self.soon])) > _CHANGE_M

    @property
    def is_invaded(self) -> bool:
        """Whether an oncoming road user reaches into the lane of the car."""
        reach_m = np.abs(self.others.beside_m) - self.others.half_width_m
        its_s = self.others.s_m  # after the route, its lane is not known
        inside = (its_s > self.s_m) & (its_s < self.road.route.length_m)
        inside &= reach_m < 0.5 * self.width_m - SAME_M
        invades = inside & (self.others.along_mps < -AT_REST_MPS)
        return bool(invades.any()) and not self.road.in_junction[self.at]

    @property
    def is_on_oncoming_lane(self) -> bool:
        """Whether the car is on the oncoming lane."""
        return bool(self.way_y[self.here] > self.line_y[self.here])

    def ways(self, offsets_m: Sequence[np.ndarray]) -> np.ndarray:
        """Return (P, G) places across the road on the grid."""
        s = self.road.route.s
        return np.array([self.route_y + np.interp(self.grid_m, s, o) for o in offsets_m])

    def rear_m(self, n: int) -> float:
        """Return the arc length of the rear of a road user [m]."""
        return float(self.others.s_m[n] - self.others.half_length_m[n])

    def needed_m(self, n: int, side: float) -> float:
        """Return how far beside the route the car passes a road user on one side [m]."""
        reach_m = self.body_m[n] + self.settings.proposals.beside_m
        return float(max(side * self.others.beside_m[n] + reach_m, 0.0))
