"""Scenario types on the streets of a map: where one happens, and who is there.

config/street_scenarios.yaml is the table of the types, and describes its keys. A seed draws the
place among those of the map that fit, and each number that is a pair (least, greatest).
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Iterator, Mapping, NamedTuple

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate, smooth_step
from sdc_common.validation import suggestion
from sdc_map.lane_graph import LaneGraph, NoRouteError
from sdc_map.mirror import negated
from sdc_map.mission import plan_mission
from sdc_map.network import BROKEN, STOP, YIELD, Connection, Network, RoadLane, left_normals
from sdc_map.network_file import load_network
from sdc_sim.physics.obstacles import KINDS
from sdc_sim.physics.traffic_lights import COLOURS
from sdc_sim.traffic.actors import Actor
from sdc_sim.traffic.lights import lights_of
from sdc_sim.yaml_document import packaged_config

_BACK_M = 160.0  # length of the way of a road user before the event
_ON_M = 220.0  # length of the way of a road user after the event
_SINK = 80  # points, 1 m apart, of the way of a flow after it meets the car
_SEEN_S = 4.0  # least time that a vehicle of a flow drives to the junction
_LEAST_M = 42.0  # least way before and after the event without a further junction
_MARGIN_M = 5.0  # least distance to the end of a lane
_MOST_M = 420.0  # length of the longest mission
_TRIES = 6  # places on each stretch
_LOOK_BACK_M = 35.0  # length of the street before the event that is searched for bends
_LOOK_ON_M = 25.0  # length of the street after the event that is searched for bends
_ONCOMING_M = 2.0  # greatest distance of an oncoming lane beside a lane
_ONCOMING_RAD = math.radians(25.0)  # greatest angle of an oncoming lane to the opposite direction
_MEET_M = 1.5  # two ways meet within this distance
_CAR_MPS = 12.0  # speed with which the car is expected to reach the event: the limit of a street
_CAR_MPS2 = 1.8  # acceleration with which the car is expected to start
# From when until when, after the car comes, a light must have its colour [s].
_LIGHT_S = {"green": (-6.0, 8.0), "red": (-8.0, 3.0)}
_CROSSWALK_M = 5.0  # a crosswalk within this distance of the way is on it
_BEHIND_LINE_M = 30.0  # greatest distance of a crosswalk to the event
_SIDE_RAD = math.radians(50.0)  # tolerance of the direction from which a road user comes
_NO_WAY = "a road user has no way here"
_SIDES = {"opposite": math.pi, "left": -0.5 * math.pi, "right": 0.5 * math.pi, "along": 0.0}
# Parameters that are positive to the left, or from the left.
_TO_THE_LEFT = ("left_m", "turned_rad", "side_wind_mps")
_graph = lru_cache(maxsize=2)(LaneGraph)
_LIMIT_RATIO = 3.0  # time limit as a multiple of the time at the speed limits
_LIMIT_S = 40.0  # constant part of the time limit
_DRAWS = 20  # attempts to draw a place at which all road users have a route


class _Site(NamedTuple):
    """A place at which a type may happen."""

    lane: RoadLane  # the lane of the event
    s_m: float  # the event on it [m]
    goal: tuple[RoadLane, float]  # place from which the way leads on to the goal
    way: Connection | None = None  # the way through the junction at the end of the lane
    start: RoadLane | None = None  # the lane of the start, None for that of the event


@dataclass(frozen=True)
class Placement:
    """A scenario type at a place."""

    start: tuple[float, float]  # where the car begins [m]
    goals: list[tuple[float, float]]  # where it drives to [m]
    mission_m: np.ndarray = field(repr=False)  # (N, 2) its way [m]
    event_m: tuple[float, float]  # where it happens [m]
    actors: tuple[Actor, ...] = field(repr=False)
    lights_s: float  # time by which the programs of all lights are ahead [s]
    parameters: dict[str, Any]  # of config/sim.yaml that the type sets
    limit_s: float  # the drive should be over by then [s]


def types() -> dict[str, dict[str, Any]]:
    """Return the table of the types by their names."""
    return packaged_config("street_scenarios")["types"]


def place(name: str, network: Network, seed: int) -> Placement:
    """Return a type at a place of the map; equal arguments give an equal placement.

    Raises:
        ValueError: there is no such type, or no place for it
    """
    table = types()
    if name not in table:
        fix = suggestion(name, table, f"the types are {', '.join(sorted(table))}")
        raise ValueError(f"street_scenario: unknown type '{name}'; {fix}")
    row, draw, right_hand = table[name], random.Random(f"{name} {seed}"), network.right_hand
    for _ in range(_DRAWS):
        found = list(_sites(right_hand, row["place"], draw))
        draw.shuffle(found)
        for site in found:
            try:
                placement = _Placer(row, right_hand, site, draw).placement()
                return _mirrored(placement) if network.y_sign < 0.0 else placement
            except NoRouteError:
                continue
    raise ValueError(
        f"street_scenario: the map {network.name} has no place for {name}; "
        "choose another type or map, such as map:=town"
    )


def _mirrored(placed: Placement) -> Placement:
    """Return the mirror image of a type on streets with traffic on the right."""
    flip = np.array([1.0, -1.0])
    # Vehicles of a flow share their way.
    paths_m = {id(actor.path_m): actor.path_m * flip for actor in placed.actors}
    return replace(
        placed,
        start=(placed.start[0], -placed.start[1]),
        goals=[(x, -y) for x, y in placed.goals],
        mission_m=placed.mission_m * flip,
        event_m=(placed.event_m[0], -placed.event_m[1]),
        actors=tuple(
            replace(negated(actor, "turned_rad"), path_m=paths_m[id(actor.path_m)])
            for actor in placed.actors
        ),
        parameters={key: _mirrored_value(key, value) for key, value in placed.parameters.items()},
    )


def _mirrored_value(name: str, value: Any) -> Any:
    """Return a parameter of config/sim.yaml in the mirror."""
    if isinstance(value, dict):
        return {key: _mirrored_value(key, item) for key, item in value.items()}
    return -value if name in _TO_THE_LEFT else value


def of_map(path: str, name: str, seed: int) -> Placement:
    """Return a type at a place of a map; see `place`."""
    return place(name, load_network(path), seed)


def _drawn(value: Any, draw: random.Random) -> Any:
    """Return a number between a pair of numbers, one of a list of words, or the value itself."""
    if isinstance(value, list) and value and isinstance(value[0], str):
        return draw.choice(value)
    is_pair = isinstance(value, list) and len(value) == 2 and not isinstance(value[0], list)
    return draw.uniform(*value) if is_pair else value


def _reach_s(distance_m: float, speed_mps: float, acceleration_mps2: float) -> float:
    """Return the time in which a road user at rest drives a distance [s]."""
    until_m = speed_mps**2 / (2.0 * acceleration_mps2)
    if distance_m < until_m:
        return math.sqrt(2.0 * max(distance_m, 0.0) / acceleration_mps2)
    return speed_mps / acceleration_mps2 + (distance_m - until_m) / speed_mps


class _Placer:
    """Places one type at one site; a road user that has no way here raises NoRouteError."""

    def __init__(self, row: Mapping[str, Any], network: Network, site: _Site, draw: random.Random):
        self._row, self._network, self._site, self._draw = row, network, site, draw
        where = row["place"]
        before_m = _drawn(where.get("before_m", [80.0, 115.0]), draw)
        after_m = _drawn(where.get("after_m", [70.0, 110.0]), draw)
        begin, least_m = site.start or site.lane, where.get("least_m", _LEAST_M)
        self._start = _walk(network, begin, site.s_m, before_m, False, least_m)
        self._goal = _walk(network, *site.goal, after_m, True)
        self._mission = plan_mission(_graph(network), [self._goal], *self._start)
        core = site.way.through[:1] if site.way else (site.lane.id, site.goal[0].id)
        if not {*core} <= {*self._mission.lanes} or self._mission.ends_m[-1] > _MOST_M:
            raise NoRouteError(_NO_WAY)  # or one that leads around a block
        lanes = self._mission.lanes  # those until the event are the car's own
        self._own = lanes[: lanes.index(site.lane.id) + 1] if site.lane.id in lanes else lanes[:1]
        self._mission_m = self._mission.points_m
        self._line = Polyline(self._mission_m.tolist())
        event_m = site.lane.at(np.array([site.s_m]))[0]
        if where.get("event") == "exit" and site.way:
            event_m = network.lanes[site.way.end].points_m[0]
        self._event_at_m = self._line.nearest(*event_m.tolist()).s_m
        if where.get("event") == "crosswalk":
            centres = (polygon.mean(axis=0).tolist() for polygon in network.crosswalks)
            places = (self._line.nearest(*centre) for centre in centres)
            near = [place.s_m for place in places if place.distance_m < _CROSSWALK_M]
            near = [s for s in near if abs(s - self._event_at_m) < _BEHIND_LINE_M]
            if not near:
                raise NoRouteError(_NO_WAY)
            self._event_at_m = near[0]

    def placement(self) -> Placement:
        """Return the placement."""
        row = self._row
        groups = (group if isinstance(group, list) else [group] for group in row.get("actors", ()))
        has_light = "light" in row and self._site.way and self._site.way.signal >= 0
        return Placement(
            self._start,
            [self._goal],
            self._mission_m,
            self._line.point_at(self._event_at_m),
            tuple(actor for group in groups for entry in group for actor in self._actors(entry)),
            self._lights_s(row["light"]) if has_light else 0.0,
            {key: _drawn(value, self._draw) for key, value in row.get("parameters", {}).items()},
            _LIMIT_S + _LIMIT_RATIO * self._mission.time_s + row.get("extra_s", 0.0),
        )

    def _lights_s(self, colour: str) -> float:
        """Return the time by which the lights must be ahead, so that the car meets a colour."""
        end = self._site.lane.points_m[-1]
        comes_s = _reach_s(self._event_at_m, _CAR_MPS, _CAR_MPS2)
        times_s = comes_s + np.arange(*_LIGHT_S[colour], 0.5)
        for light in lights_of(self._network):
            cycle_s = round(sum(seconds for _, seconds in light.phases))
            if math.dist((light.x_m, light.y_m), end) < 1.0:
                for ahead_s in self._draw.sample(range(cycle_s), cycle_s):
                    states = {light.state(moment) for moment in (times_s + ahead_s).tolist()}
                    if states == {COLOURS.index(colour)}:
                        return float(ahead_s)
        raise NoRouteError(_NO_WAY)

    def _way(self, way: Any) -> tuple[np.ndarray, float, float, float]:
        """Return a way, where on it and on the mission they meet, and where its line is [m]."""
        network, site, line_m = self._network, self._site, 0.0
        if isinstance(way, dict):
            points, line_m = self._through(way)
        elif way == "ahead":
            first, last = (network.lanes[self._mission.lanes[end]] for end in (0, -1))
            parts = _chain(network, first, on_m=0.0), _chain(network, last, back_m=0.0)
            ends = self._mission_m[0], self._mission_m[-1]
            back, on = (np.argmin(np.hypot(*(part - end).T)) for part, end in zip(parts, ends))
            if back < self._row["place"].get("behind_m", 0.0):  # points are 1 m apart
                raise NoRouteError(_NO_WAY)
            points = np.vstack([parts[0][: max(back - 1, 0)], self._mission_m, parts[1][on + 2 :]])
            points = _even(points)
        else:
            at_m = min(site.s_m, site.lane.length_m - 1.0)
            beside = _oncoming_lane(network, site.lane, at_m) if way == "oncoming" else None
            beside = beside or network.lanes.get(getattr(site.lane, way, ""))
            if beside is None:
                raise NoRouteError(_NO_WAY)
            points = _chain(network, beside, own=self._own)
        line, at_m = Polyline(points.tolist()), self._event_at_m
        if isinstance(way, dict):
            after = self._mission_m[max(round(at_m) - 3, 0) :][:60]
            apart = np.hypot(*(after[:, None] - points).transpose(2, 0, 1)).min(axis=1)
            if apart.min() > _MEET_M:
                raise NoRouteError(_NO_WAY)
            at_m = self._line.nearest(*after[np.argmax(apart < _MEET_M)].tolist()).s_m
        return points, line.nearest(*self._line.point_at(at_m)).s_m, at_m, line_m

    def _through(self, way: Mapping[str, str]) -> tuple[np.ndarray, float]:
        """Return the points of another way through the junction, and where its line is [m]."""
        network, lane, own = self._network, self._site.lane, self._site.way
        (own_way,) = (option for option in network.ways[lane.id] if option.connection is own)
        wanted = lane.heading_at(lane.length_m) + _SIDES[way["from"]]
        for connection in network.junctions[own_way.junction].connections:
            start = network.lanes[connection.start]
            turned = math.remainder(start.heading_at(start.length_m) - wanted, 2.0 * math.pi)
            fits = connection.direction.lower() in way["turn"] and start is not lane
            is_first = connection in own_way.first
            fits = fits and way.get("first", is_first) == is_first
            if fits and abs(turned) < _SIDE_RAD:
                before = _chain(network, start, on_m=0.0, own=self._own)
                after = _chain(network, network.lanes[connection.end], back_m=0.0, own=self._own)
                inside = [network.lanes[name].points_m for name in connection.through]
                return _even(np.vstack([before, *inside, after])), float(arc_lengths(before)[-1])
        raise NoRouteError(_NO_WAY)

    def _across(self, row: Mapping[str, Any]) -> tuple[np.ndarray, float, float, float]:
        """Return a line across the mission; see `_way`."""
        at_m = self._event_at_m + row.get("along_m", 0.0)
        (x, y), yaw = self._line.point_at(at_m), self._line.direction_at(at_m)
        left = np.array([-math.sin(yaw), math.cos(yaw)])
        from_m = row.get("from_m", row.get("at_m", 0.0))
        points = np.array([[x, y] + side_m * left for side_m in (from_m, row.get("to_m", 7.0))])
        return points, -from_m, at_m, 0.0

    def _actors(self, row: Mapping[str, Any]) -> Iterator[Actor]:
        """Yield the road users of a row of the table."""
        draw = self._draw
        row = {key: value if key == "kind" else _drawn(value, draw) for key, value in row.items()}
        way = row["way"]
        if isinstance(way, dict):
            way = {key: _drawn(value, draw) for key, value in way.items()}
        points, s_m, meets_m, line_m = self._across(row) if way == "across" else self._way(way)
        limit_mps = self._site.lane.speed_limit_mps if row.get("of_limit") else 1.0
        speed, at_m = row.get("mps", 0.0) * limit_mps, row.get("at_m", 0.0)
        if "from_start_m" in row:
            at_m = row["from_start_m"] - self._event_at_m
        elif "from_line_m" in row:
            at_m = line_m - row["from_line_m"] - s_m
        elif "comes_s" in row:
            at_m = -speed * (_reach_s(meets_m, _CAR_MPS, _CAR_MPS2) + row["comes_s"])
        drawn = ([_drawn(number, draw) for number in step] for step in row.get("steps", ()))
        steps = tuple((after_s, mps * limit_mps, rate) for after_s, mps, rate in drawn)
        same: dict[str, Any] = {
            key: row[key] for key in ("within_m", "within_s", "looks") if key in row
        }
        if "meets_s" in row:
            meets_s = row["meets_s"] + _reach_s(-at_m, *steps[0][1:])
            near_m = row.get("meets_mps", 0.0) * meets_s
            same.update({"within_m": near_m} if near_m else {"within_s": meets_s})
        same["at_m"] = meets_m if {"within_m", "within_s"} & {*same} else math.inf
        same["turned_rad"] = math.radians(row.get("turned_deg", 0.0))
        same["gaps_s"] = gaps_s = row.get("gaps_s", ())
        if gaps_s and isinstance(way, dict):
            if line_m < _SEEN_S * speed:
                raise NoRouteError(_NO_WAY)
            points = points[: round(s_m) + _SINK]
        points, start_m = _shifted(points, s_m + at_m, row)
        for number in range(row.get("count", 1)):
            kind = _drawn(row["kind"], draw)
            size_m: Any = row.get("size_m", KINDS[kind].size_m)
            yield Actor(kind, points, start_m, size_m, speed, steps, **same)
            gap_s = draw.uniform(*gaps_s[number % len(gaps_s)]) if gaps_s else 0.0
            start_m -= size_m[0] + gap_s * speed + row.get("gap_m", 0.0)


def _shifted(
    points: np.ndarray, start_m: float, row: Mapping[str, Any]
) -> tuple[np.ndarray, float]:
    """Return a way beside a way, and a start on it; behind it, the distance beside may change."""
    left_m, s = row.get("left_m", 0.0), arc_lengths(points)
    change = smooth_step(s, start_m, row.get("over_m", 1.0))
    change *= row.get("to_left_m", left_m) - left_m
    beside = points + (left_m + change)[:, None] * left_normals(points)
    return beside, start_m + float(np.interp(start_m, s, arc_lengths(beside) - s))


def _sites(network: Network, where: Mapping[str, Any], draw: random.Random) -> Iterator[_Site]:
    """Yield the places of a kind, see config/street_scenarios.yaml."""
    least, most = (kmh / 3.6 for kmh in where.get("limit_kmh", (20, 70)))
    for lane in network.driving:
        if lane.junction or not least <= lane.speed_limit_mps + 0.1 <= most + 0.2:
            continue
        if where["at"] == "junction":
            yield from _junction_sites(network, lane, where)
        elif where["at"] == "stretch":
            yield from _stretch_sites(network, lane, where, draw)
        elif bool(lane.predecessors) != bool(lane.successors) and lane.left:
            yield from _lane_end_sites(network, lane, where)


def _junction_sites(network: Network, lane: RoadLane, where: Mapping[str, Any]) -> Iterator[_Site]:
    """Yield the ways from a lane through a junction of the kind."""
    for way, _, name in network.ways.get(lane.id, ()):
        has_sign = way.signal < 0 and way.line in (STOP, YIELD)
        control = way.line if has_sign else network.junctions[name].kind
        fits = control in where["control"] and way.direction.lower() in where["turn"]
        if fits and len(network.junctions[name].connections) >= where.get("ways", 3):
            yield _Site(lane, lane.length_m, (network.lanes[way.end], 0.0), way)


def _stretch_sites(
    network: Network, lane: RoadLane, where: Mapping[str, Any], draw: random.Random
) -> Iterator[_Site]:
    """Yield drawn places on a lane that have the neighbours and bends of the kind."""
    last_m = lane.length_m - where.get("end_m", 20.0)
    for _ in range(_TRIES):
        s_m = draw.uniform(_LEAST_M + _MARGIN_M, max(last_m, _LEAST_M))
        if s_m < last_m and _is_street(network, lane, s_m, where):
            yield _Site(lane, s_m, (lane, s_m))


def _lane_end_sites(network: Network, lane: RoadLane, where: Mapping[str, Any]) -> Iterator[_Site]:
    """Yield a lane that ends, from which the car changes, or one that begins, to which it does."""
    beside = network.lanes[lane.left]
    far = network.lanes.get(beside.left) if where.get("changes", 1) == 2 else beside
    if far and where["at"] == "merge" and lane.predecessors:
        yield _Site(lane, 0.0, (far, far.length_m))
    elif far and where["at"] == "exit" and lane.successors:
        yield _Site(lane, 0.0, (lane, lane.length_m), start=far)


def _is_street(network: Network, lane: RoadLane, s_m: float, where: Mapping[str, Any]) -> bool:
    """Return whether a stretch has the neighbours and bends of a place."""
    if where.get("right", False) != bool(lane.right):
        return False
    ends = s_m - _LOOK_BACK_M, min(s_m + _LOOK_ON_M, lane.length_m)
    bend = np.unwrap([lane.line.direction_at(s) for s in np.arange(*ends, 2.0).tolist()])
    least, most = where.get("bend_deg", (0.0, 8.0))
    if not least <= np.degrees(np.ptp(bend)) <= most:
        return False
    may_cross = lane.left_marking == BROKEN and _oncoming_lane(network, lane, s_m)
    left = "same" if lane.left else "oncoming" if may_cross else "none"
    return bool(where.get("left", left) == left)


def _oncoming_lane(network: Network, lane: RoadLane, s_m: float) -> RoadLane | None:
    """Return the lane of the other direction beside a place on a lane."""
    pose = *lane.at(np.array([s_m]))[0].tolist(), lane.heading_at(s_m)
    return network.oncoming_lane(lane, pose, _ONCOMING_M, _ONCOMING_RAD)


def _next(network: Network, lane: RoadLane, ahead: bool) -> RoadLane | None:
    """Return the lane after this one, or before it up to the last light, that turns least."""
    if ahead:
        return network.straight_on(lane)
    lit = {name for name, junction in network.junctions.items() if junction.phases}
    before = [network.lanes[name] for name in lane.predecessors]
    before = [approach for approach in before if approach.junction not in lit]
    turns = [approach.heading_at(approach.length_m) - lane.heading_at(0.0) for approach in before]
    turns = [abs(math.remainder(turn, 2.0 * math.pi)) for turn in turns]
    return before[turns.index(min(turns))] if before else None


def _walk(
    network: Network,
    lane: RoadLane,
    s_m: float,
    far_m: float,
    ahead: bool,
    least_m: float = _LEAST_M,
) -> tuple[float, float]:
    """Return the point so far ahead or back, before the next junction if it is far enough."""
    room_m = lane.length_m - s_m if ahead else s_m
    while lane.junction or (room_m < far_m and room_m < least_m + _MARGIN_M):
        following = _next(network, lane, ahead)
        if following is None:
            raise NoRouteError(_NO_WAY)
        lane, room_m = following, room_m + following.length_m
    rest_m = max(room_m - far_m, _MARGIN_M)
    x, y = lane.line.point_at(lane.length_m - rest_m if ahead else rest_m)
    return round(x, 3), round(y, 3)


def _chain(
    network: Network, lane: RoadLane, own: Any = (), back_m: float = _BACK_M, on_m: float = _ON_M
) -> np.ndarray:
    """Return the points of the way straight on over a lane, until it comes to lanes of the car."""
    lanes = [lane]
    for ahead, far_m in ((False, back_m), (True, on_m)):
        while far_m > 0.0:
            following = _next(network, lanes[-1 if ahead else 0], ahead)
            if following is None or following.id in own:
                break
            lanes.insert(len(lanes) if ahead else 0, following)
            far_m -= following.length_m
    return _even(np.vstack([part.points_m for part in lanes]))


def _even(points: np.ndarray) -> np.ndarray:
    """Return points about 1 m apart along a line."""
    points = points[np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-3)]
    s = arc_lengths(points)
    return interpolate(np.linspace(0.0, s[-1], max(2, round(s[-1]) + 1)), s, points)
