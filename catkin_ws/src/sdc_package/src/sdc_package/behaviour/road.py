"""The road along a route: lanes beside that of the car, and road users in its coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Sequence

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.geometry.route import Route
from sdc_map.network import SOLID, LanePlace, Network, RoadLane, edge_of
from sdc_package.obstacle_prediction import Obstacles

# What is beside a lane: nothing, a lane of the same direction, an oncoming lane, and one behind a
# solid line.
NOTHING, SAME, ONCOMING, BEHIND_LINE = range(4)
# Who is less oblique to a lane drives along it.
ALONG_RAD = math.radians(30.0)
# Oncoming lanes are looked up so near to where they are expected [m].
_BESIDE_M = 1.5
# Points, 1 m apart, of the road after the end of the route, on which others come.
_BEYOND = 150
# Shorter road users are pedestrians [m].
VEHICLE_M = 1.2


class Along(NamedTuple):
    """Road users in the coordinates of a road; arrays (..., R)."""

    s_m: np.ndarray  # arc length along the route [m]
    y_m: np.ndarray  # place across the road, see RoadAlong [m]
    beside_m: np.ndarray  # distance from the route, positive to the left [m]
    cos: np.ndarray  # cosine of the angle to the route
    half_length_m: np.ndarray  # half of the size along the route [m]
    half_width_m: np.ndarray  # half of the size across it [m]


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
    z_m: np.ndarray  # height of the points of the route [m]
    s_m: np.ndarray  # arc length along the route [m]
    route_y_m: np.ndarray  # place of the route across the road [m]
    width_m: np.ndarray  # width of the lane [m]
    left: np.ndarray  # what is to the left of the lane
    right: np.ndarray  # what is to its right
    edge_end_m: np.ndarray  # where the lanes end, at a junction or before other ones [m]
    in_junction: np.ndarray  # whether the place is in a junction

    def along(
        self,
        ends_m: tuple[float, float],
        x_m: np.ndarray,
        y_m: np.ndarray,
        yaw_rad: np.ndarray,
        users: Obstacles,
    ) -> Along:
        """Return poses (..., R) of road users in the coordinates of this road.

        Args:
            ends_m: arc lengths between which they are near it [m]
            x_m: their positions [m]
            y_m: their positions [m]
            yaw_rad: their headings [rad]
            users: the R road users
        """
        first, last = np.searchsorted(self.line[:, 0], ends_m)
        rows = self.line[min(first, len(self.line) - 2) : max(last, first + 2)]
        _, nearest = cKDTree(rows[:, 1:3]).query(np.stack([x_m, y_m], axis=-1))
        line_s, line_x, line_y, heading = np.moveaxis(rows[nearest], -1, 0)
        c, s = np.cos(heading), np.sin(heading)
        dx, dy = x_m - line_x, y_m - line_y
        beside_m, s_m = c * dy - s * dx, line_s + c * dx + s * dy
        cos, sin = np.cos(yaw_rad - heading), np.sin(yaw_rad - heading)
        sizes = [(user.length_m, user.width_m) for user in users]
        length, width = np.array(sizes).reshape(-1, 2).T
        half_length = 0.5 * (length * np.abs(cos) + width * np.abs(sin))
        half_width = 0.5 * (length * np.abs(sin) + width * np.abs(cos))
        its_y = beside_m + np.interp(s_m, self.s_m, self.route_y_m)
        return Along(s_m, its_y, beside_m, cos, half_length, half_width)

    def at(self, s_m: Any) -> Any:
        """Return the index of the place at an arc length, or those at arc lengths."""
        return np.minimum(np.searchsorted(self.s_m, s_m), len(self.s_m) - 1)


def road_along(
    network: Network,
    route: Route,
    places: Sequence[tuple[float, LanePlace]],
    speed_mps: np.ndarray,
    z_m: np.ndarray,
) -> RoadAlong:
    """Return the road along a route.

    Args:
        network: the lanes
        route: the route
        places: arc lengths along the route, and the places on the lanes there, one at least
        speed_mps: (N,) planned speed at the points of the route [m/s]
        z_m: (N,) height of these points [m]
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
        rows.append((s_m, y_m, lane.width_m, left, right, bool(lane.junction)))
    s, y, width, left_of, right_of, junction = map(np.array, zip(*rows))
    end_m = np.full(len(s), s[-1])
    for (first, _), (after, at_m) in zip(ends_m, ends_m[1:]):
        end_m[first:after] = at_m
    own = np.column_stack([route.s, route.points, route.heading])
    line = np.vstack([own, _beyond(network, places[-1][1], route.length_m)])
    return RoadAlong(route, line, speed_mps, z_m, s, y, width, left_of, right_of, end_m, junction)


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


def _index(lane: str) -> int:
    """Return the number of a lane on its edge, counted from the right as SUMO does."""
    return int(lane.rpartition("_")[2])


def _oncoming(network: Network, route: Route, s_m: float, lane: RoadLane) -> int:
    """Return whether an oncoming lane is to the left of a lane."""
    pose = *route.line.point_at(s_m), route.line.heading_at(s_m)
    if lane.junction or network.oncoming_lane(lane, pose, _BESIDE_M, ALONG_RAD) is None:
        return NOTHING
    return BEHIND_LINE if SOLID in lane.left_marking else ONCOMING
