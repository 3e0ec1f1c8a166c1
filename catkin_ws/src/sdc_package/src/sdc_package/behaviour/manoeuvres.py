"""How the car passes, changes lanes, merges, pulls out and makes room.

Every quarter of a second, when something is in the way, ways beside the route are proposed,
simulated and scored, and the best one is taken: the recipe of PDM-Closed (D. Dauner et al.,
"Parting with Misconceptions about Learning-based Vehicle Motion Planning", CoRL 2023, arXiv
2306.07962).
"""

from __future__ import annotations

import math
from typing import Any, Iterator, NamedTuple

import numpy as np

from sdc_common.geometry.route import smooth_step
from sdc_package.behaviour.forecast import SOON_S, Body, Forecast, forecast
from sdc_package.behaviour.offset_path import SAME_M, OffsetPath, bend_mps, shift_length_m
from sdc_package.behaviour.road import BEHIND_LINE, NOTHING, SAME, RoadAlong
from sdc_package.behaviour.situation import AT_REST_MPS, DECISION_S, Memory, Situation
from sdc_package.braking import FIRM_MPS2
from sdc_package.obstacle_prediction import Obstacles

PASSING, MERGING = "passing", "merging"
KEEP, BACK, STAY, PASS, ASIDE, NUDGE = "keep", "back", "stay", "pass", "aside", "nudge"
_PLANS = round(20 * DECISION_S)  # a decision in so many plans, 20 a second
_SHARES = (1.0, 0.5, 0.0)  # each way is simulated with these shares of the planned speed
# Distances to others are greater by this factor for what has not begun, and smaller for a nudge.
_NEW_MARGIN, _NUDGE_MARGIN = 1.3, 0.4
# Share of the usual speed at which the car shifts to the side and back when it is in a hurry.
_QUICK = 0.6
# On the oncoming lane the car overtakes who is so slow, in so short a time.
_OVERTAKEN, _OVERTAKES_S = 0.6, 8.0
_CRAWLS_MPS, _CLOSE_M = 2.0, 4.0
# Free distance before and after one that is passed [m], and to its side; where the car waits for
# the oncoming lane to be free, it keeps a distance from which it can get out.
_BEFORE_M, _AFTER_M, _WAIT_M, _BESIDE_M = 3.0, 3.0, 9.0, 0.5
# So far over the middle of its side the car may be on the next lane [m].
_OVER_M = 0.15
# A car so far beside its route at the start pulls out: it begins after, and takes [m].
_PULLS_OUT_M, _OUT_AFTER_M, _OUT_M = 1.0, 0.5, 8.0
# Within its lane the car moves aside by so much, for so far, and again so far before its end [m].
_NUDGE_M, _NUDGED_M, _AGAIN_M = 0.7, 40.0, 30.0
# The car makes room for so long [s].
_ASIDE_S = 6.7
# Whether the way leads back already is looked up so far ahead; a change of lanes may come so much
# later, and so much before the lane ends [m], in the end at such a speed [m/s].
_SOON_M, _LATER_M, _LANE_END_M, _CHANGES_MPS = 12.0, 100.0, 8.0, 4.0
_BETWEEN = 0.3  # nearer than this share of a lane to where two meet, the car is between them
# The car brakes with the forecast if that is slower by this after 0.8 s [m/s].
_BRAKES_MPS = 0.3
# Values in metres of progress: another way than before, a second on the oncoming lane, each m/s^2
# of braking beyond the usual, each m/s at the end, a slower speed, a contact.
_NEW_M, _ONCOMING_M, _BRAKING_M, _END_S, _SLOWER_M, _CONTACT_M = 4.0, 3.0, 4.0, 1.0, 1.0, 1000.0
# A contact after this time may still be avoided; it costs this, divided by the time.
_FAR_S, _FAR_M = 2.5, 300.0
_LATER_S, _LATER_COST_M = 4.5, 100.0


class Proposal(NamedTuple):
    """A way of the car."""

    name: str
    offset_m: np.ndarray  # distance from the points of the route, positive to the left [m]
    cost_m: float
    margin: float = _NEW_MARGIN  # factor of the distances to others
    stop_m: float = math.inf  # where the centre of the car must stop [m]


