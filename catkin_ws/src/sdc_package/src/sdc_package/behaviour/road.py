"""The road along a route: lanes beside that of the car, and road users in its coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Sequence

import numpy as np

from sdc_common.geometry.route import Route
from sdc_map.network import SOLID, LanePlace, Network, RoadLane, edge_of
from sdc_package.obstacle_prediction import Obstacles

# What is beside a lane: nothing, a lane of the same direction, an oncoming lane, and one behind a
# solid line.
NOTHING, SAME, ONCOMING, BEHIND_LINE = range(4)
# Oncoming lanes are looked up so near to where they are expected [m].
_BESIDE_M, _OPPOSITE_RAD = 1.5, math.radians(30.0)
# Points, 1 m apart, of the road after the end of the route, on which others come.
_BEYOND = 150
# The slope of the route across the road is taken between places so far before and after [m].
_SLOPE_M = 5.0
# Shorter road users are pedestrians [m]; a vehicle that comes so fast at least is on a lane [m/s].
VEHICLE_M, _COMES_MPS = 1.2, 0.5


class Around(NamedTuple):
    """Road users near the car, in the order of `rows`; arrays (A,)."""

    rows: np.ndarray  # index of each in the observation
    s_m: np.ndarray  # arc length along the route [m]
    y_m: np.ndarray  # place across the road, see RoadAlong [m]
    along_mps: np.ndarray  # speed along the route, negative: oncoming [m/s]
    left_mps: np.ndarray  # speed across the road [m/s]
    half_length_m: np.ndarray  # half of the size along the route [m]
    half_width_m: np.ndarray  # half of the size across it [m]
    faster_mps2: np.ndarray | float = 0.0  # acceleration along the route [m/s^2]


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
    s_m: np.ndarray  # arc length along the route [m]
    route_y_m: np.ndarray  # place of the route across the road [m]
    width_m: np.ndarray  # width of the lane [m]
    left: np.ndarray  # what is to the left of the lane
    right: np.ndarray  # what is to its right
    oncoming_y_m: np.ndarray  # place across the road of the first oncoming lane, if any [m]
    edge_end_m: np.ndarray  # where the lanes end, at a junction or before other ones [m]
    in_junction: np.ndarray  # whether the place is in a junction

    def at(self, s_m: Any) -> Any:
        """Return the index of the place at an arc length, or those at arc lengths."""
        return np.minimum(np.searchsorted(self.s_m, s_m), len(self.s_m) - 1)


def road_along(
    network: Network, route: Route, places: Sequence[tuple[float, LanePlace]], speed_mps: np.ndarray
) -> RoadAlong:
    """Return the road along a route.

    Args:
        network: the lanes
        route: the route
        places: arc lengths along the route, and the places on the lanes there, one at least
        speed_mps: (N,) planned speed at the points of the route [m/s]
    """
    rows: list[tuple] = []
    ends_m: list[tuple[int, float]] = []
    jump_m, y_m, last = 0.0, 0.0, ""
    for s_m, place in places:
        lane = network.lanes[place.lane]
        if last and edge_of(last) == edge_of(lane.id) and last != lane.id:
            step_m = 0.5 * (network.lanes[last].width_m + lane.width_m)
            jump_m += step_m if _index(lane.id) > _index(last) else -step_m
        if not last or edge_of(last) != edge_of(lane.id):
            ends_m.append((len(rows), s_m))
        last = lane.id
        left = SAME if lane.left else _oncoming(network, route, s_m, lane)
        right = SAME if lane.right else NOTHING
        if not lane.junction:  # in one, the nearest lane may be another way
            y_m = jump_m + place.cross_track_m
        oncoming_y_m = jump_m + lane.width_m + _left_m(network, lane)
        rows.append((s_m, y_m, lane.width_m, left, right, oncoming_y_m, bool(lane.junction)))
    s, y, width, left_of, right_of, oncoming, junction = map(np.array, zip(*rows))
    end_m = np.full(len(s), s[-1])
    for (first, _), (after, at_m) in zip(ends_m, ends_m[1:]):
        end_m[first:after] = at_m
    own = np.column_stack([route.s, route.points, route.heading])
    line = np.vstack([own, _beyond(network, places[-1][1], route.length_m)])
    sides = left_of, right_of, oncoming
    return RoadAlong(route, line, speed_mps, s, y, width, *sides, end_m, junction)


def _beyond(network: Network, place: LanePlace, end_m: float) -> np.ndarray:
    """Return the rows of RoadAlong.line after the last place on the route."""
    lane: RoadLane | None = network.lanes[place.lane]
    s_m = place.s_m + 1.0
    rows: list[tuple[float, ...]] = []
    while lane is not None and len(rows) < _BEYOND:
        for at_m in np.arange(s_m, lane.length_m, 1.0).tolist():
            place_m = *lane.line.point_at(at_m), lane.heading_at(at_m)
            rows.append((end_m + 1.0 + len(rows), *place_m))
        s_m, lane = 0.5, network.straight_on(lane)
    return np.array(rows[:_BEYOND]).reshape(-1, 4)


def _left_m(network: Network, lane: RoadLane) -> float:
    """Return the width of the lanes of the same direction to the left of a lane [m]."""
    width_m = 0.0
    while lane.left:
        lane = network.lanes[lane.left]
        width_m += lane.width_m
    return width_m


def _index(lane: str) -> int:
    """Return the number of a lane on its edge, counted from the right as SUMO does."""
    return int(lane.rpartition("_")[2])


def _oncoming(network: Network, route: Route, s_m: float, lane: RoadLane) -> int:
    """Return whether an oncoming lane is to the left of a lane."""
    pose = *route.line.point_at(s_m), route.line.heading_at(s_m)
    if lane.junction or network.oncoming_lane(lane, pose, _BESIDE_M, _OPPOSITE_RAD) is None:
        return NOTHING
    return BEHIND_LINE if SOLID in lane.left_marking else ONCOMING


def around(
    road: RoadAlong,
    s_m: float,
    obstacles: Obstacles,
    back_m: float,
    ahead_m: float,
    beside_m: float,
) -> Around:
    """Return the road users near a stretch of the route.

    Args:
        road: the road along the route
        s_m: arc length of the car's centre [m]
        obstacles: the detected road users
        back_m: length of the stretch behind the car [m]
        ahead_m: length of the stretch ahead of it [m]
        beside_m: greatest distance from the route [m]
    """
    first, last = np.searchsorted(road.line[:, 0], (s_m - back_m, s_m + ahead_m))
    first, last = min(int(first), len(road.line) - 2), max(int(last), int(first) + 2)
    line_s, line, line_yaw = np.split(road.line[first:last], [1, 3], axis=1)
    table = np.array(
        [(o.x_m, o.y_m, o.yaw_rad, o.speed_mps, o.length_m, o.width_m) for o in obstacles]
    ).reshape(-1, 6)
    middle = 0.5 * (line.min(axis=0) + line.max(axis=0))
    # Before the route begins, the road is taken as straight.
    reach = 0.5 * np.ptp(line, axis=0) + beside_m + max(back_m - s_m, 0.0)
    rows = np.flatnonzero((np.abs(table[:, :2] - middle) < reach).all(axis=1))
    x, y, yaw, speed, length, width = table[rows].T
    at = np.argmin((x[:, None] - line[:, 0]) ** 2 + (y[:, None] - line[:, 1]) ** 2, axis=1)
    heading = line_yaw[at, 0]
    c, s = np.cos(heading), np.sin(heading)
    dx, dy = x - line[at, 0], y - line[at, 1]
    along, left = c * dx + s * dy, c * dy - s * dx
    its_s = line_s[at, 0] + along
    turned = yaw - heading
    cos, sin = np.cos(turned), np.sin(turned)
    near = (np.abs(left) < beside_m) & (its_s > s_m - back_m) & (its_s < s_m + ahead_m)
    half = 0.5 * (length * np.abs(cos) + width * np.abs(sin))
    across = 0.5 * (length * np.abs(sin) + width * np.abs(cos))
    before_y, route_y, after_y = (
        np.interp(its_s + one, road.s_m, road.route_y_m) for one in (-_SLOPE_M, 0.0, _SLOPE_M)
    )
    its_y = left + route_y
    # Where the route changes lanes, it is oblique to the road.
    to_left = speed * (sin + cos * (after_y - before_y) / (2.0 * _SLOPE_M))
    # Where oncoming ones have more lanes than here, they may come on the first one.
    first_y = road.oncoming_y_m[road.at(s_m)]
    beyond = (length > VEHICLE_M) & (speed * cos < -_COMES_MPS) & (its_y > first_y)
    its_y, to_left = np.where(beyond, first_y, its_y), np.where(beyond, 0.0, to_left)
    every = rows, its_s, its_y, speed * cos, to_left, half, across
    return Around(*(one[near] for one in every))
