"""How the car passes, changes lanes, merges, pulls out and makes room.

Every quarter of a second, when something is in the way, ways beside the route are proposed,
simulated and scored, and the best one is taken: the recipe of PDM-Closed (D. Dauner et al.,
"Parting with Misconceptions about Learning-based Vehicle Motion Planning", CoRL 2023, arXiv
2306.07962).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, NamedTuple, Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.behaviour.forecast import GRID_M, Body, forecast
from sdc_package.behaviour.road import (
    BEHIND_LINE,
    NOTHING,
    SAME,
    Around,
    RoadAlong,
    around,
)

PASSING, GIVING_WAY, MERGING = "passing", "emergency_vehicle", "merging"
AMBULANCE = "ambulance"
# Whether the way leads back already is looked up so far ahead [m].
_SOON_M = 12.0
# A decision in so many plans (20 a second).
_PLANS = 5
# The stretch of the route that is looked at [m].
_BACK_M, _AHEAD_M, _SIDE_M = 70.0, 190.0, 8.0
# A road user in the way ahead of the car so near may be passed [m].
_LOOK_M = 70.0
# It is slow below this share of the speed without it, for so many decisions.
_SLOW, _SLOW_DECISIONS = 0.7, 4
# One that the car has seen moving may drive on, so it waits longer behind it.
_STOPPED_DECISIONS = 32
# Share of the speed without others at which it shifts to the side and back.
_RETURNS, _QUICK = 0.65, 0.6
# On the oncoming lane the car overtakes who is so slow, in so short a time, if the gap behind it
# stays open [m].
_OVERTAKEN, _OVERTAKES_S, _FREE_BEHIND_M = 0.6, 8.0, 18.0
# One at rest or slow so near before a junction, or behind another one that waits, waits, too [m].
_QUEUE_M, _BEHIND_M = (8.0, 30.0), 9.0
_AT_REST_MPS, _CRAWLS_MPS = 0.5, 2.0
# Free distance before and after one that is passed [m], and to its side; where the car waits for
# the oncoming lane to be free, it keeps a distance from which it can get out.
_BEFORE_M, _AFTER_M, _WAIT_M = 3.0, 3.0, 9.0
_BESIDE_M, _SIDE_FREE_M = 0.5, 0.3
# So far over the middle of its side the car may be on the next lane [m].
_OVER_M = 0.15
# Distances from the route that differ by less are the same [m].
_SAME_M = 0.15
# A shift across the road takes this distance [m], and as much as keeps the lateral acceleration.
_LEAST_SHIFT_M, _LATERAL_MPS2 = 10.0, 1.5
# From a parking bay, close behind another car, it begins after and takes [m].
_PULLS_OUT_M = 0.5, 8.0
_TIGHT_SHIFT_M = 8.0
# Peak of the second derivative of the smooth step t^3 (10 - 15 t + 6 t^2).
_PEAK = 5.7735
# Points, 1 m apart, over which a bend of a shift limits the speed.
_BEND_POINTS = 13
# Within its lane the car moves to the side by so much [m].
_NUDGE_M = 0.7
_SPEEDS = (1.0, 0.5, 0.0)
# The car brakes with the forecast if that is slower by this after 0.8 s [m/s].
_BRAKES_MPS = 0.3
# Values of a proposal, in metres of progress: another way than before, the oncoming lane, a solid
# line, each m/s^2 of braking beyond 2.5, the speed at the end per m/s, an ambulance behind.
_NEW_M, _ONCOMING_M, _SOLID_M, _BRAKING_M, _END_SPEED_S, _HINDERS_M = 4.0, 5.0, 6.0, 4.0, 1.0, 40.0
_CONTACT_M, _SLOWER_M = 1000.0, 1.0
# A contact after this time, and what it costs times this time.
_LATER_S, _LATER_M = 2.5, 300.0


# Distances to others are greater by this factor for what has not begun.
_NEW_MARGIN, _NUDGE_MARGIN = 1.6, 0.4


class Proposal(NamedTuple):
    """A way of the car."""

    name: str
    offset_m: np.ndarray  # at the points of the route, positive to the left [m]
    cost_m: float
    stop_m: float = math.inf  # where the centre of the car must stop [m]
    margin: float = _NEW_MARGIN  # factor of the distances to others


@dataclass
class Manoeuvres:
    """Decides how far beside its route the car drives, and how fast.

    Attributes:
        offset_m: (N,) distance from the route at its points, positive to the left [m]
        reason: why the car does not just follow its route, "" if it does
        most_mps: greatest speed that the last decision allows [m/s]
        stop_m: where the centre of the car must stop, inf: nowhere [m]
    """

    road: RoadAlong
    route: Route
    speed_mps: np.ndarray  # (N,) planned speed at the points of the route [m/s]
    lines_m: np.ndarray  # (M,) arc lengths at which junctions begin, and places behind them
    car: Body

    def __post_init__(self) -> None:
        self.offset_m = np.zeros(len(self.route.s))
        self.reason, self.most_mps, self.stop_m = "", math.inf, math.inf
        self._plans, self.waits = 0, True
        self.top_mps = float(self.speed_mps.max())
        self._slow: dict[int, int] = {}
        self.moved_ids: set[int] = set()  # road users that have moved
        self._has_begun = False
        self._until_m = 0.0  # where the manoeuvre ends

    @property
    def is_active(self) -> bool:
        """Return whether the way differs from the route."""
        return self._until_m > 0.0

    def offset_at(self, s_m: float) -> float:
        """Return the distance of the way from the route at an arc length, positive to the left."""
        if not self.is_active:
            return 0.0
        return float(np.interp(s_m, self.route.s, self.offset_m))

    def moved(self, rows: np.ndarray, ahead: slice) -> np.ndarray:
        """Return the rows x, y, v of the route at these points, moved to the way."""
        offset, heading = self.offset_m[ahead], self.route.heading[ahead]
        if not (self.is_active and offset.any()):
            return rows
        x, y = rows[:, 0] - offset * np.sin(heading), rows[:, 1] + offset * np.cos(heading)
        most = _most_mps(offset, self.route.s[ahead])
        return np.column_stack([x, y, np.minimum(rows[:, 2], most)])

    def decide(
        self,
        s_m: float,
        cross_track_m: float,
        speed_mps: float,
        obstacles: Sequence[DetectedObstacle],
        stop_m: float,
    ) -> None:
        """Choose the way; call it in each plan.

        Args:
            s_m: arc length of the car's centre along the route [m]
            cross_track_m: its distance from the route, positive to the left [m]
            speed_mps: its speed [m/s]
            obstacles: the detected road users
            stop_m: where the centre of the car must stop for lights and signs, inf: nowhere [m]
        """
        if not self._has_begun:
            self._has_begun = True
            self._begin_beside(s_m, cross_track_m)
        if self._until_m and s_m > self._until_m:
            self._until_m = 0.0
            self.offset_m = np.zeros_like(self.offset_m)
        self._plans += 1
        if self._plans % _PLANS != 1:
            return
        self.reason, self.most_mps, self.stop_m = "", math.inf, math.inf
        others = around(self.road, self.route, s_m, obstacles, _BACK_M, _AHEAD_M, _SIDE_M)
        if not len(others.s_m):
            if self.is_active and self._until_m > s_m + _AHEAD_M:
                self._follow(self.shifted(0.0, s_m, speed_mps, math.inf), s_m)
            return
        situation = _Situation(self, s_m, speed_mps, others, obstacles, stop_m)
        if situation.is_quiet:
            return
        proposals = list(situation.proposals())
        ways = situation.ways([one.offset_m for one in proposals])
        names = [(one, share) for one in proposals for share in _SPEEDS]
        pick = np.repeat(np.arange(len(proposals)), len(_SPEEDS))
        shares = np.tile(_SPEEDS, len(proposals))[:, None]
        stops = np.minimum([one.stop_m for one, _ in names], stop_m)
        most = situation.most_mps * shares
        for row in range(len(proposals)):
            bends = _most_mps(ways[row] - situation.route_y, situation.grid_m)
            rows = slice(row * len(_SPEEDS), (row + 1) * len(_SPEEDS))
            most[rows] = np.minimum(most[rows], bends)
        margins = np.array([one.margin for one, _ in names])[:, None]
        result = forecast(
            ways[pick],
            most,
            situation.from_m,
            s_m,
            speed_mps,
            others,
            stops,
            margins,
            self.car,
            situation.line_y,
        )
        value = result.progress_m + _END_SPEED_S * result.end_mps
        value -= np.array([one.cost_m + _SLOWER_M * (share < 1.0) for one, share in names])
        value -= _ONCOMING_M * result.oncoming_s
        value -= _BRAKING_M * np.maximum(result.braking_mps2 - self.car.braking_mps2, 0.0)
        contact = np.isfinite(result.contact_s)
        # On the oncoming lane, to stop is worse than a contact that is far away.
        later = contact & (result.contact_s > _LATER_S) & situation.is_on_oncoming_lane
        value[later] -= _LATER_M / result.contact_s[later]
        contact &= ~later
        value[contact] = 10.0 * result.contact_s[contact] - _CONTACT_M
        value[contact] -= 0.1 * result.progress_m[contact]
        best = int(np.argmax(value))
        chosen, share = names[best]
        self.last = [(n.name, float(sh), round(float(x), 1)) for (n, sh), x in zip(names, value)]
        if chosen.name != "keep":
            self._follow(chosen.offset_m, s_m)
        self.waits = share == 0.0 or math.isfinite(chosen.stop_m)
        if share < 1.0:
            self.most_mps = share * float(situation.most_mps[situation.here])
            self.reason = MERGING
        if result.soon_mps[best] < speed_mps - _BRAKES_MPS:
            self.most_mps = min(self.most_mps, float(result.soon_mps[best]))
            self.reason = MERGING
        self.stop_m = chosen.stop_m
        if self.is_active and not self.reason:
            self.reason = PASSING

    def _begin_beside(self, s_m: float, cross_track_m: float) -> None:
        """Begin on a way from where the car is, if it is not in its lane, such as a parking bay."""
        if abs(cross_track_m) > 1.0:
            begin_m, length_m = s_m + _PULLS_OUT_M[0], _PULLS_OUT_M[1]
            self._follow(cross_track_m * (1.0 - _step(self.route.s, begin_m, length_m)), s_m)

    def _follow(self, offset_m: np.ndarray, s_m: float) -> None:
        self.offset_m = offset_m
        beside = np.flatnonzero((np.abs(offset_m) > 0.01) & (self.route.s > s_m))
        self._until_m = float(self.route.s[beside[-1]]) + 1.0 if len(beside) else 0.0

    def shifted(self, to_m: float, begin_m: float, speed_mps: float, room_m: float) -> np.ndarray:
        """Return the way that goes over to a distance from the route.

        Args:
            to_m: the distance, positive to the left [m]
            begin_m: arc length at which it begins [m]
            speed_mps: speed of the car [m/s]
            room_m: distance within which it would be over, if the speed allows [m]
        """
        s, now_m = self.route.s, self.offset_at(begin_m)
        least_m, most_m = (shift_length_m(to_m - now_m, v) for v in (speed_mps, self.top_mps))
        length_m = max(least_m, min(room_m, most_m))
        step = _step(s, begin_m, length_m)
        before = np.where(s < begin_m, self.offset_m, now_m)
        return before * (1.0 - step) + to_m * step


class _Situation:
    """What one decision knows."""

    def __init__(
        self,
        plan: Manoeuvres,
        s_m: float,
        speed_mps: float,
        others: Around,
        obstacles: Sequence[DetectedObstacle],
        stop_m: float,
    ):
        self._plan, self._s_m, self._speed_mps, self._others = plan, s_m, speed_mps, others
        self._kinds = [obstacles[row].kind for row in others.rows.tolist()]
        self._ids = [obstacles[row].id for row in others.rows.tolist()]
        road, route = plan.road, plan.route
        self.from_m = s_m - _BACK_M
        self.grid_m = self.from_m + GRID_M * np.arange(int((_BACK_M + _AHEAD_M + 80.0) / GRID_M))
        self.here = int(_BACK_M / GRID_M)
        self.route_y = np.interp(self.grid_m, road.s_m, road.route_y_m)
        self.most_mps = np.interp(self.grid_m, route.s, plan.speed_mps)
        self._top_mps = float(self.most_mps[self.here : self.here + 60].max())
        self._returns_mps = max(speed_mps, _RETURNS * self._top_mps)
        lines_m = plan.lines_m[plan.lines_m > s_m]
        self._next_line_m = float(min(lines_m, default=route.length_m))
        self._way_y = self.ways([plan.offset_m])[0]
        self._at = road.at(s_m)
        # Beyond this the car is on the oncoming lane.
        left = road.left[np.minimum(np.searchsorted(road.s_m, self.grid_m), len(road.s_m) - 1)]
        half_m = 0.5 * float(road.width_m[self._at] - plan.car.width_m)
        self.line_y = np.where(left == SAME, math.inf, self.route_y + half_m + _SAME_M)
        self.is_on_oncoming_lane = bool(self._way_y[self.here] > self.line_y[self.here])
        half_m = others.half_width_m + 0.5 * plan.car.width_m
        beside_m = np.abs(others.y_m - np.interp(others.s_m, self.grid_m, self._way_y))
        distance_m = others.s_m - s_m
        self._in_way = beside_m < half_m + _SIDE_FREE_M
        ahead = (distance_m > 0.0) & (distance_m < _LOOK_M)
        top = np.interp(others.s_m, self.grid_m, self.most_mps)
        slow = self._in_way & ahead & (others.along_mps < _SLOW * top)
        self._count_slow(slow)
        self._queue = self._waiting(half_m)
        self._passable = [
            n
            for n in np.flatnonzero(self._on_route(half_m) & ahead & ~self._queue)
            if self._kinds[n] != "pedestrian"
            and others.along_mps[n] > -_AT_REST_MPS
            and (plan._slow.get(self._ids[n], 0) >= self._needed(n))
        ]
        self._behind = [
            n
            for n in range(len(self._ids))
            if self._kinds[n] == AMBULANCE
            and -_BACK_M < distance_m[n] < 0.0
            and others.along_mps[n] > speed_mps - 1.0
        ]

    def _needed(self, n: int) -> int:
        if self._kinds[n] == "obstacle":
            return 1
        has_stopped = (
            self._others.along_mps[n] < _AT_REST_MPS and self._ids[n] in self._plan.moved_ids
        )
        return _STOPPED_DECISIONS if has_stopped else _SLOW_DECISIONS

    def _on_route(self, half_m: np.ndarray) -> np.ndarray:
        """Return which road users are on the lane of the route."""
        y = np.interp(self._others.s_m, self.grid_m, self.route_y)
        return np.abs(self._others.y_m - y) < half_m + _SIDE_FREE_M

    def _count_slow(self, slow: np.ndarray) -> None:
        counts = self._plan._slow
        now = {self._ids[n] for n in np.flatnonzero(slow)}
        self._plan.moved_ids |= {self._ids[n] for n in np.flatnonzero(self._others.along_mps > 1.0)}
        for one in [one for one in counts if one not in now and not self._plan.is_active]:
            del counts[one]
        for one in now:
            counts[one] = counts.get(one, 0) + 1

    def _waiting(self, half_m: np.ndarray) -> np.ndarray:
        """Return which road users wait in a queue before a junction."""
        others, lines = self._others, self._plan.lines_m
        waits = np.zeros(len(self._ids), bool)
        on_route = self._on_route(half_m)
        front = others.s_m + others.half_length_m
        end_m = math.inf
        for n in np.argsort(-others.s_m):
            if not on_route[n] or self._kinds[n] == "obstacle" or others.along_mps[n] < -0.5:
                continue
            to_line = lines - front[n]
            before = to_line[to_line > -2.0]
            slow, queue_m = (
                others.along_mps[n] < 3.0,
                _QUEUE_M[int(others.along_mps[n] > _AT_REST_MPS)],
            )
            waits[n] = slow and (
                (len(before) and before[0] < queue_m) or end_m - front[n] < _BEHIND_M
            )
            if waits[n]:
                end_m = float(others.s_m[n] - others.half_length_m[n])
        return waits

    @property
    def is_quiet(self) -> bool:
        """Return whether nothing asks for another way."""
        return not (
            self._plan.is_active
            or self._passable
            or self._behind
            or self._changes_lane()
            or self._intruders()
        )

    def _changes_lane(self) -> bool:
        """Return whether the route changes lanes soon."""
        ahead = slice(self.here, self.here + 60)
        return float(np.ptp(self.route_y[ahead])) > 1.0

    def _intruders(self) -> bool:
        """Return whether an oncoming one reaches into the way of the car."""
        others, road = self._others, self._plan.road
        ahead = (others.s_m > self._s_m) & (others.along_mps < -_AT_REST_MPS)
        y = others.y_m - np.interp(others.s_m, self.grid_m, self.route_y)
        width_m = float(road.width_m[self._at])
        invades = (np.abs(y) - others.half_width_m < 0.5 * width_m - _SIDE_FREE_M) & ahead
        return bool(invades.any()) and not road.in_junction[self._at : self._at + 20].any()

    def ways(self, offsets_m: Sequence[np.ndarray]) -> np.ndarray:
        """Return (P, G) places across the road on the grid."""
        s = self._plan.route.s
        return np.array([self.route_y + np.interp(self.grid_m, s, one) for one in offsets_m])

    def proposals(self) -> Iterator[Proposal]:
        """Yield the ways that the car could take."""
        plan, s_m, speed_mps = self._plan, self._s_m, self._speed_mps
        # What has begun goes on with smaller distances, so that the car is not of two minds.
        margin = _NEW_MARGIN if speed_mps < _AT_REST_MPS and plan.waits else 1.0
        yield Proposal("keep", plan.offset_m, self._cost(plan.offset_m), self._wait_m(), margin)
        road, at = plan.road, self._at
        width_m = float(road.width_m[at])
        if abs(plan.offset_at(s_m + _SOON_M)) > _SAME_M:
            back = plan.shifted(0.0, s_m + 0.5, speed_mps, 0.0)
            yield Proposal("back", back, self._cost(back) + 1.0, self._wait_m())
        if self._passable:
            yield from self._passes(width_m)
        if self._behind:
            for side, free in ((-1.0, road.right[at]), (1.0, road.left[at])):
                if free == SAME:
                    length_m = shift_length_m(width_m, speed_mps)
                    until_m = min(s_m + 80.0, self._next_line_m - 1.5 * length_m)
                    if until_m < s_m + length_m:
                        continue
                    aside = self._there_and_back(side * width_m, s_m, until_m)
                    yield Proposal("aside", aside, self._cost(aside) + _NEW_M)
            if not plan.is_active:
                edge = self._there_and_back(-_NUDGE_M, s_m, s_m + 80.0)
                yield Proposal("edge", edge, self._cost(edge) + _NEW_M)
        if (self._intruders() or self._passable) and not plan.is_active:
            for nudge_m in (-_NUDGE_M, _NUDGE_M):
                aside = self._there_and_back(nudge_m, s_m, s_m + 40.0)
                cost_m = self._cost(aside) + _NEW_M
                yield Proposal("nudge", aside, cost_m, self._wait_m(), _NUDGE_MARGIN)
        if self._changes_lane():
            y = self._way_y[self.here]
            late_m = float(road.edge_end_m[at]) - 8.0
            length_m = shift_length_m(width_m, speed_mps)
            begin_m = min(s_m + 60.0, late_m - length_m)
            if begin_m > s_m:
                s = plan.route.s
                stay = y - np.interp(s, road.s_m, road.route_y_m)
                step = _step(s, begin_m, length_m)
                stay = np.where(s < s_m - 1.0, plan.offset_m, stay * (1.0 - step))
                yield Proposal("stay", stay, self._cost(stay) + 1.0)

    def _passes(self, width_m: float) -> Iterator[Proposal]:
        """Yield the ways around those that are passable, to the left and to the right."""
        plan, s_m, speed_mps, others = self._plan, self._s_m, self._speed_mps, self._others
        road, at = plan.road, self._at
        until_m, time_s = -math.inf, 0.0
        group: list[int] = []
        # The road users that are passed together.
        for n in sorted(self._passable, key=lambda n: others.s_m[n]):
            speed = max(float(others.along_mps[n]), 0.0)
            rear_m = float(others.s_m[n] - others.half_length_m[n])
            if group and rear_m - until_m > 25.0 + 2.0 * speed:
                break
            ways_m = others.half_length_m[n] * 2.0 + plan.car.front_m * 2.0 + _BEFORE_M + _AFTER_M
            gap_m = max(rear_m - s_m - plan.car.front_m, 0.0)
            mean_mps = max(0.5 * (max(speed_mps, speed) + self._top_mps), speed + 1.0)
            time_s = (gap_m + ways_m) / max(mean_mps - speed, 0.5)
            end_m = float(others.s_m[n] + others.half_length_m[n]) + plan.car.front_m + _AFTER_M
            until_m = max(until_m, end_m + (speed > _AT_REST_MPS) * speed * time_s)
            group.append(n)
        first, begin_m = group[0], s_m + 0.5
        rear_m = float(others.s_m[first] - others.half_length_m[first])
        moving = max(float(others.along_mps[n]) for n in group) > _AT_REST_MPS
        inside_m = 0.5 * (width_m - plan.car.width_m)
        for side, beside in ((1.0, road.left), (-1.0, road.right)):
            needed_m = max(self._needed_offset_m(n, side) for n in group)
            stretch = beside[at : road.at(until_m) + 1]
            if needed_m <= inside_m:
                to_m = side * needed_m
            elif (stretch == NOTHING).any() or (
                moving
                and (
                    side < 0.0
                    or not self._may_overtake(
                        stretch, until_m, time_s, max(float(others.along_mps[n]) for n in group)
                    )
                )
            ):
                continue
            else:
                # From rest close behind it, only the middle of the next lane is far enough.
                full = (stretch == SAME).all() or speed_mps < _CRAWLS_MPS
                to_m = side * min(max(needed_m, full * width_m), width_m + inside_m + _OVER_M)
            room_m = rear_m - plan.car.front_m - max(_BEFORE_M, speed_mps) - begin_m
            offset = self._there_and_back(to_m, begin_m, until_m, room_m)
            yield Proposal("pass", offset, self._cost(offset) + _NEW_M)
            quick = self._there_and_back(to_m, begin_m, until_m, room_m, _QUICK)
            yield Proposal("pass", quick, self._cost(quick) + _NEW_M)
            # As late as possible, for those at rest.
            late_m = rear_m - plan.car.front_m - max(_BEFORE_M, speed_mps)
            late_m -= shift_length_m(to_m, self._returns_mps)
            if not moving and late_m > begin_m + 3.0:
                length_m = shift_length_m(to_m, self._returns_mps)
                offset = self._there_and_back(to_m, late_m, until_m, length_m)
                yield Proposal("pass", offset, self._cost(offset) + _NEW_M)

    def _may_overtake(
        self, stretch: np.ndarray, until_m: float, time_s: float, speed_mps: float
    ) -> bool:
        """Return whether the car may overtake moving ones on the lanes of this stretch.

        Args:
            stretch: what is beside the lane
            until_m: where the overtaking ends [m]
            time_s: how long it takes [s]
            speed_mps: speed of the fastest one [m/s]
        """
        end_m = until_m + shift_length_m(float(self._plan.road.width_m[self._at]), self._top_mps)
        if (stretch == SAME).all():
            return end_m < self._next_line_m
        return bool(
            (stretch != BEHIND_LINE).all()
            and time_s < _OVERTAKES_S
            and end_m < self._next_line_m - 10.0
            and speed_mps < _OVERTAKEN * self._top_mps
            and self._is_free_behind()
        )

    def _is_free_behind(self) -> bool:
        """Return whether no one would close the gap from which the car overtakes."""
        others = self._others
        distance_m = self._s_m - others.s_m
        on_route = self._on_route(others.half_width_m + 0.5 * self._plan.car.width_m)
        return not (on_route & (distance_m > 0.0) & (distance_m < _FREE_BEHIND_M)).any()

    def _needed_offset_m(self, n: int, side: float) -> float:
        """Return how far beside the route the car passes a road user on one side."""
        others = self._others
        y = others.y_m[n] - np.interp(others.s_m[n], self.grid_m, self.route_y)
        free_m = others.half_width_m[n] + 0.5 * self._plan.car.width_m + _BESIDE_M
        return float(max(side * y + free_m, 0.0))

    def _there_and_back(
        self, to_m: float, begin_m: float, until_m: float, room_m: float = 0.0, share: float = 1.0
    ) -> np.ndarray:
        """Return the way that is beside the route up to an arc length, and returns after it."""
        plan, s = self._plan, self._plan.route.s
        out = plan.shifted(to_m, begin_m, self._speed_mps, room_m)
        ahead = s > self._s_m
        if plan.is_active and ahead.any() and to_m:
            # On the way out already: only the way back is another one.
            peak = int(np.argmax(np.where(ahead, plan.offset_m * math.copysign(1.0, to_m), -9.0)))
            if abs(to_m - plan.offset_m[peak]) < _SAME_M or abs(plan.offset_m[peak]) > abs(to_m):
                out = np.where(s < s[peak], plan.offset_m, plan.offset_m[peak])
        length_m = shift_length_m(to_m, share * self._returns_mps)
        return out * (1.0 - _step(plan.route.s, until_m, length_m))

    def _cost(self, offset_m: np.ndarray) -> float:
        """Return what the lanes cost that a way uses [m]."""
        plan = self._plan
        if not offset_m.any():
            return self._hindered(offset_m)
        road, grid = plan.road, self.grid_m[self.here : self.here + 100 : 4]
        offset = np.interp(grid, plan.route.s, offset_m)
        left = road.left[np.minimum(np.searchsorted(road.s_m, grid), len(road.s_m) - 1)]
        half_m = 0.5 * (road.width_m[self._at] - plan.car.width_m)
        over = offset > half_m
        cost = _SOLID_M * float((over & (left == BEHIND_LINE)).any())
        cost += 1.0 * float((np.abs(offset) > 0.1).mean())
        return cost + self._hindered(offset_m)

    def _hindered(self, offset_m: np.ndarray) -> float:
        """Return the cost of staying before an emergency vehicle."""
        if not self._behind:
            return 0.0
        later_m = self._s_m + 40.0
        y = np.interp(later_m, self._plan.route.s, offset_m) + np.interp(
            later_m, self.grid_m, self.route_y
        )
        n = self._behind[0]
        free_m = self._others.half_width_m[n] + 0.5 * self._plan.car.width_m
        return _HINDERS_M * max(0.0, 1.0 - abs(y - self._others.y_m[n]) / free_m)

    def _wait_m(self) -> float:
        """Return where the car waits before one that it could pass on the oncoming lane."""
        others, stop_m = self._others, math.inf
        if self._plan.is_active:
            return stop_m
        for n in self._passable:
            if others.along_mps[n] < _AT_REST_MPS:
                rear_m = float(others.s_m[n] - others.half_length_m[n])
                stop_m = min(stop_m, rear_m - self._plan.car.front_m - _WAIT_M)
        # A car that has stopped a little too late stays.
        return max(stop_m, self._s_m) if stop_m > self._s_m - _BEFORE_M else math.inf


def shift_length_m(shift_m: float, speed_mps: float) -> float:
    """Return the distance over which the car shifts across the road [m]."""
    least_m = _LEAST_SHIFT_M if speed_mps > 1.0 else _TIGHT_SHIFT_M
    return max(least_m, speed_mps * math.sqrt(_PEAK * abs(shift_m) / _LATERAL_MPS2))


def _most_mps(offset_m: np.ndarray, s_m: np.ndarray) -> np.ndarray:
    """Return the speeds (N,) with which the car follows the bends of a way beside the route."""
    bend = maximum_filter1d(np.abs(np.gradient(np.gradient(offset_m, s_m), s_m)), _BEND_POINTS)
    square = 2.0 * _LATERAL_MPS2 / np.maximum(bend, 1e-3)
    # It brakes in time.
    before = 2.0 * _LATERAL_MPS2 * s_m
    return np.sqrt(np.minimum.accumulate((square + before)[::-1])[::-1] - before)


def _step(s_m: np.ndarray, begin_m: float, length_m: float) -> np.ndarray:
    """Return the smooth step from 0 to 1 over a stretch."""
    t = np.clip((s_m - begin_m) / length_m, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t * t)
