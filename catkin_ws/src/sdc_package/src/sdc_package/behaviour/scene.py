"""The scene: every road user once a tick, tracked by its id, in the coordinates of the route."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import NamedTuple, Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle, Observation
from sdc_map.crossings import Crossing
from sdc_package.behaviour.offset_path import SAME_M, OffsetPath
from sdc_package.behaviour.road import ALONG_RAD, SAME, Crosswalk, RoadAlong
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
    rests: bool | None = None  # whether it is at rest
    since_s: float = math.inf  # it holds the car up as it does now since then [s]


class Tracker:
    """Follows the road users by their ids; without an id, a road user has no history."""

    def __init__(self, seen: SimpleNamespace):
        self._seen, self._time_s = seen, -math.inf
        self._tracks: dict[int, Track] = {}

    def update(self, obstacles: Obstacles, time_s: float) -> None:
        """Look at the road users; call it once in each plan."""
        mean_s = self._seen.mean_s
        keeps_s = mean_s**2 / (mean_s + max(time_s - self._time_s, 0.0))
        self._time_s, tracks = time_s, {}
        for user in (user for user in obstacles if user.id):
            track = self._tracks.get(user.id) or Track(user.speed_mps)
            mps2 = (user.speed_mps - track.mean_mps) / mean_s
            track.mean_mps = user.speed_mps - keeps_s * mps2
            track.acceleration_mps2 = mps2 if abs(mps2) > self._seen.steady_mps2 else 0.0
            track.has_moved |= user.speed_mps > 2.0 * AT_REST_MPS
            tracks[user.id] = track
        self._tracks = tracks

    def of(self, user: DetectedObstacle) -> Track:
        """Return how a road user has moved."""
        return self._tracks.get(user.id) or Track(0.0)


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
    tracker: Tracker
    observation: Observation
    s_m: float
    horizon_m: float  # rules and junctions are looked for so far ahead
    crossings: Sequence[Crossing]  # the one that the car is in, and the next ones
    stop: Stop | None = None  # a red light or a stop sign
    has_waited: bool = False  # the car stands at its line for so long that others let it go first

    def __post_init__(self) -> None:
        road, s_m, self.speed_mps = self.road, self.s_m, self.observation.speed_mps
        self.obstacles = users = self.observation.obstacles
        self.until_m = min(s_m, self.stop.s_m if self.stop else math.inf) + self.horizon_m
        self.crossings = [crossing for crossing in self.crossings if crossing.line_m < self.until_m]
        seen, proposing = self.settings.prediction, self.settings.proposals
        self.from_m, self.here = s_m - seen.behind_m, int(seen.behind_m / GRID_M)
        self.sight_m = self.from_m, s_m + seen.ahead_m
        self.grid_m = np.arange(*self.sight_m, GRID_M)
        poses = [(user.x_m, user.y_m, user.yaw_rad, user.speed_mps, user.z_m) for user in users]
        motions = np.array(poses).reshape(-1, 5).T
        self.others = others = road.along(s_m, self.sight_m, motions, users)
        self.route_y = np.interp(self.grid_m, road.s_m, road.route_y_m)
        self.road_bend = np.interp(self.grid_m, road.route.s, road.route.curvature)
        self.most_mps = np.interp(self.grid_m, road.route.s, road.speed_mps)
        self.soon_m = proposing.soon_s * float(self.most_mps[self.here :].max())
        self.soon = slice(self.here, self.here + int(self.soon_m / GRID_M) + 1)
        self.top_mps = float(self.most_mps[self.soon].max())
        self.shifts_mps = max(self.speed_mps, proposing.share * self.top_mps)
        self.lines_m = lines_m = np.array([crossing.line_m for crossing in road.crossings])
        self.end_m, self.at = min(lines_m[lines_m > s_m], default=road.route.length_m), road.at(s_m)
        self.width_m = float(road.width_m[self.at])
        self.inside_m = 0.5 * (self.width_m - self.settings.width_m)
        self.left = road.left[road.at(self.grid_m)]
        self.line_y = np.where(self.left == SAME, math.inf, self.route_y + self.inside_m + SAME_M)
        self.way_y = self.ways([self.way.offset_m])[0]
        # How far apart the centres of the car and each other are if they touch.
        self.body_m = body_m = others.half_width_m + 0.5 * self.settings.width_m
        self.rear_m, self.apart_m = others.s_m - others.half_length_m, self.apart_from(self.way_y)
        body_m = body_m + proposing.beside_m
        ahead = (others.s_m > s_m) & (others.s_m < s_m + self.soon_m)
        away_m, half_m = np.abs(others.beside_m), 0.5 * self.width_m
        # Who is oncoming, or beside the lane and does not drive along it, reaches into the lane;
        # after the route, the lane is not known.
        most_mps = np.where(away_m > half_m, AT_REST_MPS, -AT_REST_MPS)
        invades = ahead & (others.along_mps < most_mps) & (others.s_m < road.route.length_m)
        self.is_invaded = bool((invades & (away_m - others.half_width_m < half_m - SAME_M)).any())
        self.changes_lane = bool(np.ptp(self.route_y[self.soon]) > _CHANGE_M)
        usual_mps = np.interp(others.s_m, self.grid_m, self.most_mps)
        slow = ahead & (self.apart_m < body_m) & (others.along_mps < proposing.share * usual_mps)
        passable = self._passable(away_m < body_m, slow)
        self.passable = [n for n in passable if ahead[n]]
        # Who drives on the way of the car already.
        self.is_ahead = ahead & (self.apart_m < self.inside_m)
        self.is_ahead &= others.along_mps >= math.cos(ALONG_RAD) * motions[3]

    def _passable(self, on_route: np.ndarray, slow: np.ndarray) -> list[int]:
        """Return who holds the car up for so long that it is passed, the nearest one first.

        While the car passes, no one is forgotten. Who waits before a junction is not passed.
        """
        others, times, time_s = self.others, self.settings.proposals, self.observation.stamp_s
        found: list[int] = []
        queue_m = math.inf  # rear of the last one that waits
        front_m = others.s_m + others.half_length_m
        to_lines_m = self.lines_m - front_m[:, None]
        at_line = ((to_lines_m > -0.5 * times.wait_m) & (to_lines_m < times.wait_m)).any(axis=1)
        for n in np.argsort(-others.s_m).tolist():
            user, along_mps = self.obstacles[n], others.along_mps[n]
            track, rests = self.tracker.of(user), bool(along_mps < AT_REST_MPS)
            if rests != track.rests or not (slow[n] or self.way.until_m):
                track.rests, track.since_s = rests, time_s
            if not on_route[n] or along_mps < -AT_REST_MPS:
                continue
            needed_s = times.moves_s
            if user.kind == OBSTACLE:
                needed_s = 0.0
            elif rests and (at_line[n] or queue_m - front_m[n] < times.wait_m):
                queue_m = self.rear_m[n]
                continue
            elif rests:
                needed_s = times.stopped_s if track.has_moved else times.at_rest_s
            if user.kind != PEDESTRIAN and time_s - track.since_s >= needed_s:
                found.append(n)
        return found[::-1]

    @cached_property
    def crosswalks(self) -> list[Crosswalk]:
        """The next ones that are in use."""
        walks, known = self.road.crosswalks, (self.road.route, self.obstacles)
        near = [walk for walk in walks if self.s_m < walk.end_m and walk.begin_m < self.until_m]
        return [walk for walk in near if walk.user(*known)]

    @cached_property
    def emergency(self) -> list[int]:
        """Ambulances that come from behind."""
        near_m = self.settings.prediction.beside_m + self.others.half_width_m
        comes = (self.others.s_m < self.s_m) & (self.others.along_mps > self.speed_mps)
        comes &= np.abs(self.others.beside_m) < near_m
        return [n for n in np.flatnonzero(comes) if self.obstacles[n].kind == AMBULANCE]

    def apart_from(self, way_y: np.ndarray) -> np.ndarray:
        """Return how far the centre of each other is from a way (G,) on the grid."""
        return np.abs(self.others.y_m - np.interp(self.others.s_m, self.grid_m, way_y))

    def ways(self, offsets_m: Sequence[np.ndarray]) -> np.ndarray:
        """Return (P, G) places across the road on the grid."""
        s = self.road.route.s
        return np.array([self.route_y + np.interp(self.grid_m, s, o) for o in offsets_m])
