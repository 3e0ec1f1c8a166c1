"""Rules about those on the lanes and about changes of lane, for `RoadUser`s of `street_rules`."""

from __future__ import annotations

import math
from typing import Any, Callable, Iterable, Sequence

import numpy as np

from sdc_map.network import DOUBLE, SOLID, LanePlace, Network, edge_of

CROSSWALK, DISTANCE, SOLID_LINE, CUT_IN = "crosswalk", "distance", "solid_line", "cut_in"
YIELD_EMERGENCY, ZIP_MERGE = "yield_emergency_vehicle", "zip_merge"
# Articles of the Vienna Convention on Road Traffic, 1968; the zip merge is in the German StVO.
ARTICLES = {CROSSWALK: "21.2", DISTANCE: "13.5", SOLID_LINE: "26.2", CUT_IN: "14.1"}
ARTICLES |= {YIELD_EMERGENCY: "34.1", ZIP_MERGE: "StVO 7 (4)"}
# Half of the strip of a crosswalk that the car uses, and how near one is who walks to it.
_STRIP_M, _NEAR_M, _WALKS_MPS = 1.75, 1.5, 0.3
# Half of the two seconds of the rule of thumb [s], the speed above which they count, and how long.
_HEADWAY_S, _FOLLOWS_MPS, _LASTS_S = 1.0, 5.0, 3.0
# One behind has less room than this after a change of lane, or must brake harder.
_ROOM_M, _BRAKES_MPS2, _MOVING_MPS = 2.0, 3.0, 1.0
# A change of lane is complete when the centre is so far behind the line; a lane has this width [m].
_OVER_M, _LANE_M = 0.1, 2.5
# An emergency vehicle is held up for so long, so near behind the car without such a way past it.
EMERGENCY_LASTS_S, _BEHIND_M, _FREE_M = 6.0, 30.0, 0.3
# The zip merge begins so near before the end of a lane; who is beside the car is so near [m].
_ZIP_M, _BESIDE_M = 30.0, 5.0


