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
_STRIP_M = 1.75  # half width of the strip of a crosswalk that the car uses
_NEAR_M = 1.5  # a pedestrian that walks towards the strip counts within this distance of it
_WALKS_MPS = 0.3  # speed towards the strip, for each metre to its middle, that counts as walking
_HEADWAY_S = 1.0  # half of the two seconds of the rule of thumb
_FOLLOWS_MPS = 5.0  # the headway counts above this speed
_LASTS_S = 3.0  # a headway that is too short counts after this time
_ROOM_M = 2.0  # least gap to a vehicle behind after a change of lane
_BRAKES_MPS2 = 3.0  # hardest braking of that vehicle that does not count as cutting in
_MOVING_MPS = 1.0
_OVER_M = 0.1  # a change of lane is complete with the centre this far behind the line
_LANE_M = 2.5  # width of a lane, and distance within which lanes are searched
EMERGENCY_LASTS_S = 6.0  # holding up an emergency vehicle counts after this time
_BEHIND_M = 30.0  # an emergency vehicle is held up within this distance behind the car
_FREE_M = 0.3  # least free space beside the car with which it can pass
_ZIP_M = 30.0  # the zip merge begins at this distance to the end of a lane
_BESIDE_M = 5.0  # a vehicle up to this distance behind the car is beside it


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
        near = []  # distance ahead of the car and to its left [m], and the road user
        for user in others:
            dx, dy = user.body.x_m - x, user.body.y_m - y
            if -reach_m < dx < reach_m and -reach_m < dy < reach_m:
                near.append((c * dx + s * dy, c * dy - s * dx, user))
        front_m = np.array([x + 0.5 * length_m * c, y + 0.5 * length_m * s])
        found: list[str] = []
        if self._enters_crosswalk(front_m, yaw_rad, near):
            found.append(CROSSWALK)
        self._front_m = front_m
        follows = self._too_close(car, self._network.lanes[place.lane], near) if place else 0
        if follows != self._follows:
            self._follows, self._since_s = follows, time_s
        if follows and time_s - self._since_s > _LASTS_S:
            self._since_s = math.inf  # until another one is ahead, or the gap is restored
            found.append(DISTANCE)
        if place and self._out_of_turn(car, place, near):
            found.append(ZIP_MERGE)
        return found + self._changes(car, place, near, passes_one_at_rest)

    def _enters_crosswalk(self, front_m: np.ndarray, yaw_rad: float, near: list[Any]) -> bool:
        walkers = []
        for _, left_m, user in near:
            if user.kind == "pedestrian" and abs(left_m) < _STRIP_M + _NEAR_M:
                to_left_mps = user.speed_mps * math.sin(user.body.yaw_rad - yaw_rad)
                if abs(left_m) < _STRIP_M or left_m * to_left_mps < -_WALKS_MPS * abs(left_m):
                    walkers.append(user.body[:2])
        for polygon in self._network.crosswalks if walkers else ():
            if _is_in(front_m, polygon) and not _is_in(self._front_m, polygon):
                return any(_is_in(walker, polygon) for walker in walkers)
        return False

    def _too_close(self, car: Any, lane: Any, near: list[Any]) -> int:
        """Return the id of the vehicle ahead on the lane, 0 if none is too close."""
        found, gap_m = 0, _HEADWAY_S * car.speed_mps
        for ahead_m, _, user in near if car.speed_mps > _FOLLOWS_MPS else ():
            least_m = ahead_m - 0.5 * (user.body.length_m + car.body.length_m)
            is_ahead = ahead_m > 0.0 and least_m < gap_m and user.speed_mps > _FOLLOWS_MPS
            if is_ahead and self._is_on(user, (lane.id, *lane.successors)):
                found, gap_m = user.id, least_m
        return found

    def _out_of_turn(self, car: Any, place: LanePlace, near: list[Any]) -> bool:
        """Return whether the car passes the end of a lane beside it before one whose turn it is."""
        lanes, lane = self._network.lanes, self._network.lanes[place.lane]
        ends = [name for name in (lane.left, lane.right) if name and not lanes[name].successors]
        if not ends:
            return False
        last_m, self._to_end_m = self._to_end_m, lane.length_m - place.s_m - 0.5 * car.body.length_m
        if self._to_end_m > _ZIP_M:
            self._ending.clear()
            return False
        waits = {user.id for m, _, user in near if m > -_BESIDE_M and self._is_on(user, ends)}
        self._ending |= waits
        if not waits or not self._to_end_m < 0.0 <= last_m:
            return False
        half_m = 0.5 * lane.width_m
        ahead = [(m, user.id) for m, y, user in near if 0 < m < _ZIP_M and abs(y) < half_m]
        return bool(ahead) and min(ahead)[1] not in self._ending

    def _changes(self, car: Any, place: Any, near: list[Any], passes: Callable) -> list[str]:
        """Return what is wrong with a change of lane that is complete now."""
        last, self._place = self._place, place
        if last is None or place is None or last.lane == place.lane:
            return []
        lane, to = self._network.lanes[last.lane], self._network.lanes[place.lane]
        old_place = lane.line.project(car.body.x_m, car.body.y_m, last.s_m, _LANE_M, _LANE_M)
        is_beside = 0.5 < old_place.s_m < lane.length_m - 0.5 and not (lane.junction or to.junction)
        over_m = abs(old_place.cross_track_m) - 0.5 * lane.width_m if is_beside else math.inf
        if over_m < _OVER_M:
            self._place = LanePlace(lane.id, old_place.s_m, old_place.cross_track_m, 0.0)
        if not _OVER_M <= over_m < _LANE_M:
            return []
        marking = lane.left_marking if old_place.cross_track_m > 0.0 else lane.right_marking
        found = []
        if marking in (SOLID, DOUBLE) and not passes():
            found.append(SOLID_LINE)
        if edge_of(lane.id) == edge_of(to.id):
            cut_off = [user for ahead_m, _, user in near if _is_cut_off(car, ahead_m, user)]
            if any(self._is_on(user, (to.id, *to.predecessors)) for user in cut_off):
                found.append(CUT_IN)
        return found

    def _is_on(self, user: Any, lanes: Sequence[str]) -> bool:
        body = user.body
        place = self._network.nearest(body.x_m, body.y_m, body.yaw_rad, _LANE_M, body.z_m)
        return place is not None and place.lane in lanes


