"""Scenario types on the streets of a map: where one happens, and who is there.

config/street_scenarios.yaml is the table of the types, and describes its keys. A seed draws the
place among those of the map that fit, and each number that is a pair (least, greatest).
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Iterator, Mapping, Sequence

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.validation import suggestion
from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import KINDS
from sdc_sim.physics.traffic_lights import GREEN, RED, TrafficLightPlan
from sdc_sim.road.lane_graph import LaneGraph, NoRouteError
from sdc_sim.road.mission import plan_mission
from sdc_sim.road.network import Network, RoadLane, left_normals
from sdc_sim.road.network_file import load_network
from sdc_sim.scenario.street_places import (
    LEAST_M,
    DoesNotFit,
    Site,
    chain,
    even,
    oncoming_lane,
    sites,
    walk,
)
from sdc_sim.traffic.actors import Actor, ScriptedTraffic, Step, Zone
from sdc_sim.traffic.lights import lights_of
from sdc_sim.yaml_document import packaged_config

# Two ways meet where they are so near.
_MEET_M = 1.5
# With these the car is expected to reach the event: a street's limit and an acceleration.
_CAR_MPS, _CAR_MPS2 = 12.0, 1.8
_CAR_M = (4.7, 2.0)
_ACCELERATION_MPS2 = 2.0
# How long a light must have its colour before the car comes, and after it [s].
_LIGHT_S = {"green": (8.0, 9.0), "red": (8.0, 3.0)}
_SIDES = {"opposite": math.pi, "left": -0.5 * math.pi, "right": 0.5 * math.pi, "along": 0.0}
# Time limit: so many times the time at the speed limits, and so much more.
_LIMIT_RATIO, _LIMIT_S = 3.0, 40.0


@dataclass(frozen=True)
class Placement:
    """A scenario type at a place."""

    name: str
    start: tuple[float, float]  # where the car begins [m]
    goals: list[tuple[float, float]]  # where it drives to [m]
    mission_m: np.ndarray = field(repr=False)  # (N, 2) its way [m]
    event_m: tuple[float, float]  # where it happens [m]
    event_at_m: float  # distance of this place along the way [m]
    actors: tuple[Actor, ...] = field(repr=False)
    zones: tuple[Zone, ...]  # stretches with their own grip and wind
    lights_s: float  # time by which the programs of all lights are ahead [s]
    parameters: dict[str, Any]  # of config/sim.yaml that the type sets
    limit_s: float  # the drive should be over by then [s]

    def conditions(
        self, values: Mapping[str, Any], lights: Sequence[TrafficLightPlan]
    ) -> tuple[dict[str, Any], list[TrafficLightPlan]]:
        """Return parameters of config/sim.yaml and lights with those of the type."""
        start = {**values["start"], **self.parameters.get("start", {})}
        shifted = [replace(one, offset_s=one.offset_s + self.lights_s) for one in lights]
        return {**values, **self.parameters, "start": start}, shifted

    def traffic(
        self, seed: int, tick_s: float, lights: Sequence[TrafficLightPlan], car: Any
    ) -> ScriptedTraffic:
        """Return the road users; the zones act on the vehicle."""
        arguments = self.actors, self.mission_m, seed, tick_s, lights, self.zones
        conditions = car.friction, car.side_wind_mps
        return ScriptedTraffic(*arguments, conditions, car.set_conditions)


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
    row, draw = table[name], random.Random(f"{name} {seed}")
    found = list(sites(network, row["place"], draw))
    draw.shuffle(found)
    for site in found:
        try:
            return _Placer(name, row, network, site, draw).placement()
        except (DoesNotFit, NoRouteError):
            continue
    raise ValueError(
        f"street_scenario: the map {network.name} has no place for {name}; "
        "choose another type or map, such as map:=town"
    )


def of_map(path: str, name: str, seed: int) -> Placement:
    """Return a type at a place of a map; see `place`."""
    return place(name, load_network(path), seed)


@lru_cache(maxsize=2)
def _graph(network: Network) -> LaneGraph:
    return LaneGraph(network)


def _drawn(value: Any, draw: random.Random) -> Any:
    """Return a number between a pair of numbers, one of a list of words, or the value itself."""
    if isinstance(value, list) and value and isinstance(value[0], str):
        return draw.choice(value)
    is_pair = isinstance(value, list) and len(value) == 2
    return draw.uniform(*value) if is_pair else value


def _reach_s(distance_m: float, speed_mps: float, acceleration_mps2: float) -> float:
    """Return the time in which a road user at rest drives a distance [s]."""
    until_m = speed_mps**2 / (2.0 * acceleration_mps2)
    if distance_m < until_m:
        return math.sqrt(2.0 * max(distance_m, 0.0) / acceleration_mps2)
    return speed_mps / acceleration_mps2 + (distance_m - until_m) / speed_mps


class _Placer:
    """Places one type at one site."""

    def __init__(
        self, name: str, row: Mapping[str, Any], network: Network, site: Site, draw: random.Random
    ):
        self._name, self._row, self._network = name, row, network
        self._site, self._draw = site, draw
        where = row["place"]
        before_m = _drawn(where.get("before_m", [80.0, 115.0]), draw)
        after_m = _drawn(where.get("after_m", [70.0, 110.0]), draw)
        begin, least_m = site.start or site.lane, where.get("least_m", LEAST_M)
        self._start = walk(network, begin, site.s_m, before_m, False, least_m)
        self._goal = walk(network, *site.goal, after_m, True)
        mission = plan_mission(_graph(network), [self._goal], *self._start)
        core = site.way.through[:1] if site.way else (site.lane.id, site.goal[0].id)
        if not {*core} <= {*mission.lanes}:
            raise DoesNotFit
        self._mission_m, self._time_s = mission.points_m, mission.time_s
        self._line = Polyline(mission.points_m.tolist())
        x, y = site.lane.at(np.array([site.s_m]))[0].tolist()
        if where.get("event") == "exit" and site.way:
            x, y = network.lanes[site.way.end].points_m[0].tolist()
        self._event_m, self._event_at_m = (x, y), self._line.nearest(x, y).s_m
        self._ways: dict[str, tuple[np.ndarray, float, float]] = {}
        self._line_m: dict[str, float] = {}  # of each way through the junction

    def placement(self) -> Placement:
        """Return the placement.

        Raises:
            DoesNotFit: a road user has no way here, or two of them begin at the same place
        """
        row = self._row
        if row["place"].get("event") == "crosswalk":
            self._move_event_to_crosswalk()
        groups = (one if isinstance(one, list) else [one] for one in row.get("actors", ()))
        rows = [one for group in groups for one in group]
        actors = [one for each in rows for one in self._actors(each)]
        self._check_free(actors)
        zones = [Zone(*self._zone(one)) for one in row.get("zones", ())]
        return Placement(
            self._name,
            self._start,
            [self._goal],
            self._mission_m,
            self._event_m,
            self._event_at_m,
            tuple(actors),
            tuple(zones),
            self._lights_s(row["light"]) if "light" in row else 0.0,
            dict(row.get("parameters", {})),
            _LIMIT_S + _LIMIT_RATIO * self._time_s + row.get("extra_s", 0.0),
        )

    def _zone(self, one: Sequence) -> Iterator[float]:
        from_m, length_m, friction, wind_mps = (_drawn(value, self._draw) for value in one)
        yield self._event_at_m + from_m
        yield self._event_at_m + from_m + length_m
        yield friction
        yield wind_mps * self._draw.choice((-1.0, 1.0))

    def _move_event_to_crosswalk(self) -> None:
        """Let the event be where the way meets a crosswalk, near the junction."""
        for polygon in self._network.crosswalks:
            x, y = polygon.mean(axis=0).tolist()
            there = self._line.nearest(x, y)
            if there.distance_m < 5.0 and abs(there.s_m - self._event_at_m) < 30.0:
                self._event_at_m = there.s_m
                self._event_m = self._line.point_at(there.s_m)
                return
        raise DoesNotFit

    def _lights_s(self, colour: str) -> float:
        """Return the time by which the lights must be ahead, so that the car meets a colour."""
        assert self._site.way is not None
        line = self._site.lane.points_m[-1]
        lights = [
            one for one in lights_of(self._network) if math.dist((one.x_m, one.y_m), line) < 1.0
        ]
        comes_s = _reach_s(self._event_at_m, _CAR_MPS, _CAR_MPS2)
        before_s, after_s = _LIGHT_S[colour]
        for light in lights:
            cycle_s = round(sum(seconds for _, seconds in light.phases))
            for ahead_s in self._draw.sample(range(cycle_s), cycle_s):
                at = comes_s + np.arange(-before_s, after_s, 0.5) + ahead_s
                wanted = GREEN if colour == "green" else RED
                if all(light.state(one) == wanted for one in at.tolist()):
                    return float(ahead_s)
        raise DoesNotFit

    def _way(self, way: Any) -> tuple[np.ndarray, float, float]:
        """Return a way, the arc length of its meeting with the mission, and that on the mission."""
        key = str(way)
        if key not in self._ways:
            points = self._points(way)
            line = Polyline(points.tolist())
            s_m, at_m = line.nearest(*self._event_m).s_m, self._event_at_m
            if isinstance(way, dict):
                after = self._mission_m[arc_lengths(self._mission_m) > at_m - 3.0][:60]
                apart = np.hypot(*(after[:, None] - points).transpose(2, 0, 1))
                near = np.flatnonzero(apart.min(axis=1) < _MEET_M)
                if not len(near):
                    raise DoesNotFit
                at_m = self._line.nearest(*after[near[0]].tolist()).s_m
                s_m = line.nearest(*after[near[0]].tolist()).s_m
            self._ways[key] = points, s_m, at_m
        return self._ways[key]

    def _points(self, way: Any) -> np.ndarray:
        """Return the points of a way, see config/street_scenarios.yaml."""
        network, lane, s_m = self._network, self._site.lane, self._site.s_m
        if way == "ahead":
            first, last = network.nearest(*self._start), network.nearest(*self._goal)
            assert first is not None and last is not None
            back = chain(network, network.lanes[first.lane], on_m=0.0)
            on = chain(network, network.lanes[last.lane], back_m=0.0)
            ends = self._line.points[0], self._line.points[-1]
            cut = (int(np.argmin(np.hypot(*(one - end).T))) for one, end in zip((back, on), ends))
            parts = back[: max(next(cut) - 1, 0)], self._mission_m, on[next(cut) + 2 :]
            return even(np.vstack(parts))
        if isinstance(way, dict):
            return self._through(way)
        beside: RoadLane | None = None
        if way in ("left", "right", "2nd left"):
            beside = network.lanes.get(lane.right if way == "right" else lane.left)
            if way == "2nd left" and beside is not None:
                beside = network.lanes.get(beside.left)
        elif way == "oncoming":
            beside = oncoming_lane(network, lane, min(s_m, lane.length_m - 1.0))
        if beside is None:
            raise DoesNotFit
        return chain(network, beside)

    def _through(self, way: Mapping[str, str]) -> np.ndarray:
        """Return the points of another way through the junction."""
        network, own = self._network, self._site.way
        assert own is not None
        (mine,) = (one for one in network.ways[own.start] if one.connection is own)
        heading = network.lanes[own.start].heading_at(self._site.lane.length_m)
        for one in network.junctions[mine.junction].connections:
            start = network.lanes[one.start]
            turned = start.heading_at(start.length_m) - heading - _SIDES[way["from"]]
            is_there = abs(math.remainder(turned, 2.0 * math.pi)) < math.radians(50.0)
            first = way.get("first")
            turns = one.direction.lower() in way["turn"] and one.start != own.start
            if is_there and turns and (first is None or (one in mine.first) == first):
                inside = [network.lanes[name].points_m for name in one.through]
                before = chain(network, start, on_m=0.0)
                after = chain(network, network.lanes[one.end], back_m=0.0)
                self._line_m[str(way)] = float(arc_lengths(before)[-1])
                return even(np.vstack([before, *inside, after]))
        raise DoesNotFit

    def _actors(self, row: Mapping[str, Any]) -> Iterator[Actor]:
        """Yield the road users of a row of the table."""
        draw = self._draw
        row = {key: one if key in _AS_IT_IS else _drawn(one, draw) for key, one in row.items()}
        way = row["way"]
        if isinstance(way, dict):
            way = {key: _drawn(one, draw) for key, one in way.items()}
        is_across = way in ("across", "back across")
        points, s_m, meets_m = self._across(row) if is_across else self._way(way)
        length_m = KINDS[_drawn(row["kinds"], draw) if "kinds" in row else row["kind"]].size_m[0]
        if "from_start_m" in row:
            at_m = row["from_start_m"] - self._event_at_m
        elif "from_line_m" in row:
            at_m = self._line_m[str(way)] - row["from_line_m"] - 0.5 * length_m - s_m
        else:
            at_m = row.get("at_m", 0.0)
        limit = self._site.lane.speed_limit_mps if row.get("of_limit") else 1.0
        speed = row.get("mps", 0.0) * limit
        if "comes_s" in row:
            at_m = -speed * (_reach_s(meets_m, _CAR_MPS, _CAR_MPS2) + row["comes_s"])
        drawn = ([_drawn(one, draw) for one in step] for step in row.get("steps", ()))
        steps = [Step(after_s, mps * limit, rate) for after_s, mps, rate in drawn]
        within_m, within_s = row.get("within_m", 0.0), row.get("within_s", 0.0)
        if "meets_s" in row:
            within_s = row["meets_s"] + _reach_s(-at_m, *steps[0][1:])
        start_m = s_m + at_m
        points = self._shifted(points, start_m, row)
        gaps_s = tuple((least, most) for least, most in row.get("gaps_s", ()))
        for number in range(row.get("count", 1)):
            kind = _drawn(row["kinds"], draw) if "kinds" in row else row["kind"]
            size_m: Any = tuple(row.get("size_m", KINDS[kind].size_m))
            yield Actor(
                kind,
                points,
                start_m,
                size_m,
                speed,
                tuple(steps),
                meets_m if within_m or within_s else math.inf,
                within_m,
                within_s,
                math.radians(row.get("turned_deg", 0.0)),
                row.get("looks", True),
                is_across and not gaps_s,
                gaps_s,
            )
            gap_s = draw.uniform(*gaps_s[number % len(gaps_s)]) if gaps_s else 0.0
            start_m -= size_m[0] + gap_s * speed + row.get("gap_m", 0.0)

    def _across(self, row: Mapping[str, Any]) -> tuple[np.ndarray, float, float]:
        """Return a line across the mission, the arc length of the meeting, and that on it."""
        at_m = self._event_at_m + row.get("along_m", 0.0)
        (x, y), yaw = self._line.point_at(at_m), self._line.direction_at(at_m)
        side = -1.0 if row["way"] == "back across" else 1.0
        left = side * np.array([-math.sin(yaw), math.cos(yaw)])
        from_m, to_m = row.get("from_m", row["at_m"]), row.get("to_m", 7.0)
        return np.array([[x, y] + from_m * left, [x, y] + to_m * left]), -from_m, at_m

    def _shifted(self, points: np.ndarray, start_m: float, row: Mapping[str, Any]) -> np.ndarray:
        """Return a way beside a way; it changes to another distance beside it after the start."""
        left_m, to_m = row.get("left_m", 0.0), row.get("to_left_m", row.get("left_m", 0.0))
        if left_m == to_m == 0.0:
            return points
        t = (arc_lengths(points) - start_m - row.get("shift_after_m", 0.0)) / row.get("over_m", 1.0)
        t = np.clip(t, 0.0, 1.0)
        weight = t**3 * (10.0 - 15.0 * t + 6.0 * t * t)
        across_m = left_m + (to_m - left_m) * weight
        return points + across_m[:, None] * left_normals(points)

    def _check_free(self, actors: Sequence[Actor]) -> None:
        """Raise DoesNotFit if two bodies begin at the same place; a door is a part of its car."""
        left_m = self._row.get("parameters", {}).get("start", {}).get("left_m", 0.0)
        (x, y), yaw = self._line.point_at(0.0), self._line.direction_at(0.0)
        x, y = x - left_m * math.sin(yaw), y + left_m * math.cos(yaw)
        bodies = [Rectangle(x, y, yaw, *_CAR_M).grown(0.3)]
        for one in actors:
            if one.start_m < 0.0:
                continue
            line = Polyline(one.path_m.tolist())
            if one.start_m >= line.s[-1]:
                raise DoesNotFit
            yaw = line.heading_at(one.start_m) + one.turned_rad
            body = Rectangle(*line.point_at(one.start_m), yaw, *one.size_m[:2])
            if any(overlap(body, other) for other in bodies):
                raise DoesNotFit
            bodies.append(body)


# Keys of a road user whose lists are no numbers to draw.
_AS_IT_IS = ("steps", "gaps_s", "kinds", "size_m", "way")
