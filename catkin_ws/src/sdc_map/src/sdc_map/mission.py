"""Missions: ways over the lanes of a map as points with speed limits."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, field
from typing import AbstractSet, Iterator, Sequence

import numpy as np

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate, smooth_step
from sdc_map.drivable import drivable_line
from sdc_map.lane_graph import CHANGE_M, LaneGraph, NoRouteError, change_m
from sdc_map.network import LanePlace, Network, RoadLane, part_of

Point = Sequence[float]

# A goal or a car that is farther from all lanes is on none.
NEAR_M = 20.0
_STEP_M = 1.0
# A change of lanes begins after this share of its stretch of road.
_EARLY = 0.25


@dataclass(frozen=True)
class Mission:
    """A way over lanes."""

    points_m: np.ndarray = field(repr=False)  # (N, 2) points, about 1 m apart [m]
    limits_mps: np.ndarray = field(repr=False)  # (N,) speed limit at each of them [m/s]
    lanes: tuple[str, ...]  # ids of the lanes, in order
    ends_m: tuple[float, ...]  # distance along the points of each goal [m]
    time_s: float  # time at the speed limits [s]


def plan_mission(
    graph: LaneGraph,
    goals: Sequence[Point],
    x_m: float,
    y_m: float,
    yaw_rad: float | None = None,
    closed: AbstractSet[str] = frozenset(),
    z_m: float = math.nan,
) -> Mission:
    """Return the fastest mission from a pose, at a height if it is known, to all goals, in order.

    A connection with a bend that no car can drive on this way is avoided where another way exists.

    Raises:
        NoRouteError: the car is on no lane, or a goal cannot be reached
    """
    pose = x_m, y_m, yaw_rad, NEAR_M
    # An estimated position may have no height: then there is no lane on its level.
    start = graph.network.nearest(*pose, z_m) or graph.network.nearest(*pose)
    if start is None:
        raise NoRouteError(f"no lane is within {NEAR_M:g} m of ({x_m:.1f}, {y_m:.1f})")
    lanes: list[str] = []
    pieces, ends, time_s = [], [], 0.0
    for x, y in goals:
        name = f"the goal ({x:.1f}, {y:.1f})"
        goal = graph.network.nearest(x, y, within_m=NEAR_M)
        if goal is None:
            raise NoRouteError(f"{name} is on no lane; give a point within {NEAR_M:g} m of one")
        try:
            way, seconds = graph.route(start, goal, closed)
        except NoRouteError as error:
            text = f"{name} cannot be reached from lane {start.lane}: {error}"
            raise NoRouteError(text) from None
        way, goal = _with_room(graph.network, _spread(graph.network, way, closed), goal)
        time_s += seconds
        lanes += way
        pieces += list(_pieces(graph.network, way, start.s_m, goal.s_m))
        ends.append(len(pieces))
        start = goal
    points, limits, ends_m, lost = _resampled(pieces, ends)
    bent = next((lane.id for lane in lost if lane.junction), None)
    if bent is not None and bent not in closed:
        with contextlib.suppress(NoRouteError):
            return plan_mission(graph, goals, x_m, y_m, yaw_rad, {*closed, bent}, z_m)
    return Mission(points, limits, tuple(lanes), ends_m, time_s)


def _with_room(network: Network, way: list[str], goal: LanePlace) -> tuple[list[str], LanePlace]:
    """Return a way and its goal, beside the goal where changes of lanes to it have no room."""
    lanes = [network.lanes[name] for name in way]
    changes = 0  # at the end of the way
    while changes + 1 < len(way) and way[-1 - changes] not in lanes[-2 - changes].successors:
        changes += 1
    # On the stretch of road where the way begins, the graph looks for room.
    if changes + 1 == len(way) or goal.s_m >= changes * CHANGE_M:
        return way, goal
    s_m = goal.s_m * lanes[-2].length_m / lanes[-1].length_m
    return _with_room(network, way[:-1], goal._replace(lane=way[-2], s_m=s_m))


def _spread(network: Network, way: list[str], closed: AbstractSet[str]) -> list[str]:
    """Return a way whose first of two changes of lanes is on the stretch before, if it can be."""
    lanes = network.lanes
    for at in range(1, len(way) - 3):
        before, through, lane, other = (lanes[name] for name in way[at : at + 4])
        side = "left" if lane.left == other.id else "right"
        early = lanes.get(getattr(before, side))
        if getattr(lane, side) != other.id or not early or early.length_m < CHANGE_M:
            continue
        ways = [one for one in early.successors if other.id in lanes[one].successors]
        again = way[at + 4 : at + 5] == [getattr(other, side)]
        if through.junction and ways and again and closed.isdisjoint([early.id, *ways]):
            return _spread(network, [*way[: at + 1], early.id, ways[0], *way[at + 3 :]], closed)
    return way


def _pieces(
    network: Network, way: Sequence[str], start_m: float, end_m: float
) -> Iterator[tuple[np.ndarray, RoadLane]]:
    """Return points and lane of each stretch of a way [m].

    A stretch of road with several lanes is shared between them.
    """
    lanes = [network.lanes[name] for name in way]
    first = 0
    while first < len(lanes):
        last = first  # of the lanes beside one another
        while last + 1 < len(lanes) and way[last + 1] in (lanes[last].left, lanes[last].right):
            last += 1
        begin = start_m / lanes[first].length_m if first == 0 else 0.0
        end = end_m / lanes[last].length_m if last == len(lanes) - 1 else 1.0
        window, at = (end - begin) / max(last - first, 1), begin
        for number in range(first, last):  # early, so that a car can still wait for a gap
            lane, other = lanes[number : number + 2]
            length = change_m(other) / other.length_m
            start = begin + window * (number - first) + min(_EARLY * window, length)
            yield _stretch(lane, at, start)
            at = start + min((1.0 - _EARLY) * window, length)
            yield _change(lane, other, start, at), other
        yield _stretch(lanes[last], at, end)
        first = last + 1


def _stretch(lane: RoadLane, start: float, end: float) -> tuple[np.ndarray, RoadLane]:
    """Return the points of a lane between shares of its length [m], and the lane."""
    return part_of(lane.points_m, lane.s_m, start * lane.length_m, end * lane.length_m), lane


def _change(lane: RoadLane, other: RoadLane, start: float, end: float) -> np.ndarray:
    """Return the points of a smooth change between lanes, between shares of their lengths."""
    t = np.linspace(0.0, 1.0, int((end - start) * lane.length_m / _STEP_M) + 2)
    share = start + (end - start) * t
    weight = smooth_step(t, 0.0, 1.0)[:, None]
    ways = (one.at(share * one.length_m) for one in (lane, other))
    return (1.0 - weight) * next(ways) + weight * next(ways)


def _resampled(
    pieces: Sequence[tuple[np.ndarray, RoadLane]], ends: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, tuple[float, ...], list[RoadLane]]:
    """Return points about 1 m apart along pieces of lanes, with their limits, and goals along them.

    A goal is at the end of the pieces before one of the numbers `ends`. Where a car cannot drive
    the pieces, the points are those of a curve beside them. Also return the lanes with bends for
    which there is no curve.
    """
    points = np.vstack([part for part, _ in pieces])
    lengths = [len(part) for part, _ in pieces]
    limits = np.repeat([lane.speed_limit_mps for _, lane in pieces], lengths)
    s = arc_lengths(points)
    behind = np.cumsum(lengths)
    ends_m = s[behind[np.array(ends) - 1] - 1]
    line = drivable_line(points, s[[*behind[:-1], *(behind[:-1] - 1)]])
    lost = [pieces[np.searchsorted(s[behind - 1], at_m)][1] for at_m in line.lost_m]
    if line.points_m is not points:
        row = np.minimum(np.searchsorted(s, line.s_m, side="right") - 1, len(s) - 1)
        points, limits, s = line.points_m, limits[row], arc_lengths(line.points_m)
        ends_m = np.interp(ends_m, line.s_m, s)
    # Of two points at one place the second one has the limit from there on.
    kept = np.append(np.diff(s) > 1e-3, True)
    points, limits, s = points[kept], limits[kept], s[kept]
    at = np.linspace(0.0, s[-1], max(2, round(s[-1] / _STEP_M) + 1))
    here = np.minimum(np.searchsorted(s, at, side="right") - 1, len(s) - 1)
    return interpolate(at, s, points), limits[here], tuple(ends_m.tolist()), lost