class StayOnRoute:
    """Keeps the car on its route, as one that does not pass, change lanes or make room.

    Args:
        road: the road along the route
        lines_m: (M,) arc lengths at which junctions begin [m]
        car: the car

    Attributes:
        way: where the car drives
        reason: why it does not just follow its route, "" if it does
        most_mps: greatest speed that the last decision allows [m/s]
        stop_m: where the centre of the car must stop, inf: nowhere [m]
    """

    def __init__(self, road: RoadAlong, lines_m: np.ndarray, car: Body):
        self.way = OffsetPath(road.route, float(road.speed_mps.max()))
        self.reason, self.most_mps, self.stop_m = "", math.inf, math.inf

    def decide(self, *_: Any, **__: Any) -> None:
        """Keep the route; Manoeuvres has the arguments."""


class Manoeuvres(StayOnRoute):
    """Decides how far beside its route the car drives, and how fast."""

    def __init__(self, road: RoadAlong, lines_m: np.ndarray, car: Body):
        super().__init__(road, lines_m, car)
        self._road, self._lines_m, self._car = road, lines_m, car
        self._memory = Memory()
        self._plans, self._waits = 0, True

    def decide(
        self,
        s_m: float,
        cross_track_m: float,
        speed_mps: float,
        obstacles: Obstacles,
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
        if not self._plans and abs(cross_track_m) > _PULLS_OUT_M:
            out = smooth_step(self._road.route.s, s_m + _OUT_AFTER_M, _OUT_M)
            self.way.follow(cross_track_m * (1.0 - out), s_m)
        self.way.pass_by(s_m)
        self._plans += 1
        if self._plans % _PLANS != 1:
            return
        self.reason, self.most_mps, self.stop_m = "", math.inf, math.inf
        if not (obstacles or self.way.until_m):
            return
        road, way, lines_m = self._road, self.way, self._lines_m
        now = Situation(road, way, self._car, self._memory, lines_m, s_m, speed_mps, obstacles)
        if not now.is_quiet:
            self._choose(now, list(self._proposals(now)), stop_m)

    def _choose(self, now: Situation, proposals: list[Proposal], stop_m: float) -> None:
        ways = now.ways([one.offset_m for one in proposals])
        bends_mps = [bend_mps(one - now.route_y, now.grid_m) for one in ways]
        rows = np.repeat(np.arange(len(proposals)), len(_SHARES))
        shares = np.tile(_SHARES, len(proposals))
        most_mps = np.minimum(now.most_mps * shares[:, None], np.array(bends_mps)[rows])
        stops_m = np.minimum([proposals[n].stop_m for n in rows], stop_m)
        margins = np.array([[proposals[n].margin] for n in rows])
        here = now.from_m, now.s_m, now.speed_mps, now.others
        result = forecast(ways[rows], most_mps, *here, stops_m, margins, self._car, now.line_y)
        costs_m = np.array([proposals[n].cost_m for n in rows])
        # Who slows down for those beside it stays in its lane.
        slower_m = np.where([proposals[n].name == STAY for n in rows], -_SLOWER_M, _SLOWER_M)
        costs_m += slower_m * (shares < 1.0)
        keeps = np.array([proposals[n].name == KEEP for n in rows])
        best = int(np.argmax(self._values(result, keeps, now.is_on_oncoming_lane) - costs_m))
        chosen, share = proposals[rows[best]], float(shares[best])
        if chosen.name != KEEP:
            self.way.follow(chosen.offset_m, now.s_m)
        self.stop_m = chosen.stop_m
        self._waits = share == 0.0 or math.isfinite(chosen.stop_m)
        soon_mps = max(float(result.soon_mps[best]), now.speed_mps - SOON_S * FIRM_MPS2)
        if share < 1.0:
            self.most_mps = max(share * float(now.most_mps[now.here]), soon_mps)
        if soon_mps < now.speed_mps - _BRAKES_MPS:
            self.most_mps = min(self.most_mps, soon_mps)
        if math.isfinite(self.most_mps):
            self.reason = MERGING
        elif self.way.until_m:
            self.reason = PASSING

    def _values(self, result: Forecast, keeps: np.ndarray, is_on_oncoming_lane: bool) -> np.ndarray:
        """Return the value of each proposal without its cost [m]."""
        value = result.progress_m + _END_S * result.end_mps - _ONCOMING_M * result.oncoming_s
        value -= _BRAKING_M * np.maximum(result.braking_mps2 - self._car.braking_mps2, 0.0)
        contact = np.isfinite(result.contact_s)
        # On the oncoming lane, to stop is worse than a contact that is far away; on its own one,
        # the car waits with braking for it.
        own_side = keeps & (result.oncoming_s == 0.0)
        far_s, far_m = (_FAR_S, _FAR_M) if is_on_oncoming_lane else (_LATER_S, _LATER_COST_M)
        far = contact & (result.contact_s > far_s) & (own_side | is_on_oncoming_lane)
        value[far] -= far_m / result.contact_s[far]
        contact &= ~far
        first = 10.0 * result.contact_s[contact] - 0.1 * result.progress_m[contact]
        value[contact] = first - _CONTACT_M
        return value

    def _proposals(self, now: Situation) -> Iterator[Proposal]:
        """Yield the ways that the car could take."""
        way, s_m, speed_mps = self.way, now.s_m, now.speed_mps
        wait_m = self._wait_m(now)
        # What has begun goes on with smaller distances, so that the car is not of two minds.
        margin = _NEW_MARGIN if speed_mps < AT_REST_MPS and self._waits else 1.0
        yield Proposal(KEEP, way.offset_m, now.cost_m(way.offset_m), margin, wait_m)
        if abs(way.offset_at(s_m + _SOON_M)) > SAME_M:
            back = way.shifted(0.0, s_m + 0.5, speed_mps, 0.0)
            yield Proposal(BACK, back, now.cost_m(back) + 1.0, stop_m=wait_m)
        for one in self._passes(now) if now.passable else ():
            yield Proposal(PASS, one, now.cost_m(one) + _NEW_M)
        for one in self._asides(now) if now.emergency else ():
            yield Proposal(ASIDE, one, now.cost_m(one) + _NEW_M)
        may_nudge = way.until_m < s_m + _AGAIN_M and abs(way.offset_at(s_m)) < _PULLS_OUT_M
        if (now.is_invaded or now.passable) and may_nudge:
            for to_m in (-_NUDGE_M, _NUDGE_M):
                nudge = self._there_and_back(now, to_m, s_m, s_m + _NUDGED_M)
                yield Proposal(NUDGE, nudge, now.cost_m(nudge) + _NEW_M, _NUDGE_MARGIN, wait_m)
        if now.changes_lane:
            yield from self._stays(now)

    def _stays(self, now: Situation) -> Iterator[Proposal]:
        """Yield the ways that stay in a lane and wait for the change of lanes before it ends."""
        road, s, s_m = self._road, self._road.route.s, now.s_m
        length_m = shift_length_m(now.width_m, min(now.speed_mps, _CHANGES_MPS))
        begin_m = min(s_m + _LATER_M, float(road.edge_end_m[now.at]) - _LANE_END_M - length_m)
        if begin_m < s_m:
            return
        y, route_y = float(now.way_y[now.here]), np.interp(s, road.s_m, road.route_y_m)
        lane, later = y / now.width_m, 1.0 - smooth_step(s, begin_m, length_m)
        # What has begun is taken back or completed.
        for to_y in {now.width_m * round(lane - _BETWEEN), now.width_m * round(lane + _BETWEEN)}:
            over = smooth_step(s, s_m, shift_length_m(to_y - y, now.speed_mps))
            held = y + (to_y - y) * over - route_y
            stay = np.where(s < s_m - 1.0, self.way.offset_m, held * later)
            stop_m = math.inf if abs(np.interp(begin_m, s, held)) < SAME_M else begin_m
            yield Proposal(STAY, stay, now.cost_m(stay) + 1.0, stop_m=stop_m)

    def _asides(self, now: Situation) -> Iterator[np.ndarray]:
        """Yield the ways that make room for an emergency vehicle."""
        length_m = shift_length_m(now.width_m, now.speed_mps)
        until_m = min(now.s_m + _ASIDE_S * now.top_mps, now.end_m - 1.5 * length_m)
        for side, beside in ((-1.0, self._road.right), (1.0, self._road.left)):
            if beside[now.at] == SAME and until_m > now.s_m + length_m:
                yield self._there_and_back(now, side * now.width_m, now.s_m, until_m)
        if not self.way.until_m:
            yield self._there_and_back(now, -_NUDGE_M, now.s_m, now.s_m + _ASIDE_S * now.top_mps)

    def _passes(self, now: Situation) -> Iterator[np.ndarray]:
        """Yield the ways around those that are passable, to the left and to the right."""
        group, until_m, time_s = self._group(now)
        fastest_mps = max(float(now.others.along_mps[n]) for n in group)
        moves = fastest_mps > AT_REST_MPS
        begin_m, front_m = now.s_m + 0.5, now.rear_m(group[0]) - self._car.front_m
        front_m -= max(_BEFORE_M, now.speed_mps)
        for side, beside in ((1.0, self._road.left), (-1.0, self._road.right)):
            needed_m = max(now.needed_m(n, side, _BESIDE_M) for n in group)
            stretch = beside[now.at : self._road.at(until_m) + 1]
            if needed_m > now.inside_m:
                if (stretch == NOTHING).any() or (moves and side < 0.0):
                    continue
                if moves and not self._may_overtake(now, stretch, until_m, time_s, fastest_mps):
                    continue
                # From rest close behind it, only the middle of the next lane is far enough.
                is_close = now.speed_mps < _CRAWLS_MPS and front_m - begin_m < _CLOSE_M
                full = (stretch == SAME).all() or is_close
                most_m = now.width_m + now.inside_m + _OVER_M
                needed_m = min(max(needed_m, full * now.width_m), most_m)
            to_m, room_m = side * needed_m, front_m - begin_m
            length_m = shift_length_m(to_m, now.shifts_mps)
            for quick in (1.0, _QUICK):
                yield self._there_and_back(now, to_m, begin_m, until_m, room_m, quick)
            if not moves and front_m - length_m > begin_m + 3.0:  # as late as possible
                late_m = front_m - length_m
                yield self._there_and_back(now, to_m, late_m, until_m, length_m)

    def _group(self, now: Situation) -> tuple[list[int], float, float]:
        """Return those that are passed together, where that ends [m], and the time for it [s]."""
        others, front_m = now.others, self._car.front_m
        group: list[int] = []
        until_m, time_s = -math.inf, 0.0
        for n in now.passable:
            speed_mps, rear_m = max(float(others.along_mps[n]), 0.0), now.rear_m(n)
            if group and rear_m - until_m > 25.0 + 2.0 * speed_mps:
                break
            length_m = 2.0 * float(others.half_length_m[n])
            gap_m = max(rear_m - now.s_m - front_m, 0.0)
            faster_mps = max(now.top_mps - speed_mps, 1.0)
            time_s = (gap_m + length_m + 2.0 * front_m + _BEFORE_M + _AFTER_M) / faster_mps
            time_s += max(now.top_mps - now.speed_mps, 0.0) / (2.0 * self._car.acceleration_mps2)
            end_m = rear_m + length_m + front_m + _AFTER_M
            until_m = max(until_m, end_m + (speed_mps > AT_REST_MPS) * speed_mps * time_s)
            group.append(n)
        return group, until_m, time_s

    def _may_overtake(
        self, now: Situation, stretch: np.ndarray, until_m: float, time_s: float, its_mps: float
    ) -> bool:
        """Return whether the car may overtake one at this speed, beside these lanes until then."""
        end_m = until_m + shift_length_m(now.width_m, now.top_mps)
        if (stretch == SAME).all():
            return end_m < now.end_m
        is_short = time_s < _OVERTAKES_S and end_m < now.end_m - 10.0
        is_slow = its_mps < _OVERTAKEN * now.top_mps
        return bool((stretch != BEHIND_LINE).all() and is_short and is_slow and now.is_free_behind)

    def _there_and_back(
        self,
        now: Situation,
        to_m: float,
        begin_m: float,
        until_m: float,
        room_m: float = 0.0,
        quick: float = 1.0,
    ) -> np.ndarray:
        """Return the way that is beside the route up to an arc length, and returns after it."""
        out = self.way.out_to(to_m, now.s_m, begin_m, now.speed_mps, room_m)
        length_m = shift_length_m(to_m, quick * now.shifts_mps)
        return out * (1.0 - smooth_step(self._road.route.s, until_m, length_m))

    def _wait_m(self, now: Situation) -> float:
        """Return where the car waits before one that it could pass, inf: nowhere [m]."""
        at_rest = now.blocks & (now.others.along_mps < AT_REST_MPS)
        rears_m = [now.rear_m(n) for n in now.passable if at_rest[n]]
        stop_m = min(rears_m, default=math.inf) - self._car.front_m - _WAIT_M
        # A car that has stopped a little too late stays.
        return max(stop_m, now.s_m) if stop_m > now.s_m - _BEFORE_M else math.inf
