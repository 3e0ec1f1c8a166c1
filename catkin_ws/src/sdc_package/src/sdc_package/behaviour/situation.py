"""What a decision knows: who is in the way, who waits, who comes, and what a way costs."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from sdc_package.behaviour.forecast import GRID_M, Body
from sdc_package.behaviour.offset_path import SAME_M, OffsetPath
from sdc_package.behaviour.road import BEHIND_LINE, SAME, RoadAlong, around
from sdc_package.obstacle_prediction import Obstacles

AMBULANCE, PEDESTRIAN, OBSTACLE, BICYCLE = "ambulance", "pedestrian", "obstacle", "bicycle"
AT_REST_MPS = 0.5
# The stretch of the route that is looked at, and where fast ones come from behind [m].
_BACK_M, _AHEAD_M, _SIDE_M, _FAST_M = 70.0, 300.0, 8.0, 150.0
# A road user in the way ahead of the car that is nearer may be passed [m].
_LOOK_M = 70.0
# Length of the route ahead of the car in which changes of lanes are looked for [m].
_CHANGE_AHEAD_M = 60.0
# Both distances are at least what the car drives in this time [s].
_AHEAD_S = 5.0
# It is slow below this share of the speed without it. So many decisions count before the car
# passes an object, one at rest, one that moves, and one that it has seen moving and may drive on.
_SLOW, _OBJECT, _AT_REST, _MOVES, _STOPPED = 0.6, 1, 4, 12, 32
# One at rest or slow so near before a junction, or behind another one that waits, waits, too [m].
_QUEUE_M, _QUEUE_MPS, _BEHIND_M = (8.0, 30.0), 3.0, 9.0
_SIDE_FREE_M = 0.3
# A route so much beside itself changes lanes [m].
_CHANGE_M = 1.0
# Behind one that is overtaken, the gap stays open if no one is so near behind the car [m].
_FREE_BEHIND_M = 18.0
# Share of the planned speed at which the car shifts to the side and back.
_SHIFTS = 0.65
# Time between decisions [s], and the accelerations that count, at least and at most [m/s^2].
DECISION_S, _STEADY_MPS2, _FASTER_MPS2 = 0.25, 0.5, 2.5
# Costs in metres of progress: a solid line, and an emergency vehicle behind.
_SOLID_M, _HINDERS_M = 6.0, 40.0


class Memory:
    """What the car remembers of the road users by their ids."""

    def __init__(self):
        # Decisions for which they were slow, or at rest, before the car.
        self.slow: dict[tuple[int, bool], int] = {}
        self.moved: set[int] = set()  # those that have moved
        self._mps: dict[int, float] = {}  # their speeds along the route

    def update(self, slow: Sequence[tuple[int, bool]], moving: Sequence[int], keep: bool) -> None:
        """Count those that are slow, or at rest; forget the others unless they are kept."""
        self.moved.update(moving)
        old = self.slow if keep else {one: self.slow.get(one, 0) for one in slow}
        self.slow = {**old, **{one: self.slow.get(one, 0) + 1 for one in slow}}

    def faster_mps2(self, ids: Sequence[int], speeds_mps: Sequence[float]) -> np.ndarray:
        """Return by how much each accelerates since the last decision, 0 for those that brake."""
        gains = [mps - self._mps.get(one, mps) for one, mps in zip(ids, speeds_mps)]
        self._mps = dict(zip(ids, speeds_mps))
        faster_mps2 = np.array(gains) / DECISION_S
        steady = (faster_mps2 < _STEADY_MPS2) | (np.array(speeds_mps) < AT_REST_MPS)
        return np.where(steady, 0.0, np.minimum(faster_mps2, _FASTER_MPS2))


class Situation:
    """The road around the car at one time, with places across the road as in RoadAlong.

    Attributes:
        others: the road users
        grid_m: (G,) arc lengths of the grid [m]
        here: index of the car on it
        route_y: (G,) place of the route across the road [m]
        line_y: (G,) place beyond which the car is on the oncoming lane, inf: there is none [m]
        most_mps: (G,) planned speed [m/s]
        top_mps: greatest planned speed ahead [m/s]
        shifts_mps: speed with which the car is expected to shift to the side
        end_m: where the next junction, or the end of the route, is [m]
        beside_m: how far each road user is to the left of the route [m]
        passable: those that the car may pass, in order along the route
        emergency: those to which the car must give way
        blocks: (A,) whether each is in the way of the car
    """

    def __init__(
        self,
        road: RoadAlong,
        way: OffsetPath,
        car: Body,
        memory: Memory,
        lines_m: np.ndarray,
        s_m: float,
        speed_mps: float,
        obstacles: Obstacles,
    ):
        self._road, self._way, self._car, self.s_m, self.speed_mps = road, way, car, s_m, speed_mps
        route = road.route
        others = around(road, s_m, obstacles, _FAST_M, _AHEAD_M, _SIDE_M)
        self._kinds = [obstacles[row].kind for row in others.rows.tolist()]
        ids = np.array([obstacles[row].id for row in others.rows.tolist()], int)
        faster_mps2 = memory.faster_mps2(ids.tolist(), others.along_mps.tolist())
        self.others = others = others._replace(faster_mps2=faster_mps2)
        self.from_m, self.here = s_m - _BACK_M, int(_BACK_M / GRID_M)
        self.grid_m = self.from_m + GRID_M * np.arange(int((_BACK_M + _AHEAD_M + 80.0) / GRID_M))
        self.route_y = np.interp(self.grid_m, road.s_m, road.route_y_m)
        self.most_mps = np.interp(self.grid_m, route.s, road.speed_mps)
        self.top_mps = float(self.most_mps[self.here : self.here + 60].max())
        self.shifts_mps = max(speed_mps, _SHIFTS * self.top_mps)
        self.end_m = float(min(lines_m[lines_m > s_m], default=route.length_m))
        self.at = road.at(s_m)
        self.width_m = float(road.width_m[self.at])
        self.inside_m = 0.5 * (self.width_m - car.width_m)
        left = road.left[road.at(self.grid_m)]
        self.line_y = np.where(left == SAME, math.inf, self.route_y + self.inside_m + SAME_M)
        self.way_y = self.ways([way.offset_m])[0]
        self.beside_m = others.y_m - np.interp(others.s_m, self.grid_m, self.route_y)
        self._touches_m = others.half_width_m + 0.5 * car.width_m + _SIDE_FREE_M
        ahead = (others.s_m > s_m) & (others.s_m < s_m + max(_LOOK_M, _AHEAD_S * self.top_mps))
        apart_m = np.abs(others.y_m - np.interp(others.s_m, self.grid_m, self.way_y))
        self.blocks = apart_m < self._touches_m - _SIDE_FREE_M
        usual_mps = np.interp(others.s_m, self.grid_m, self.most_mps)
        slow = (apart_m < self._touches_m) & ahead & (others.along_mps < _SLOW * usual_mps)
        moving = ids[others.along_mps > 2.0 * AT_REST_MPS]
        at_rest = others.along_mps < AT_REST_MPS
        held_up = list(zip(ids[slow].tolist(), at_rest[slow].tolist()))
        memory.update(held_up, moving.tolist(), way.until_m > 0.0)
        self._on_route = np.abs(self.beside_m) < self._touches_m
        free = self._on_route & ahead & ~self._waiting(lines_m)
        passable = [n for n in np.flatnonzero(free) if self._may_pass(n, int(ids[n]), memory)]
        self.passable = sorted(passable, key=lambda n: others.s_m[n])
        comes = (others.s_m < s_m) & (others.along_mps > speed_mps - 1.0)
        self.emergency = [n for n in np.flatnonzero(comes) if self._kinds[n] == AMBULANCE]

    def _may_pass(self, n: int, number: int, memory: Memory) -> bool:
        along_mps, kind = self.others.along_mps[n], self._kinds[n]
        if kind == PEDESTRIAN or along_mps < -AT_REST_MPS:
            return False
        at_rest = bool(along_mps < AT_REST_MPS)
        needed = _STOPPED if number in memory.moved else _AT_REST
        needed = _OBJECT if kind == OBSTACLE else needed if at_rest else _MOVES
        return memory.slow.get((number, at_rest), 0) >= needed

    def _waiting(self, lines_m: np.ndarray) -> np.ndarray:
        """Return which road users wait in a queue before a junction."""
        others = self.others
        waits, end_m = np.zeros(len(self._kinds), bool), math.inf
        front_m = others.s_m + others.half_length_m
        for n in np.argsort(-others.s_m):
            along_mps = others.along_mps[n]
            if not self._on_route[n] or self._kinds[n] == OBSTACLE or along_mps < -AT_REST_MPS:
                continue
            to_line_m = lines_m - front_m[n]
            near_m = min(to_line_m[to_line_m > -2.0], default=math.inf)
            is_near = near_m < _QUEUE_M[int(along_mps > AT_REST_MPS)]
            rides = self._kinds[n] == BICYCLE and along_mps > AT_REST_MPS  # as slow elsewhere
            if not rides and along_mps < _QUEUE_MPS and (is_near or end_m - front_m[n] < _BEHIND_M):
                waits[n], end_m = True, others.s_m[n] - others.half_length_m[n]
        return waits

    @property
    def is_quiet(self) -> bool:
        """Return whether nothing asks for another way."""
        asks = self._way.until_m or self.passable or self.emergency or self.changes_lane
        return not (asks or self.is_invaded)

    @property
    def changes_lane(self) -> bool:
        """Whether the route changes lanes soon."""
        until = self.here + int(max(_CHANGE_AHEAD_M, _AHEAD_S * self.top_mps) / GRID_M)
        return float(np.ptp(self.route_y[self.here : until])) > _CHANGE_M

    @property
    def is_invaded(self) -> bool:
        """Whether an oncoming one reaches into the lane of the car."""
        reach_m = np.abs(self.beside_m) - self.others.half_width_m
        its_s = self.others.s_m  # after the route, its lane is not known
        inside = (its_s > self.s_m) & (its_s < self._road.route.length_m)
        inside &= reach_m < 0.5 * self.width_m - _SIDE_FREE_M
        invades = inside & (self.others.along_mps < -AT_REST_MPS)
        return bool(invades.any()) and not self._road.in_junction[self.at : self.at + 20].any()

    @property
    def is_on_oncoming_lane(self) -> bool:
        """Whether the car is on the oncoming lane."""
        return bool(self.way_y[self.here] > self.line_y[self.here])

    @property
    def is_free_behind(self) -> bool:
        """Whether no one would close the gap from which the car overtakes."""
        distance_m = self.s_m - self.others.s_m
        return not (self._on_route & (distance_m > 0.0) & (distance_m < _FREE_BEHIND_M)).any()

    def ways(self, offsets_m: Sequence[np.ndarray]) -> np.ndarray:
        """Return (P, G) places across the road on the grid."""
        s = self._road.route.s
        return np.array([self.route_y + np.interp(self.grid_m, s, one) for one in offsets_m])

    def rear_m(self, n: int) -> float:
        """Return the arc length of the rear of a road user [m]."""
        return float(self.others.s_m[n] - self.others.half_length_m[n])

    def needed_m(self, n: int, side: float, free_m: float) -> float:
        """Return how far beside the route the car passes a road user on one side [m]."""
        reach_m = self.others.half_width_m[n] + 0.5 * self._car.width_m + free_m
        return float(max(side * self.beside_m[n] + reach_m, 0.0))

    def cost_m(self, offset_m: np.ndarray) -> float:
        """Return what a way costs for the lines that it crosses, and for whom it hinders [m]."""
        ahead = slice(self.here, self.here + 100, 4)
        offset = np.interp(self.grid_m[ahead], self._road.route.s, offset_m)
        left = self._road.left[self._road.at(self.grid_m[ahead])]
        cost_m = _SOLID_M * float(((offset > self.inside_m) & (left == BEHIND_LINE)).any())
        cost_m += float((np.abs(offset) > 0.1).mean())
        later = self.here + int(40.0 / GRID_M)
        for n in self.emergency[:1]:
            y = self.ways([offset_m])[0][later]
            free_m = self.others.half_width_m[n] + 0.5 * self._car.width_m
            cost_m += _HINDERS_M * max(0.0, 1.0 - abs(y - self.others.y_m[n]) / free_m)
        return cost_m
