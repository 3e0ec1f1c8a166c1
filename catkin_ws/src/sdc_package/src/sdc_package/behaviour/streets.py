"""Where the car stops on streets: at stop signs, for others with right of way, before a jam."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Iterator, Optional, Sequence, Tuple

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.polyline import Place
from sdc_common.geometry.route import Route
from sdc_common.validation import check_non_negative
from sdc_map.crossings import (
    BESIDE_M,
    OVER_M,
    Conflict,
    Crossing,
    crossings,
    heights_along,
    places_along,
    time_s,
)
from sdc_map.network import LanePlace, Network
from sdc_package.behaviour.crosswalks import crosswalks_on
from sdc_package.behaviour.emergency import Motions, meets
from sdc_package.behaviour.forecast import Body
from sdc_package.behaviour.manoeuvres import Manoeuvres, StayOnRoute
from sdc_package.behaviour.road import VEHICLE_M, road_along
from sdc_package.braking import FIRM_MPS2, HARD_MPS2
from sdc_package.obstacle_prediction import Obstacles

STOP_SIGN, RIGHT_OF_WAY, JUNCTION_BLOCKED = "stop_sign", "right_of_way", "junction_blocked"
CROSSWALK = "crosswalk"
# The car has stopped if it was so slow, so close to the place at which it should stop.
_STOPPED_MPS, _STOPPED_WITHIN_M = 0.2, 2.5
# A road user so slow is in a jam; at a junction, one so slow waits; the car can stop at once.
_STANDS_MPS, _WAITS_MPS, _SLOW_MPS = 0.5, 0.4, 3.0
_LANE_M, _CAR_WIDTH_M = 2.5, 2.0
# Road users so far from the stop line, or so much time from it, matter. The third one is the time
# within which one that arrives at the junction has right of way there.
_NEAR_M, _SOON_S, _ARRIVES_S = 40.0, 8.0, 3.5
# Time until the brakes act, and streets/clear_s where the car cannot stop firmly any more [s].
_REACTS_S, _LATE_CLEAR_S = 0.3, 0.4
_NEARER = 0.8  # share of the gap before a crosswalk that the car uses rather than brake hard
_PAST_M = 5.0  # one that drives away from the space that both need is past it after this
# A slow one is expected to be so fast when it enters the junction; one that is slower than the
# second and hardly accelerates still waits, and creeps.
_STARTS_MPS, _CREEPS_MPS, _CREEPS_MPS2, _CREEPING_MPS = 3.0, 1.0, 0.5, 1.5
# One that accelerates by more than the first is expected to go on with at most the second; one that
# brakes, for a time [s].
_STEADY_MPS2, _FASTER_MPS2, _SLOWER_S = 0.3, 2.5, 1.0
# One without right of way that would have to brake harder than this does not give way.
_RUNS_MPS, _RUNS_MPS2, _EMERGENCY_MPS2 = 2.0, 3.2, 6.5
_BRAKES_MPS2 = 1.5  # one that slows down so much brakes
# One that is more oblique than this changes lanes or turns.
_ALONG_RAD = math.radians(50.0)
# One so near to the way of the car, and so little oblique to it, is followed.
_ON_WAY_M, _ON_WAY_RAD = 0.7, math.radians(20.0)
# A pedestrian on a crosswalk is not on the lane.
_ACROSS_RAD = math.radians(60.0)
# A car that may start gives way to those that wait, too, for so many plans (20 a second).
_WAITS, _AT_LINE_M = 30, 5.0

Span = Tuple[float, float]
Times = Tuple[Optional[float], float, float]


@dataclass(frozen=True)
class StreetMargins:
    """Margins of the car at junctions."""

    gap_m: float  # distance between the car's front and the line at which it stops [m]
    follow_gap_m: float  # distance to the one ahead at standstill [m]
    time_gap_s: float  # additional time to the one ahead [s]
    clear_s: float  # time between the car and a road user with right of way at the junction [s]
    hardest_mps2: float  # greatest deceleration for it; a car that cannot stop drives on [m/s^2]
    acceleration_mps2: float  # acceleration with which the car is expected to cross [m/s^2]
    crossing_mps: float  # greatest speed with which it is expected to cross [m/s]
    car_front_m: float  # distance from the car's centre to its front [m]

    def __post_init__(self):
        check_non_negative(**{f"streets/{name}": value for name, value in vars(self).items()})


class StreetBehaviour:
    """Decides where the car stops on its route through a network of streets.

    Rules, with the articles of the Vienna Convention on Road Traffic (1968): stop sign (10.3),
    right of way (18), no stop in a junction (18.3), pedestrians on a crosswalk (21.2).

    Args:
        network: the streets
        margins: margins of the car at junctions
        manoeuvres: decides how far beside its route the car drives: Manoeuvres or StayOnRoute

    Attributes:
        manoeuvres: the decision about the present route, after `follow`
        details: because of whom the car stops, by the reason
        heights_m: (N,) height at the points of the present route, after `follow` [m]
    """

    manoeuvres: StayOnRoute

    def __init__(
        self,
        network: Network,
        margins: StreetMargins,
        manoeuvres: type[StayOnRoute] = Manoeuvres,
    ):
        self._network, self.margins = network, margins
        self._new_manoeuvres = manoeuvres
        # Two decisions of a tick need the place of a road user, and many are at rest.
        self._place_of = lru_cache(256)(
            lambda one: network.nearest(one.x_m, one.y_m, one.yaw_rad, _LANE_M, one.z_m)
        )
        self._crossings: list[Crossing] = []
        self._entered: list[Crossing] = []  # that in which the car cannot stop any more
        self._has_stopped, self._plans_at_line = False, 0
        self._motions = Motions()
        self.details: dict[str, str] = {}

    def follow(self, route: Route, speed_mps: np.ndarray, braking_mps2: float) -> None:
        """Follow another route.

        Args:
            route: the route
            speed_mps: (N,) planned speed at its points [m/s]
            braking_mps2: usual deceleration of the car [m/s^2]

        Raises:
            ValueError: the route is not on lanes of the map; the last one stays
        """
        margins = self.margins
        places = list(places_along(self._network, route))
        if not places:
            raise ValueError(f"the route is not on lanes of the map {self._network.name}")
        self._route, self.heights_m = route, heights_along(self._network, route, places)
        self._crossings, self._entered = crossings(self._network, route, places, speed_mps), []
        self._crosswalks = crosswalks_on(route, self._network.crosswalks)
        self._has_stopped = False
        road = road_along(self._network, route, places, speed_mps)
        lines_m = np.array([crossing.line_m for crossing in self._crossings])
        car = Body(margins.car_front_m, _CAR_WIDTH_M, margins.acceleration_mps2, braking_mps2)
        self.manoeuvres = self._new_manoeuvres(road, lines_m, car)

    def _beside_m(self, place: Place) -> float:
        """Return the distance from the car's way of what is at a place on the route [m]."""
        return abs(place.cross_track_m - self.manoeuvres.way.offset_at(place.s_m))

    def stop(
        self,
        s_m: float,
        speed_mps: float,
        obstacles: Obstacles,
        horizon_m: float,
        red_m: float = math.inf,
    ) -> tuple[float, str] | None:
        """Return where the car's centre must stop, and why; None if it may drive on.

        Args:
            s_m: arc length of the car's centre along the route [m]
            speed_mps: its speed [m/s]
            obstacles: the detected road users
            horizon_m: junctions that begin farther ahead are not looked at [m]
            red_m: where the car already stops for a traffic light, inf: nowhere [m]
        """
        margins, details = self.margins, self.details
        self._motions.update(obstacles)
        for reason in (CROSSWALK, JUNCTION_BLOCKED, RIGHT_OF_WAY):
            details.pop(reason, None)
        soonest_m = s_m + speed_mps**2 / (2.0 * margins.hardest_mps2)
        stops = [self._at_junction(s_m, speed_mps, obstacles, horizon_m, red_m)]
        for one in self._crosswalks:
            stop_m = one.begin_m - margins.car_front_m - margins.gap_m
            is_near = soonest_m - OVER_M <= stop_m + margins.gap_m <= s_m + horizon_m
            if is_near and (user := one.user(self._route, obstacles)):
                details[CROSSWALK] = f"yields to {name_of(user)}"
                nearest_m = stop_m + _NEARER * margins.gap_m
                stop_m = min(nearest_m, max(stop_m, _firm_stop_m(s_m, speed_mps)))
                stops.append((stop_m, CROSSWALK))
                break
        return min(filter(None, stops), default=None)

    def _at_junction(
        self, s_m: float, speed_mps: float, obstacles: Obstacles, horizon_m: float, red_m: float
    ) -> tuple[float, str] | None:
        """Return where the car must stop for the next junction, if it must, and why."""
        while self._crossings and s_m > self._crossings[0].last_stop_m(self.margins.car_front_m):
            self._entered = [self._crossings.pop(0)]
            self._has_stopped, self._plans_at_line = False, 0
        if not self._crossings or self._crossings[0].line_m > s_m + horizon_m:
            return None
        crossing, gap_m = self._crossings[0], self.margins.gap_m
        if red_m < crossing.line_m:
            self._plans_at_line = 0
            return None
        stop_m = crossing.line_m - self.margins.car_front_m - gap_m
        self._has_stopped |= speed_mps < _STOPPED_MPS and stop_m - s_m < _STOPPED_WITHIN_M
        if s_m + speed_mps**2 / (2.0 * self.margins.hardest_mps2) <= stop_m + gap_m:
            if crossing.has_stop_sign and not self._has_stopped:
                return stop_m, STOP_SIGN
            if self._is_blocked(crossing, s_m, obstacles):
                return stop_m, JUNCTION_BLOCKED
        around = obstacles, stop_m, horizon_m
        give_way_m = self._give_way_m(crossing, s_m, speed_mps, *around)
        return None if math.isinf(give_way_m) else (give_way_m, RIGHT_OF_WAY)

    def must_brake_hard(
        self, s_m: float, speed_mps: float, obstacles: Obstacles, horizon_m: float
    ) -> bool:
        """Return whether the car meets one even if it brakes firmly; call it after `stop`."""
        others = self._motions.near(self._route.line.point_at(s_m), speed_mps, obstacles)
        way_m, size = self.manoeuvres.way.offset_m, (self.margins.car_front_m, 0.5 * _CAR_WIDTH_M)
        for share in (1.0, 0.0):  # also if they turn no more
            if len(others):
                others[:, 8] *= share
                others = others[meets(self._route, way_m, s_m, speed_mps, others, *size)]
        for one in (obstacles[int(number)] for number in others[:, 0]):
            if self._comes(one, s_m, (), horizon_m):
                self.details["obstacle"] = name_of(one)
                return True
        return False

    def relevant(
        self, s_m: float, speed_mps: float, obstacles: Obstacles, horizon_m: float
    ) -> Obstacles:
        """Return the obstacles without vehicles that stay on lanes beside the car's way.

        Those that cross in a junction are the matter of `stop`, until the car is slow there.

        Args:
            s_m: arc length of the car's centre along the route [m]
            speed_mps: its speed [m/s]
            obstacles: the detected road users
            horizon_m: length of the route ahead of the car that is searched [m]
        """
        near = self._entered + self._crossings[:1]
        ways = [way for one in near if s_m < one.end_m for way in one.conflicts]
        if speed_mps < _SLOW_MPS:
            ways = [way for way in ways if s_m + self.margins.car_front_m < way.own_m[0]]
        return [one for one in obstacles if self._comes(one, s_m, ways, horizon_m)]

    def _comes(
        self, one: DetectedObstacle, s_m: float, ways: Sequence[Conflict], horizon_m: float
    ) -> bool:
        """Return whether a road user is off the lanes, or is or comes on the way of the car.

        On a bend or in a junction, the lane of a vehicle tells more than its heading where it will
        be. How one goes on that crosses on one of these ways does not matter.
        """
        drives = one.speed_mps >= _STANDS_MPS and one.length_m >= VEHICLE_M
        place = self._place_of(one) if drives else None
        if place is None or abs(place.heading_error_rad) > _ALONG_RAD:
            return True
        line, near_m = self._route.line, horizon_m + 2.0 * one.speed_mps
        away_m = [(way.away_m(self._network, place), way.its_m[1]) for way in ways]
        crosses = any(m is not None and m + to_m > -0.5 * one.length_m for m, to_m in away_m)
        crosses = crosses and not self._is_ahead(one, s_m, horizon_m)
        beside_m = 0.5 * (one.width_m + _CAR_WIDTH_M) + BESIDE_M
        # One that comes obliquely from beside the car cuts in; an oncoming one turns.
        cuts_in = math.cos(one.yaw_rad - line.heading_at(s_m)) > 0.0
        points = [(one.x_m, one.y_m), *(() if crosses else self._ahead(place, one, cuts_in))]
        places = (line.project(x_m, y_m, s_m, 0.0, near_m) for x_m, y_m in points)
        return any(self._beside_m(place) < beside_m for place in places)

    def _ahead(
        self, place: LanePlace, one: DetectedObstacle, cuts_in: bool
    ) -> Iterator[tuple[float, float]]:
        """Yield where a vehicle will be, straight on along the lanes, in the next two seconds."""
        lane, s_m, left_m = self._network.lanes[place.lane], place.s_m, place.cross_track_m
        left_mps = one.speed_mps * math.sin(place.heading_error_rad) if cuts_in else 0.0
        for _ in range(4):
            s_m += 0.5 * one.speed_mps
            left_m += 0.5 * left_mps
            while s_m > lane.length_m and (following := self._network.straight_on(lane)):
                s_m, lane = s_m - lane.length_m, following
            x, y = lane.line.point_at(s_m)
            heading = lane.heading_at(s_m)
            yield x - left_m * math.sin(heading), y + left_m * math.cos(heading)

    def _is_blocked(self, crossing: Crossing, s_m: float, obstacles: Obstacles) -> bool:
        """Return whether a road user stands where the car would leave the junction."""
        until_m = crossing.end_m + 2.0 * self.margins.car_front_m + self.margins.gap_m
        for one in (one for one in obstacles if one.speed_mps <= _STANDS_MPS):
            place = self._route.line.project(one.x_m, one.y_m, s_m, 0.0, until_m - s_m + 10.0)
            rear_m = place.s_m - 0.5 * one.length_m
            if place.distance_m < 0.5 * _LANE_M and crossing.line_m < rear_m < until_m:
                text = f"{name_of(one)} is behind junction {crossing.junction}"
                self.details[JUNCTION_BLOCKED] = text
                return True
        return False

    def _give_way_m(
        self,
        crossing: Crossing,
        s_m: float,
        speed_mps: float,
        obstacles: Obstacles,
        stop_m: float,
        horizon_m: float,
    ) -> float:
        """Return where the car stops for those that it would meet in the junction, inf: nowhere."""
        front_m, line_m = self.margins.car_front_m, crossing.line_m
        most_mps = min(self.margins.crossing_mps, crossing.mean_mps)
        pace = min(speed_mps, crossing.mean_mps), most_mps, self.margins.acceleration_mps2
        begin_s = time_s(line_m - front_m - s_m, *pace)
        firm_m, spaces = _firm_stop_m(s_m, speed_mps), []
        before_m = stop_m + 0.5 * self.margins.gap_m
        stops_before = s_m + speed_mps**2 / (2.0 * HARD_MPS2) <= before_m
        for conflict in crossing.conflicts:
            hardest_mps2 = self.margins.hardest_mps2 if conflict.is_first else _EMERGENCY_MPS2
            soonest_m = s_m + speed_mps**2 / (2.0 * hardest_mps2)
            latest_m = max(line_m, conflict.own_m[0] - BESIDE_M) - front_m
            if soonest_m <= latest_m + OVER_M:
                first_s = time_s(conflict.own_m[0] - front_m - s_m, *pace)
                last_s = time_s(conflict.own_m[1] + front_m - s_m, *pace)
                is_before = conflict.is_first and stops_before
                # For one that runs, it waits as late as it can: most brake late.
                most_m = before_m if is_before else latest_m
                wanted_m = min(most_m, max(stop_m, firm_m)) if conflict.is_first else latest_m
                # One that merges behind the car follows it. Where only a hard stop is possible, it
                # passes closely rather.
                clear_s = self.margins.clear_s if firm_m <= latest_m else _LATE_CLEAR_S
                until_s = first_s + 2.0 * clear_s if conflict.merges else last_s + clear_s
                times_s = begin_s if is_before else None, first_s - clear_s, until_s
                spaces.append((wanted_m, conflict, times_s))
        x, y = self._route.line.point_at(line_m)
        self._plans_at_line += bool(obstacles) and speed_mps < _STANDS_MPS
        starts, nearest_m = 0 < self._plans_at_line <= _WAITS, math.inf
        for one in obstacles if spaces else ():
            near_m, waits = _NEAR_M + _SOON_S * one.speed_mps, one.speed_mps < _WAITS_MPS
            if math.dist((one.x_m, one.y_m), (x, y)) >= near_m or (waits and not starts):
                continue
            place = None if self._is_ahead(one, s_m, horizon_m) else self._place_of(one)
            if place is None or abs(place.heading_error_rad) > _ACROSS_RAD:
                continue
            for wanted_m, conflict, times_s in spaces:
                away_m = conflict.away_m(self._network, place)
                if away_m is None or not (conflict.is_first or self._runs(one, away_m, conflict)):
                    continue
                if waits and not 0.0 <= away_m - 0.5 * one.length_m < _AT_LINE_M:
                    continue
                if wanted_m < nearest_m and self._meet(one, place, away_m, conflict.its_m, times_s):
                    if not waits:
                        self._plans_at_line = 0  # who waits starts after those that pass
                    nearest_m, text = wanted_m, f"yields to {name_of(one)} at junction "
                    self.details[RIGHT_OF_WAY] = text + crossing.junction
        return nearest_m

    def _is_ahead(self, one: DetectedObstacle, s_m: float, horizon_m: float) -> bool:
        """Return whether a road user drives on the way of the car already."""
        place = self._route.line.project(one.x_m, one.y_m, s_m, 0.0, horizon_m)
        turned_rad = math.remainder(one.yaw_rad - place.heading_rad, 2.0 * math.pi)
        is_near = self._beside_m(place) < _ON_WAY_M and abs(turned_rad) < _ON_WAY_RAD
        return is_near and place.s_m > s_m

    def _meet(
        self, one: DetectedObstacle, place: LanePlace, away_m: float, its_m: Span, times_s: Times
    ) -> bool:
        """Return whether a road user, so far from the junction, is too near to the car in time.

        The car enters the junction after a time (None: that does not matter), and needs the space
        of both between the others.
        """
        (its_from_m, its_to_m), (begin_s, from_s, until_s) = its_m, times_s
        half_m = 0.5 * one.length_m
        limit_mps = self._network.lanes[place.lane].speed_limit_mps
        faster_mps2 = min(self._motions.changes(one)[0], _FASTER_MPS2)
        creeps = _WAITS_MPS < one.speed_mps < _CREEPS_MPS and faster_mps2 < _CREEPS_MPS2
        soon_mps = max(one.speed_mps, _CREEPING_MPS if creeps else _STARTS_MPS)
        late_mps = max(one.speed_mps + _SLOWER_S * min(faster_mps2, 0.0), 1.0)

        def passes(from_m: float, until_m: float, begin_s: float, end_s: float) -> bool:
            """Return whether it is between two places of its way at a time."""
            to_m = from_m + away_m - half_m
            enters_s = to_m / soon_mps
            if faster_mps2 > _STEADY_MPS2:
                enters_s = min(enters_s, time_s(to_m, one.speed_mps, limit_mps, faster_mps2))
            leaves_s = (until_m + away_m + half_m) / late_mps
            return enters_s < end_s and leaves_s > max(begin_s, 0.0)

        if passes(its_from_m, its_to_m, from_s, until_s):
            return True
        if begin_s is None:
            return False
        return passes(0.0, its_to_m + _PAST_M, begin_s, begin_s + _ARRIVES_S)

    def _runs(self, one: DetectedObstacle, away_m: float, conflict: Conflict) -> bool:
        """Return whether a road user without right of way will not stop before the junction."""
        brakes = self._motions.changes(one)[0] < -_BRAKES_MPS2
        hardest_mps2, room_m = _RUNS_MPS2, away_m - 0.5 * one.length_m
        if brakes:  # it may stop after its line
            hardest_mps2, room_m = _EMERGENCY_MPS2, room_m + conflict.its_m[0]
        return one.speed_mps > _RUNS_MPS and room_m < one.speed_mps**2 / (2.0 * hardest_mps2)


def _firm_stop_m(s_m: float, speed_mps: float) -> float:
    """Return where a car at an arc length can stop without braking hard [m]."""
    return s_m + _REACTS_S * speed_mps + speed_mps**2 / (2.0 * FIRM_MPS2)


def name_of(obstacle: DetectedObstacle) -> str:
    """Return what the car's reasons call a road user, such as "car 17"."""
    return f"{obstacle.kind or 'obstacle'} {obstacle.id}"
