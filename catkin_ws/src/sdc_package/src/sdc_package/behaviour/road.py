"""The road along a route: lanes beside that of the car, crosswalks, and others on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Sequence

import cv2
import numpy as np
from scipy.spatial import cKDTree

from sdc_common.driving import DetectedObstacle, other_level
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import Route
from sdc_map.crossings import Crossing, crossings, heights_along, places_along
from sdc_map.network import SOLID, Network, RoadLane, edge_of
from sdc_package.behaviour.offset_path import SAME_M
from sdc_package.obstacle_prediction import Obstacles

# What is beside a lane: nothing, a lane of the same direction, an oncoming lane, and one behind a
# solid line.
NOTHING, SAME, ONCOMING, BEHIND_LINE = range(4)
# Who is less oblique to a lane drives along it.
ALONG_RAD = math.radians(30.0)
# A pass of the same place counts as so much farther away for each metre along the route.
_PASS = 0.05
# Oncoming lanes are looked up so near to where they are expected [m].
_BESIDE_M = 1.5
# Length of the road after the end of the route, on which others come [m].
_BEYOND_M = 150
# Shorter road users are pedestrians [m].
VEHICLE_M = 1.2
# A pedestrian who is so near to a crosswalk now or after this time, and walks towards the lane,
# will use it [m], [s].
_NEAR_M = 2.0
_SOON_S = 1.0
# One who has left the strip of the car's lane by so much does not come back [m].
_STRIP_M = 2.2


class Along(NamedTuple):
    """Road users in the coordinates of a road; arrays (..., R)."""

    s_m: np.ndarray  # arc length along the route [m]
    y_m: np.ndarray  # place across the road, see RoadAlong [m]
    beside_m: np.ndarray  # distance from the route, positive to the left [m]
    along_mps: np.ndarray  # speed along the route, negative: oncoming [m/s]
    half_length_m: np.ndarray  # half of the size along the route [m]
    half_width_m: np.ndarray  # half of the size across it [m]


class Crosswalk(NamedTuple):
    """A crosswalk on a route."""

    begin_m: float  # arc lengths along the route at which it begins and ends [m]
    end_m: float
    polygon_m: np.ndarray  # (N, 2) corners, 32-bit floats [m]

    def user(self, route: Route, obstacles: Obstacles) -> DetectedObstacle | None:
        """Return a pedestrian on it, or just before it, who has yet to cross the lane."""
        middle_m, reach_m = 0.5 * (self.begin_m + self.end_m), self.end_m - self.begin_m
        for walker in (user for user in obstacles if user.kind == "pedestrian"):
            x, y, yaw = walker.x_m, walker.y_m, walker.yaw_rad
            soon_m = _SOON_S * walker.speed_mps
            places = (x, y), (x + soon_m * math.cos(yaw), y + soon_m * math.sin(yaw))
            inside_m, later_m = (cv2.pointPolygonTest(self.polygon_m, at, True) for at in places)
            lane = route.line.project(x, y, middle_m, reach_m, reach_m)
            left_mps = walker.speed_mps * math.sin(yaw - lane.heading_rad)
            comes = lane.cross_track_m * left_mps < 0.0 and max(inside_m, later_m) > -_NEAR_M
            if comes or (lane.distance_m < _STRIP_M and inside_m > 0.0):
                return walker
        return None


@dataclass(frozen=True)
class RoadAlong:
    """The road along a route, at places (N,) about 2 m apart.

    Places across the road are measured from the lane in which the route begins, positive to the
    left: a road user that keeps its lane keeps this number, where the route changes lanes, too.
    """

    route: Route
    # (M, 4) arc length, x, y and heading of the route and of the way straight on after it
    line: np.ndarray
    speed_mps: np.ndarray  # planned speed at the points of the route [m/s]
    z_m: np.ndarray  # height of the points of the route, NaN on a flat map [m]
    crossings: Sequence[Crossing]  # its ways through junctions
    crosswalks: Sequence[Crosswalk]
    s_m: np.ndarray  # arc length along the route [m]
    route_y_m: np.ndarray  # place of the route across the road [m]
    width_m: np.ndarray  # width of the lane [m]
    left: np.ndarray  # what is to the left of the lane
    right: np.ndarray  # what is to its right
    edge: np.ndarray  # number of the road: others follow, or a junction, where its lanes end

    def along(self, s_m: float, ends_m: Sequence[float], poses: Any, users: Obstacles) -> Along:
        """Return R road users in the coordinates of this road, on the pass near an arc length.

        `poses` (5, ..., R) are their x [m], y [m], headings [rad], speeds [m/s] and heights [m].
        One that is beyond the ends [m], or on another level, has a width of -inf: it is in no way.
        """
        x_m, y_m, yaw_rad, mps, z_m = poses
        first, last = np.searchsorted(self.line[:, 0], ends_m)
        rows = self.line[min(first, len(self.line) - 2) : max(last, first + 2)]
        places = np.column_stack([rows[:, 1:3], _PASS * (rows[:, 0] - s_m)])
        _, nearest = cKDTree(places).query(np.stack([x_m, y_m, 0.0 * x_m], axis=-1))
        line_s, line_x, line_y, heading = np.moveaxis(rows[nearest], -1, 0)
        c, s = np.cos(heading), np.sin(heading)
        dx, dy = x_m - line_x, y_m - line_y
        beside_m, its_s = c * dy - s * dx, line_s + c * dx + s * dy
        cos, sin = np.cos(yaw_rad - heading), np.sin(yaw_rad - heading)
        sizes = [(user.length_m, user.width_m) for user in users]
        length, width = np.array(sizes).reshape(-1, 2).T
        half_length = 0.5 * (length * np.abs(cos) + width * np.abs(sin))
        half_width = 0.5 * (length * np.abs(sin) + width * np.abs(cos))
        is_on_it = (its_s > ends_m[0]) & (its_s < ends_m[1])
        is_on_it &= ~other_level(z_m, np.interp(its_s, self.route.s, self.z_m), np.abs(beside_m))
        half_width = np.where(is_on_it, half_width, -math.inf)
        its_y = beside_m + np.interp(its_s, self.s_m, self.route_y_m)
        return Along(its_s, its_y, beside_m, mps * cos, half_length, half_width)

    def at(self, s_m: Any) -> Any:
        """Return the index of the place at an arc length, or those at arc lengths."""
        return np.minimum(np.searchsorted(self.s_m, s_m), len(self.s_m) - 1)


def road_along(network: Network, route: Route, speed_mps: np.ndarray) -> RoadAlong:
    """Return the road along a route, with the planned speed at its points (N,) [m/s].

    Raises:
        ValueError: the route is not on lanes
    """
    places = list(places_along(network, route))
    if not places:
        raise ValueError(f"the route is not on lanes of the map {network.name}")
    z_m = heights_along(network, route, places)
    if network.is_flat:  # one that measures another height is on its lane, too
        z_m = np.full_like(z_m, math.nan)
    rows: list[tuple] = []
    edge, jump_m, y_m, last = 0, 0.0, 0.0, ""
    for s_m, place in places:
        lane = network.lanes[place.lane]
        if edge_of(last) != edge_of(lane.id):
            edge += 1
        elif last != lane.id:
            step_m = 0.5 * (network.lanes[last].width_m + lane.width_m)
            jump_m += step_m if _index(lane.id) > _index(last) else -step_m
        last = lane.id
        left = SAME if lane.left else _oncoming(network, route, s_m, lane)
        right = SAME if lane.right else NOTHING
        if not lane.junction:  # in one, the nearest lane may be another way
            y_m = jump_m + place.cross_track_m
        rows.append((s_m, y_m, lane.width_m, left, right, edge))
    own = np.column_stack([route.s, route.points, route.heading])
    end = places[-1][1]
    beyond_m = np.arange(1.0, _BEYOND_M + 1.0)
    after = places_on(onward(network, end.lane, _BEYOND_M), end.s_m + beyond_m)
    line = np.vstack([own, np.column_stack([route.length_m + beyond_m, after[:, :3]])])
    found = crossings(network, route, places, speed_mps)
    walks = crosswalks_on(route, network.crosswalks)
    return RoadAlong(route, line, speed_mps, z_m, found, walks, *map(np.array, zip(*rows)))


def crosswalks_on(route: Route, polygons_m: Sequence[np.ndarray]) -> list[Crosswalk]:
    """Return the crosswalks that a route leads over, in order."""
    found = []
    for polygon in polygons_m:
        corners = np.asarray(polygon, np.float32)
        away_m = np.hypot(*(route.points - corners.mean(axis=0)).T)
        near = np.flatnonzero(away_m < np.ptp(corners, axis=0).max())
        points = [(n, route.points[n].tolist()) for n in near]
        on = [n for n, point in points if cv2.pointPolygonTest(corners, point, True) >= 0.0]
        # A route may pass it more than once.
        for run in np.split(on, np.flatnonzero(np.diff(on) > 1) + 1) if on else ():
            found.append(Crosswalk(float(route.s[run[0]]), float(route.s[run[-1]]), corners))
    return sorted(found, key=lambda crosswalk: crosswalk.begin_m)


def onward(network: Network, name: str, ahead_m: float) -> np.ndarray:
    """Return (M, 9) arc length, x, y, heading and height of a way that begins with a lane [m].

    Four columns more have the slopes after each row; after the last one it goes straight on.
    """
    lane: RoadLane | None = network.lanes[name]
    lines, length_m, from_m = [], -network.lanes[name].length_m, 0.0
    while lane is not None and length_m < ahead_m:
        lines.append(np.column_stack([lane.points_m, lane.z_m])[lane.s_m >= from_m])
        length_m, from_m = length_m + lane.length_m, SAME_M  # of a joint, the end before it counts
        lane = network.straight_on(lane)
    line = np.vstack(lines)
    line = line[np.append(True, np.diff(arc_lengths(line)) > 0.0)]
    s_m, steps = arc_lengths(line), np.diff(line, axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    heading = np.interp(s_m, 0.5 * (s_m[1:] + s_m[:-1]), heading)
    rows = np.column_stack([s_m, line[:, :2], heading, line[:, 2]])
    slopes = np.diff(rows[:, 1:], axis=0) / np.diff(rows[:, :1], axis=0)
    straight_on = math.cos(heading[-1]), math.sin(heading[-1]), 0.0, 0.0
    return np.hstack([rows, np.vstack([slopes, straight_on])])


def places_on(line: np.ndarray, at_m: np.ndarray) -> np.ndarray:
    """Return (N, 4) x, y, heading and height on a line of `onward` at arc lengths (N,) [m]."""
    rows = line[line[:, 0].searchsorted(at_m, "right") - 1]
    return rows[:, 1:5] + rows[:, 5:] * (at_m[:, None] - rows[:, :1])


def _index(lane: str) -> int:
    """Return the number of a lane on its edge, counted from the right as SUMO does."""
    return int(lane.rpartition("_")[2])


def _oncoming(network: Network, route: Route, s_m: float, lane: RoadLane) -> int:
    """Return whether an oncoming lane is to the left of a lane."""
    pose = *route.line.point_at(s_m), route.line.heading_at(s_m)
    if lane.junction or network.oncoming_lane(lane, pose, _BESIDE_M, ALONG_RAD) is None:
        return NOTHING
    return BEHIND_LINE if SOLID in lane.left_marking else ONCOMING
