"""What the referee counts on the streets of a map, besides collisions and red lights.

Near misses follow the surrogate measures of traffic safety: time to collision (J. C. Hayward,
"Near-miss determination through use of a scale of danger", 1972) with constant turn rates, and
post-encroachment time (B. L. Allen et al., "Analysis of traffic conflicts and collisions", 1978)
of paths that cross.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Iterator, NamedTuple, Sequence

from sdc_common.driving import other_level
from sdc_map.network import STOP, Connection, LanePlace, Network, edge_of
from sdc_sim.evaluation.fault import is_at_fault
from sdc_sim.evaluation.lane_rules import EMERGENCY_LASTS_S, YIELD_EMERGENCY, LaneRules, holds_up
from sdc_sim.evaluation.route_progress import DriveSample
from sdc_sim.physics.collision import Rectangle, overlap

NEAR_MISS, RIGHT_OF_WAY, STOP_SIGN = "near_miss", "right_of_way", "stop"
WRONG_LANE, SPEEDING, BLOCKING = "wrong_lane", "speeding", "blocking"

_NEAR_S = 1.0  # least time to collision, and between two bodies on the same place
_STEP_S = 0.1  # step of the prediction
_AGAIN_S = 2.0  # a near miss with the same road user counts again after this time
_CROSSING_RAD = math.radians(30.0)  # paths with a smaller angle follow each other
_ARRIVES_S = 2.0  # the car takes the right of way of a road user that arrives within this time
_MOVING_MPS = 1.0
_STOPPED_MPS = 0.3  # a slower car has stopped
_AT_LINE_M = 4.0  # a stop counts within this distance before the line of a sign
_AGAINST_RAD = math.radians(120.0)  # least angle to the lane of a car that drives against it
_ALONG_RAD = math.radians(60.0)  # greatest angle to the lane of a road user that drives along it
_TOLERANCE_MPS = 1.0  # above the speed limit
# Times after which wrong lane, speeding, and standing in a junction count [s].
_LASTS_S = {WRONG_LANE: 1.0, SPEEDING: 1.0, BLOCKING: 5.0, YIELD_EMERGENCY: EMERGENCY_LASTS_S}
_CAR_WIDTH_M = 1.9
_PASSED_M = (-40.0, 60.0)  # limits of the distance ahead of a road user that the car passes
_BESIDE_M = (-2.0, 12.0)  # limits of its distance from the car towards the edge of the road
_LANE_M = 2.5  # lanes are searched within this distance
_SAME_WAY_M = 1.0  # a body within this distance of a way that does not cross it drives along it
# An odometry without road users at its time waits for this many later ones: a world without road
# users reports that once a second.
_MOST_WAITING = 40


class RoadUser(NamedTuple):
    """The car, whose id is 0, or another road user: outline on the ground, speed, and kind."""

    id: int
    body: Rectangle
    speed_mps: float
    kind: str = ""


class StreetRules:
    """Watches a car, whose front is so far from its centre, on a network of streets."""

    def __init__(self, network: Network, car_front_m: float):
        self._network, self._front_m = network, car_front_m
        self._lane_rules = LaneRules(network)
        self._place: LanePlace | None = None
        self._slowest_mps = math.inf
        # The lane from which the car has entered a junction, and the edges to which it has taken
        # the right of way there.
        self._entered = ""
        self._taken: set[str] = set()
        self._since_s: dict[str, float] = {}
        # Times at which the car was on a lane, in its direction or around another road user [s].
        self.on_lane_s: set[float] = set()
        self._has_joined = False  # a drive may begin beside the lanes, such as in a parking bay
        self._seen_s: dict[int, float] = {}
        # The last second of each road user by its id, 0 is the car.
        self._trails: dict[int, deque[tuple[float, RoadUser]]] = {}
        self._cars: deque[tuple[int, DriveSample, float]] = deque()
        self._others: dict[int, Sequence] = {}
        self._others_ns = 0

    def add_car(
        self, stamp_ns: int, sample: DriveSample, z_m: float = math.nan
    ) -> list[tuple[str, DriveSample]]:
        """Add an odometry and its height [m]; return the infractions that are complete."""
        self._cars.append((stamp_ns, sample, z_m))
        return self._judge()

    def add_others(self, stamp_ns: int, rows: Sequence) -> list[tuple[str, DriveSample]]:
        """Add the other road users at the time of an odometry.

        Args:
            stamp_ns: stamp of the odometry
            rows: for each road user its id, the fields of its outline, its speed, and its kind
        """
        self._others[stamp_ns] = rows
        self._others_ns = max(stamp_ns, self._others_ns)
        return self._judge()

    def is_at_fault(self, other: int, time_s: float) -> bool:
        """Return whether the car is at fault for a collision with a road user at this time [s]."""
        trails = self._trails.get(0, ()), self._trails.get(other, ()) if other else ()
        before = ([moment for moment in trail if moment[0] < time_s] for trail in trails)
        return is_at_fault(self._network, *before)

    def _judge(self) -> list[tuple[str, DriveSample]]:
        """Judge the odometries for which the others are known, or which have waited too long."""
        found = []
        cars, others = self._cars, self._others
        while cars and (cars[0][0] <= self._others_ns or len(cars) > _MOST_WAITING):
            stamp_ns, sample, z_m = cars.popleft()
            around = [
                RoadUser(number, Rectangle(*body), speed_mps, kind)
                for number, *body, speed_mps, kind in others.get(stamp_ns, ())
            ]
            found += [(name, sample) for name in self._update(sample, z_m, around)]
            others = self._others = {ns: rows for ns, rows in others.items() if ns > stamp_ns}
        return found

    def _update(self, sample: DriveSample, z_m: float, everyone: Sequence[RoadUser]) -> list[str]:
        time_s, x_m, y_m, yaw_rad, speed_mps, *_ = sample
        body = Rectangle(x_m, y_m, yaw_rad, 2.0 * self._front_m, _CAR_WIDTH_M, z_m)
        car = RoadUser(0, body, speed_mps)
        # A road user that comes to a junction on a slope is on another level for a while.
        others = [user for user in everyone if not other_level(user.body.z_m, z_m)]
        found = [NEAR_MISS] * self._near_misses(time_s, car, others)
        self._remember(time_s, [car, *everyone])
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        front_m = x_m + self._front_m * c, y_m + self._front_m * s
        place = self._network.nearest(*front_m, yaw_rad, _LANE_M, z_m)
        found += self._at_junctions(car, place, everyone)
        self._place = place
        nearest = self._network.nearest(x_m, y_m, within_m=_LANE_M, z_m=z_m)
        is_against = self._is_against(body, nearest) and not self._passes(car, others)
        self._has_joined |= nearest is not None
        if not (self._has_joined and (nearest is None or is_against)):
            self.on_lane_s.add(time_s)
        found += self._lane_rules.update(
            time_s,
            car,
            nearest,
            others,
            lambda: self._passes(car, [user for user in others if user.speed_mps < _MOVING_MPS]),
        )
        for name, holds in self._conditions(car, place, is_against, others):
            since_s = self._since_s.setdefault(name, time_s) if holds else None
            if since_s is None:
                self._since_s.pop(name, None)
            elif time_s - since_s >= _LASTS_S[name]:
                self._since_s[name] = math.inf  # until the condition ends
                found.append(name)
        return found

    def _conditions(
        self,
        car: RoadUser,
        place: LanePlace | None,
        is_against: bool,
        others: Sequence[RoadUser],
    ) -> Iterator[tuple[str, bool]]:
        """Yield what counts if it lasts."""
        lane = self._network.lanes[place.lane] if place else None
        limit_mps = lane.speed_limit_mps if lane else math.inf
        yield SPEEDING, car.speed_mps > limit_mps + _TOLERANCE_MPS
        in_junction = bool(lane and lane.junction)
        yield BLOCKING, in_junction and car.speed_mps < _STOPPED_MPS
        yield WRONG_LANE, car.speed_mps > _MOVING_MPS and is_against
        yield YIELD_EMERGENCY, holds_up(car, others)

    def _is_against(self, body: Rectangle, place: LanePlace | None) -> bool:
        """Return whether a body on this lane drives against its direction."""
        if place is None or self._network.lanes[place.lane].junction:
            return False
        lane = self._network.lanes[place.lane]
        turned = math.remainder(body.yaw_rad - lane.heading_at(place.s_m), 2.0 * math.pi)
        return abs(turned) > _AGAINST_RAD

    def _passes(self, car: RoadUser, others: Sequence[RoadUser]) -> bool:
        """Return whether the car is beside a slower road user at the edge of the road."""
        x_m, y_m, yaw_rad = car.body[:3]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        for user in others:
            dx, dy = user.body.x_m - x_m, user.body.y_m - y_m
            along_m, edge_m = c * dx + s * dy, self._network.y_sign * (s * dx - c * dy)
            beside = _PASSED_M[0] < along_m < _PASSED_M[1] and _BESIDE_M[0] < edge_m < _BESIDE_M[1]
            along_mps = user.speed_mps * math.cos(user.body.yaw_rad - yaw_rad)
            if beside and -_MOVING_MPS < along_mps < car.speed_mps + _MOVING_MPS:
                return True
        return False

    def _at_junctions(
        self, car: RoadUser, place: LanePlace | None, others: Sequence[RoadUser]
    ) -> list[str]:
        """Return what the car has done wrong where its front enters or leaves a junction."""
        found: list[str] = []
        last = self._place
        if place is None or last is None or place.lane == self._entered:
            return found  # at the end of the lane, the nearest one may change to and fro
        lanes = self._network.lanes
        junction, ways = lanes[place.lane].junction, self._network.ways.get(last.lane, [])
        if ways and ways[0].junction == junction and last.lane != self._entered:
            self._entered = last.lane
            signs = [way.line == STOP and way.signal < 0 for way, _, _ in ways]
            if any(signs) and self._slowest_mps > _STOPPED_MPS:
                found.append(STOP_SIGN)
            arriving = list(self._along_lanes(others))
            self._taken = {
                edge_of(way.end)
                for way, priors, _ in ways
                if any(self._arrives(*pair, prior, way) for pair in arriving for prior in priors)
            }
        elif not junction:
            if lanes[last.lane].junction and edge_of(place.lane) in self._taken:
                found.append(RIGHT_OF_WAY)
            self._entered, self._taken = "", set()
        if place.lane != last.lane:
            self._slowest_mps = math.inf
        if lanes[place.lane].length_m - place.s_m < _AT_LINE_M:
            self._slowest_mps = min(self._slowest_mps, car.speed_mps)
        return found

    def _along_lanes(self, users: Sequence[RoadUser]) -> Iterator[tuple[RoadUser, LanePlace]]:
        """Yield the moving road users that drive along a lane, and their places."""
        for user in users:
            if user.speed_mps > _MOVING_MPS:
                place = self._network.nearest(*user.body[:3], _LANE_M, user.body.z_m)
                # A pedestrian on a crosswalk is across the lane.
                if place and abs(place.heading_error_rad) < _ALONG_RAD:
                    yield user, place

    def _arrives(self, user: RoadUser, place: LanePlace, way: Connection, own: Connection) -> bool:
        """Return whether a road user is on a way before that of the car, or soon will be."""
        lane_m = self._network.lanes[place.lane].length_m
        if place.lane == way.start:
            return lane_m - place.s_m - 0.5 * user.body.length_m < _ARRIVES_S * user.speed_mps
        if place.lane not in way.through or self._is_on(user.body, own):
            return False
        before = way.through[: way.through.index(place.lane)]
        rear_m = sum(self._network.lanes[name].length_m for name in before)
        rear_m += place.s_m - 0.5 * user.body.length_m
        return rear_m < self._network.clear_m(way, own)

    def _is_on(self, body: Rectangle, way: Connection) -> bool:
        """Return whether a body drives along a way through a junction, where two overlap, too."""
        places = (self._network.lanes[name].line.nearest(*body[:2]) for name in way.through)
        return any(
            place.distance_m < _SAME_WAY_M
            and math.cos(body.yaw_rad - place.heading_rad) > math.cos(_CROSSING_RAD)
            for place in places
        )

    def _near_misses(self, time_s: float, car: RoadUser, others: Sequence[RoadUser]) -> int:
        """Return with how many road users a near miss begins."""
        near = [user for user in others if self._is_within_reach(car, user)]
        ahead, begun = list(self._way_ahead(car)) if near else [], 0
        for user in near:
            meet = any(map(overlap, ahead, self._way_ahead(user)))
            if meet or self._have_crossed(car, user):
                begun += time_s - self._seen_s.get(user.id, -math.inf) > _AGAIN_S
                self._seen_s[user.id] = time_s
        return begun

    def _is_within_reach(self, car: RoadUser, user: RoadUser) -> bool:
        car_body, body = car.body, user.body
        reach_m = car_body.length_m + body.length_m + _NEAR_S * (car.speed_mps + user.speed_mps)
        return math.dist(car_body[:2], body[:2]) <= reach_m

    def _way_ahead(self, user: RoadUser) -> Iterator[Rectangle]:
        """Yield the outlines of the next second at constant speed and turn rate."""
        trail, rate = self._trails.get(user.id), 0.0
        if trail and len(trail) > 1:
            (before_s, before), (last_s, last) = trail[-2], trail[-1]
            turned = math.remainder(last.body.yaw_rad - before.body.yaw_rad, 2.0 * math.pi)
            rate = turned / max(last_s - before_s, 1e-3)
        x, y, yaw, *size = user.body
        for _ in range(round(_NEAR_S / _STEP_S)):
            middle = yaw + 0.5 * _STEP_S * rate
            x += _STEP_S * user.speed_mps * math.cos(middle)
            y += _STEP_S * user.speed_mps * math.sin(middle)
            yaw += _STEP_S * rate
            yield Rectangle(x, y, yaw, *size)

    def _have_crossed(self, car: RoadUser, user: RoadUser) -> bool:
        """Return whether the car or the user is where the other was in the last second."""
        car_body, body = car.body, user.body
        angle = abs(math.remainder(car_body.yaw_rad - body.yaw_rad, 2.0 * math.pi))
        if not _CROSSING_RAD < angle < math.pi - _CROSSING_RAD:
            return False
        return any(overlap(body, past.body) for _, past in self._trails.get(0, ())) or any(
            overlap(car_body, past.body) for _, past in self._trails.get(user.id, ())
        )

    def _remember(self, time_s: float, everyone: Sequence[RoadUser]) -> None:
        trails = {}
        for user in everyone:
            trail = trails[user.id] = self._trails.get(user.id) or deque()
            trail.append((time_s, user))
            while time_s - trail[0][0] > _NEAR_S:
                trail.popleft()
        self._trails = trails