def holds_up(car: Any, others: Iterable[Any]) -> bool:
    """Return whether the car is on the way of an ambulance close behind; they are RoadUsers."""
    for body in (user.body for user in others if user.kind == "ambulance"):
        x, y = car.body.x_m - body.x_m, car.body.y_m - body.y_m
        c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
        width_m = 0.5 * (car.body.width_m + body.width_m) + _FREE_M
        if 0.0 < c * x + s * y < _BEHIND_M and abs(c * y - s * x) < width_m:
            return True
    return False


def _is_cut_off(car: Any, ahead_m: float, user: Any) -> bool:
    gap_m = -ahead_m - 0.5 * (user.body.length_m + car.body.length_m)
    closing_mps = max(user.speed_mps - car.speed_mps, 0.0)
    hinders = gap_m < _ROOM_M or closing_mps**2 > 2.0 * _BRAKES_MPS2 * gap_m
    return ahead_m < 0.0 and user.speed_mps > _MOVING_MPS and hinders


def _is_in(point_m: Sequence[float] | None, polygon_m: np.ndarray) -> bool:
    """Return whether a point is in a convex polygon."""
    if point_m is None or np.abs(polygon_m[0] - point_m).max() > 50.0:
        return False
    edges, to = (np.roll(polygon_m, -1, axis=0) - polygon_m).T, (point_m - polygon_m).T
    sides = edges[0] * to[1] - edges[1] * to[0]
    return bool(sides.min() >= 0.0 or sides.max() <= 0.0)