class LaneRules:
    """Watches a car on its lane."""

    def __init__(self, network: Network):
        self._network = network
        self._front_m: np.ndarray | None = None
        self._place: LanePlace | None = None  # of the centre, on the lane that it has not left
        self._follows, self._since_s = 0, math.inf  # the id of the one too close ahead, or 0
        self._to_end_m, self._ending = math.inf, set[int]()  # ids of those whose lane ends

    def update(
        self,
        time_s: float,
        car: Any,
        place: LanePlace | None,
        others: Sequence,
        passes_one_at_rest: Callable[[], bool],
    ) -> list[str]:
        """Return what counts now, for a car with its centre at this place."""
        x, y, yaw_rad, length_m, *_ = car.body
        c, s, reach_m = math.cos(yaw_rad), math.sin(yaw_rad), 20.0 + 2.0 * car.speed_mps
        near = []  # how far one is ahead, and to the left of the car [m], and the road user
        for one in others:
            dx, dy = one.body.x_m - x, one.body.y_m - y
            if -reach_m < dx < reach_m and -reach_m < dy < reach_m:
                near.append((c * dx + s * dy, c * dy - s * dx, one))
        front_m = np.array([x + 0.5 * length_m * c, y + 0.5 * length_m * s])
        found = [CROSSWALK] * self._enters_crosswalk(front_m, yaw_rad, near)
        self._front_m = front_m
        follows = self._too_close(car, self._network.lanes[place.lane], near) if place else 0
        if follows != self._follows:
            self._follows, self._since_s = follows, time_s
        if follows and time_s - self._since_s > _LASTS_S:
            self._since_s = math.inf  # until another one is ahead, or the gap is restored
            found.append(DISTANCE)
        found += [ZIP_MERGE] * bool(place and self._out_of_turn(car, place, near))
        return found + self._changes(car, place, near, passes_one_at_rest)

    def _enters_crosswalk(self, front_m: np.ndarray, yaw_rad: float, near: list[Any]) -> bool:
        walkers = []
        for _, left_m, one in near:
            if one.kind == "pedestrian" and abs(left_m) < _STRIP_M + _NEAR_M:
                to_left_mps = one.speed_mps * math.sin(one.body.yaw_rad - yaw_rad)
                if abs(left_m) < _STRIP_M or left_m * to_left_mps < -_WALKS_MPS * abs(left_m):
                    walkers.append(one.body[:2])
        for polygon in self._network.crosswalks if walkers else ():
            if _is_in(front_m, polygon) and not _is_in(self._front_m, polygon):
                return any(_is_in(one, polygon) for one in walkers)
        return False

    def _too_close(self, car: Any, lane: Any, near: list[Any]) -> int:
        """Return the id of the vehicle ahead on the lane, 0 if none is too close."""
        found, gap_m = 0, _HEADWAY_S * car.speed_mps
        for ahead_m, _, one in near if car.speed_mps > _FOLLOWS_MPS else ():
            least_m = ahead_m - 0.5 * (one.body.length_m + car.body.length_m)
            is_ahead = ahead_m > 0.0 and least_m < gap_m and one.speed_mps > _FOLLOWS_MPS
            if is_ahead and self._is_on(one, (lane.id, *lane.successors)):
                found, gap_m = one.id, least_m
        return found

    def _out_of_turn(self, car: Any, place: LanePlace, near: list[Any]) -> bool:
        """Return whether the car passes the end of a lane beside it before one whose turn it is."""
        lanes, lane = self._network.lanes, self._network.lanes[place.lane]
        ends = [one for one in (lane.left, lane.right) if one and not lanes[one].successors]
        if not ends:
            return False
        last_m, self._to_end_m = self._to_end_m, lane.length_m - place.s_m - 0.5 * car.body.length_m
        if self._to_end_m > _ZIP_M:
            self._ending.clear()
            return False
        waits = {one.id for m, _, one in near if m > -_BESIDE_M and self._is_on(one, ends)}
        self._ending |= waits
        if not waits or not self._to_end_m < 0.0 <= last_m:
            return False
        ahead = [(m, one.id) for m, y, one in near if 0 < m < _ZIP_M and 2 * abs(y) < lane.width_m]
        return bool(ahead) and min(ahead)[1] not in self._ending

    def _changes(self, car: Any, place: Any, near: list[Any], passes: Callable) -> list[str]:
        """Return what is wrong with a change of lane that is complete now."""
        last, self._place = self._place, place
        if last is None or place is None or last.lane == place.lane:
            return []
        lane, to = self._network.lanes[last.lane], self._network.lanes[place.lane]
        at = lane.line.project(car.body.x_m, car.body.y_m, last.s_m, _LANE_M, _LANE_M)
        is_beside = 0.5 < at.s_m < lane.length_m - 0.5 and not (lane.junction or to.junction)
        over_m = abs(at.cross_track_m) - 0.5 * lane.width_m if is_beside else math.inf
        if over_m < _OVER_M:
            self._place = LanePlace(lane.id, at.s_m, at.cross_track_m, 0.0)
        if not _OVER_M <= over_m < _LANE_M:
            return []
        marking = lane.left_marking if at.cross_track_m > 0.0 else lane.right_marking
        found = [SOLID_LINE] * (marking in (SOLID, DOUBLE) and not passes())
        if edge_of(lane.id) == edge_of(to.id):
            cut_off = [one for ahead_m, _, one in near if _is_cut_off(car, ahead_m, one)]
            found += [CUT_IN] * any(self._is_on(one, (to.id, *to.predecessors)) for one in cut_off)
        return found

    def _is_on(self, one: Any, lanes: Sequence[str]) -> bool:
        body = one.body
        at = self._network.nearest(body.x_m, body.y_m, body.yaw_rad, _LANE_M, body.z_m)
        return at is not None and at.lane in lanes


def holds_up(car: Any, others: Iterable[Any]) -> bool:
    """Return whether the car is on the way of an ambulance close behind; they are RoadUsers."""
    for body in (one.body for one in others if one.kind == "ambulance"):
        x, y = car.body.x_m - body.x_m, car.body.y_m - body.y_m
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        width_m = 0.5 * (car.body.width_m + body.width_m) + _FREE_M
        if 0.0 < c * x + s * y < _BEHIND_M and abs(c * y - s * x) < width_m:
            return True
    return False


def _is_cut_off(car: Any, ahead_m: float, one: Any) -> bool:
    gap_m = -ahead_m - 0.5 * (one.body.length_m + car.body.length_m)
    closing_mps = max(one.speed_mps - car.speed_mps, 0.0)
    hinders = gap_m < _ROOM_M or closing_mps**2 > 2.0 * _BRAKES_MPS2 * gap_m
    return ahead_m < 0.0 and one.speed_mps > _MOVING_MPS and hinders


def _is_in(point_m: Sequence[float] | None, polygon_m: np.ndarray) -> bool:
    """Return whether a point is in a convex polygon."""
    if point_m is None or np.abs(polygon_m[0] - point_m).max() > 50.0:
        return False
    edges, to = (np.roll(polygon_m, -1, axis=0) - polygon_m).T, (point_m - polygon_m).T
    sides = edges[0] * to[1] - edges[1] * to[0]
    return bool(sides.min() >= 0.0 or sides.max() <= 0.0)
