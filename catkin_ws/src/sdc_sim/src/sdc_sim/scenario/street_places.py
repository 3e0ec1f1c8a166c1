"""Places on the streets of a map at which a scenario type may happen, and ways over them."""

from __future__ import annotations

import math
import random
from typing import Any, Iterator, Mapping, NamedTuple

import numpy as np

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_sim.road.network import STOP, YIELD, Connection, Network, RoadLane

# A way of a road user begins so far before the event, and ends so far after it.
_BACK_M, _ON_M = 160.0, 220.0
# Least way before and after the event that does not lead through a further junction, and what
# remains to the end of a lane.
LEAST_M, _MARGIN_M = 42.0, 5.0
_STEP_M = 1.0
_TRIES = 6  # places on each stretch
# The street is looked at so far before and after the event for bends.
_LOOK_BACK_M, _LOOK_ON_M = 35.0, 25.0
_ONCOMING_M, _ONCOMING_RAD = 2.0, math.radians(25.0)


class DoesNotFit(Exception):
    """This place has not what the type needs."""


class Site(NamedTuple):
    """A place at which a type may happen."""

    lane: RoadLane  # the lane of the event
    s_m: float  # the event on it [m]
    goal: tuple[RoadLane, float]  # place from which the way leads on to the goal
    way: Connection | None = None  # the way through the junction at the end of the lane
    start: RoadLane | None = None  # the lane of the start, None for that of the event


def sites(network: Network, where: Mapping[str, Any], draw: random.Random) -> Iterator[Site]:
    """Yield the places of a kind, see config/street_scenarios.yaml."""
    least, most = (kmh / 3.6 for kmh in where.get("limit_kmh", (20, 70)))
    for lane in network.driving:
        if lane.junction or not least <= lane.speed_limit_mps + 0.1 <= most + 0.2:
            continue
        if where["at"] == "junction":
            for way, _, name in network.ways.get(lane.id, ()):
                has_sign = way.signal < 0 and way.line in (STOP, YIELD)
                control = way.line if has_sign else network.junctions[name].kind
                count = len(network.junctions[name].connections)
                fits = control in where["control"] and way.direction.lower() in where["turn"]
                if fits and count >= where.get("ways", 3):
                    yield Site(lane, lane.length_m, (network.lanes[way.end], 0.0), way)
        elif where["at"] == "stretch":
            last_m = lane.length_m - where.get("end_m", 20.0)
            for _ in range(_TRIES):
                s_m = draw.uniform(LEAST_M + _MARGIN_M, max(last_m, LEAST_M))
                if s_m < last_m and _is_street(network, lane, s_m, where):
                    yield Site(lane, s_m, (lane, s_m))
        elif bool(lane.predecessors) != bool(lane.successors) and lane.left:
            # A lane that ends, or one that begins: from it the car changes, or to it.
            far = network.lanes[lane.left]
            if where.get("changes", 1) == 2:
                far = network.lanes.get(far.left, far)
            if where["at"] == "merge" and lane.predecessors:
                yield Site(lane, 0.0, (far, far.length_m))
            elif where["at"] == "exit" and lane.successors:
                yield Site(lane, 0.0, (lane, lane.length_m), start=far)


def _is_street(network: Network, lane: RoadLane, s_m: float, where: Mapping[str, Any]) -> bool:
    """Return whether a stretch has the neighbours and bends of a place."""
    if "left" in where:
        left = "same" if lane.left else "oncoming" if oncoming_lane(network, lane, s_m) else "none"
        if left != where["left"]:
            return False
    if bool(lane.right) != where.get("right", False):
        return False
    at = np.arange(s_m - _LOOK_BACK_M, min(s_m + _LOOK_ON_M, lane.length_m), 2.0)
    least, most = where.get("bend_deg", (0.0, 8.0))
    return least <= np.degrees(np.ptp(np.unwrap([lane.heading_at(s) for s in at]))) <= most


def oncoming_lane(network: Network, lane: RoadLane, s_m: float) -> RoadLane | None:
    """Return the lane of the other direction beside a place on a lane."""
    (x, y), yaw = lane.at(np.array([s_m]))[0].tolist(), lane.heading_at(s_m)
    x, y = x - lane.width_m * math.sin(yaw), y + lane.width_m * math.cos(yaw)
    found = network.nearest(x, y, yaw + math.pi, _ONCOMING_M)
    is_along = found is not None and abs(found.heading_error_rad) < _ONCOMING_RAD
    beside = network.lanes[found.lane] if found is not None and is_along else None
    return None if beside is None or beside.junction else beside


def _next(network: Network, lane: RoadLane, ahead: bool) -> RoadLane | None:
    """Return the lane after or before this one that turns least, None at the end of the map."""
    if ahead:
        return network.straight_on(lane)
    before = [network.lanes[name] for name in lane.predecessors]
    turns = [one.heading_at(one.length_m) - lane.heading_at(0.0) for one in before]
    turns = [abs(math.remainder(one, 2.0 * math.pi)) for one in turns]
    return before[turns.index(min(turns))] if before else None


def walk(
    network: Network,
    lane: RoadLane,
    s_m: float,
    far_m: float,
    ahead: bool,
    least_m: float = LEAST_M,
) -> tuple[float, float]:
    """Return the point so far ahead or back, before the next junction if it is far enough."""
    room_m = lane.length_m - s_m if ahead else s_m
    while lane.junction or (room_m < far_m and room_m < least_m + _MARGIN_M):
        following = _next(network, lane, ahead)
        if following is None:
            raise DoesNotFit
        lane, room_m = following, room_m + following.length_m
    rest_m = max(room_m - far_m, _MARGIN_M)
    at = np.array([lane.length_m - rest_m if ahead else rest_m])
    x, y = np.round(lane.at(at)[0], 3).tolist()
    return x, y


def chain(
    network: Network, lane: RoadLane, back_m: float = _BACK_M, on_m: float = _ON_M
) -> np.ndarray:
    """Return the points of the way straight on over a lane, from before it to after it."""
    lanes = [lane]
    for ahead, far_m in ((False, back_m), (True, on_m)):
        while far_m > 0.0:
            one = _next(network, lanes[-1 if ahead else 0], ahead)
            if one is None:
                break
            lanes.insert(len(lanes) if ahead else 0, one)
            far_m -= one.length_m
    return even(np.vstack([one.points_m for one in lanes]))


def even(points: np.ndarray) -> np.ndarray:
    """Return points about 1 m apart along a line."""
    points = points[np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-3)]
    s = arc_lengths(points)
    return interpolate(np.linspace(0.0, s[-1], max(2, round(s[-1] / _STEP_M) + 1)), s, points)
