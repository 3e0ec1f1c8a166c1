"""What the car could do: ways beside its route, and speeds on them.

The recipe is that of PDM-Closed (D. Dauner et al., "Parting with Misconceptions about
Learning-based Vehicle Motion Planning", CoRL 2023, arXiv 2306.07962).
"""

from __future__ import annotations

import math
from typing import Iterator, NamedTuple, Sequence

import numpy as np

from sdc_common.geometry.route import smooth_step
from sdc_package.behaviour.offset_path import SAME_M, state_at
from sdc_package.behaviour.road import BEHIND_LINE, NOTHING, SAME
from sdc_package.behaviour.scene import AT_REST_MPS, Stop, StreetScene

# The way that the car takes.
KEEP = "keep"
# Shares of the planned speed with which each way is proposed, too.
SLOWER = (0.5, 0.0)
# A car that is farther beside its route at the start pulls out [m].
PULLS_OUT_M = 1.0
# Greatest slope of a route that changes lanes.
_STEEPEST = 0.2


class CarWay(NamedTuple):
    """A way of the car beside its route."""

    name: str
    new: float  # how much it is another way than before
    offset_m: np.ndarray  # distance from the points of the route, positive to the left [m]
    stop_m: float = math.inf  # where the centre of the car must stop on it [m]


class Proposal(NamedTuple):
    """A way and a speed."""

    way: CarWay
    number: int  # of the way
    share: float  # share of the planned speed
    stop: Stop | None = None  # where the centre of the car stops, and why

    @property
    def stop_m(self) -> float:
        """Arc length at which the centre of the car stops, inf: nowhere [m]."""
        return min(self.way.stop_m, self.stop.s_m if self.stop else math.inf)

    def __str__(self) -> str:
        speed = {1.0: "go", 0.0: "brake"}.get(self.share, "slowly")
        speed = f"stop for the {self.stop.reason}" if self.stop else speed
        return speed if self.way.name == KEEP else f"{self.way.name}, {speed}"


def proposals(ways: Sequence[CarWay], stops: Sequence[Stop]) -> list[Proposal]:
    """Return each way with each speed, and with a stop at each of these places."""
    speeds: list[tuple[float, Stop | None]] = [(1.0, None)]
    speeds += [(1.0, stop) for stop in stops] + [(share, None) for share in SLOWER]
    return [Proposal(way, n, *speed) for n, way in enumerate(ways) for speed in speeds]


def ways(scene: StreetScene, keeps_route: bool) -> Iterator[CarWay]:
    """Yield the ways that the car could take, first the one that it takes."""
    way, s_m, speed_mps = scene.way, scene.s_m, scene.speed_mps
    settings = scene.settings.proposals
    wait_m = math.inf if keeps_route else _wait_m(scene, scene.apart_m)
    yield CarWay(KEEP, 0.0, way.offset_m, wait_m)
    if keeps_route:
        return
    if abs(way.offset_at(s_m + settings.shift_m)) > SAME_M:
        yield CarWay("back", 0.5, way.shifted(way.offset_m, 0.0, s_m, speed_mps), wait_m)
    for offset_m in _passes(scene) if scene.passable else ():
        yield CarWay("pass", 1.0, offset_m)
    for offset_m in _asides(scene) if scene.emergency else ():
        yield CarWay("aside", 1.0, offset_m)
    needs_room = scene.is_invaded or scene.passable or scene.emergency
    if needs_room and np.abs(way.offset_m).max() < PULLS_OUT_M:
        for to_m in (-settings.nudge_m, settings.nudge_m):
            nudge = _there_and_back(scene, to_m, s_m, s_m + scene.soon_m)
            apart_m = scene.apart_from(scene.ways([nudge])[0])
            yield CarWay("nudge", 1.0, nudge, _wait_m(scene, apart_m))
    if scene.changes_lane:
        yield from _stays(scene)


def _stays(scene: StreetScene) -> Iterator[CarWay]:
    """Yield the way that stays in the nearest lane and waits for the change of lanes there."""
    road, s, s_m = scene.road, scene.road.route.s, scene.s_m
    after = int(np.searchsorted(road.edge, road.edge[scene.at], side="right"))
    lane_end_m = road.s_m[min(after, len(road.s_m) - 1)] - scene.settings.proposals.wait_m
    # It can still change lanes at its speed, unless it needs half of its room to stop.
    length_m = scene.way.shift_length_m(scene.width_m, scene.speed_mps)
    length_m = min(length_m, 0.5 * (lane_end_m - s_m))
    length_m = max(length_m, 2.0 * scene.settings.proposals.shift_m)
    begin_m = min(s_m + scene.soon_m, lane_end_m - length_m)
    if begin_m < s_m:
        return
    route_y = np.interp(s, road.s_m, road.route_y_m)
    # Places across the road may jump behind a junction: no route is so steep.
    now_y, route_slope, _ = state_at(s, route_y, s_m)
    route_slope = min(max(route_slope, -_STEEPEST), _STEEPEST)
    line_y = scene.way.offset_m + now_y + route_slope * (s - s_m)
    lane_y = scene.width_m * round((now_y + scene.way.offset_at(s_m)) / scene.width_m)
    held = scene.way.shifted(line_y, lane_y, s_m, scene.speed_mps) - route_y
    later = 1.0 - smooth_step(s, begin_m, length_m)
    stay = np.where(s < s_m - 1.0, scene.way.offset_m, held * later)
    if abs(np.interp(begin_m, s, held)) > SAME_M:
        yield CarWay("stay", 0.5, stay, begin_m)


def _asides(scene: StreetScene) -> Iterator[np.ndarray]:
    """Yield the ways to the next lanes, which make room for an emergency vehicle."""
    length_m = scene.way.shift_length_m(scene.width_m, scene.speed_mps)
    until_m = min(scene.s_m + scene.soon_m, scene.end_m - 2.0 * length_m)
    for side, beside in ((-1.0, scene.road.right), (1.0, scene.road.left)):
        if beside[scene.at] == SAME and until_m > scene.s_m + length_m:
            yield _there_and_back(scene, side * scene.width_m, scene.s_m, until_m)


def _passes(scene: StreetScene) -> Iterator[np.ndarray]:
    """Yield the ways around those that are passable, to the left and to the right."""
    group, until_m, time_s = _group(scene)
    settings = scene.settings.proposals
    moves = bool((scene.others.along_mps[group] > AT_REST_MPS).any())
    back_m = until_m + scene.way.shift_length_m(scene.width_m, scene.top_mps)
    front_m = scene.rear_m[group[0]] - scene.settings.front_m
    front_m -= max(settings.before_m, scene.speed_mps)
    for side, beside in ((1.0, scene.road.left), (-1.0, scene.road.right)):
        reaches_m = side * scene.others.beside_m[group] + scene.body_m[group]
        needed_m = max(float(reaches_m.max()) + settings.beside_m, 0.0)
        if needed_m > scene.inside_m:
            stretch = beside[scene.at : scene.road.at(until_m) + 1]
            is_same = bool((stretch == SAME).all())
            may_cross = (stretch != BEHIND_LINE).all() and time_s < settings.overtakes_s
            may_overtake = side > 0.0 and back_m < scene.end_m and (is_same or may_cross)
            if (stretch == NOTHING).any() or (moves and not may_overtake):
                continue
            # From rest, only the middle of the next lane is far enough.
            if is_same or scene.speed_mps < AT_REST_MPS:
                needed_m = max(needed_m, scene.width_m)
            needed_m = min(needed_m, scene.width_m + scene.inside_m)
        to_m, room_m = side * needed_m, front_m - scene.s_m
        length_m = scene.way.shift_length_m(to_m, scene.shifts_mps)
        yield _there_and_back(scene, to_m, scene.s_m, until_m, room_m)
        if not moves and length_m < room_m:  # as late as possible
            yield _there_and_back(scene, to_m, front_m - length_m, until_m, length_m)


def _group(scene: StreetScene) -> tuple[list[int], float, float]:
    """Return those that are passed together, where that ends [m], and the time for it [s]."""
    others, front_m = scene.others, scene.settings.front_m
    free_m = scene.settings.proposals.before_m
    slower_mps = max(scene.top_mps - scene.speed_mps, 0.0)
    group: list[int] = []
    until_m, time_s = -math.inf, 0.0
    for n in scene.passable:
        speed_mps, rear_m = max(float(others.along_mps[n]), 0.0), float(scene.rear_m[n])
        if group and rear_m - until_m > scene.way.shift_length_m(scene.width_m, scene.top_mps):
            break
        length_m = 2.0 * float(others.half_length_m[n])
        gap_m = max(rear_m - scene.s_m - front_m, 0.0)
        faster_mps = max(scene.top_mps - speed_mps, 1.0)
        time_s = (gap_m + length_m + 2.0 * (front_m + free_m)) / faster_mps
        time_s += slower_mps / (2.0 * scene.settings.streets.acceleration_mps2)
        end_m = rear_m + length_m + front_m + free_m
        until_m = max(until_m, end_m + (speed_mps > AT_REST_MPS) * speed_mps * time_s)
        group.append(n)
    return group, until_m, time_s


def _there_and_back(
    scene: StreetScene, to_m: float, begin_m: float, until_m: float, room_m: float = 0.0
) -> np.ndarray:
    """Return the way that is beside the route up to an arc length, and returns after it."""
    out = scene.way.shifted(scene.way.offset_m, to_m, begin_m, scene.speed_mps, room_m)
    length_m = scene.way.shift_length_m(to_m, scene.shifts_mps)
    return out * (1.0 - smooth_step(scene.road.route.s, until_m, length_m))


def _wait_m(scene: StreetScene, apart_m: np.ndarray) -> float:
    """Return where the car waits on a way, so far from the others, inf: nowhere [m]."""
    at_rest = (apart_m < scene.body_m) & (scene.others.along_mps < AT_REST_MPS)
    rears_m = [float(scene.rear_m[n]) for n in scene.passable if at_rest[n]]
    wait_m = scene.settings.proposals.wait_m
    stop_m = min(rears_m, default=math.inf) - scene.settings.front_m - wait_m
    # A car that has stopped a little too late stays.
    return max(stop_m, scene.s_m) if stop_m > scene.s_m - 0.5 * wait_m else math.inf
