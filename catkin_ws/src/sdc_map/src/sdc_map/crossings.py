"""The junctions that a route crosses, and who has right of way there."""

from __future__ import annotations

import math
from typing import Iterator, NamedTuple, Sequence, Tuple

import numpy as np

from sdc_common.geometry.route import Route
from sdc_map.network import STOP, Connection, LanePlace, Network, Way, edge_of

# Places on the route at which the lane is looked up are so far apart, and so near to it [m].
_STEP_M, _LANE_M = 2.0, 2.5
# Lanes from which a road user may come are followed so far back.
_UPSTREAM_M = 200.0
# Points on two ways that are nearer than this are in the space that both need.
_BODY_M, _SAMPLE_M = 3.0, 1.0
# Two ways run along each other where the cosine of the angle between them is greater.
_ALONG = 0.9
# A car beside this space stops before it; a stop so far in it still lets others pass [m].
BESIDE_M, OVER_M = 0.3, 1.0


class Conflict(NamedTuple):
    """A way through a junction that meets that of the car."""

    # Of each lane that leads to the way or is a part of it: the distance from the end of the lane
    # to the junction, negative inside [m].
    lanes: dict[str, float]
    own_m: tuple[float, float]  # the space that both need, along the car's route
    its_m: tuple[float, float]  # the same along the other way, from where the junction begins
    is_first: bool  # whether it has right of way over that of the car
    merges: bool  # whether it leads to the same road, or runs along that of the car where they meet

    def away_m(self, network: Network, place: LanePlace) -> float | None:
        """Return the distance of a place to the junction, None if it is on no lane to it [m]."""
        lane = network.lanes[place.lane]
        if lane.id in self.lanes:
            return self.lanes[lane.id] + lane.length_m - place.s_m
        # In another junction before this one, the nearest lane may lead elsewhere.
        for name in lane.predecessors if lane.junction else ():
            if self.lanes.get(name, 0.0) > 0.0:
                return self.lanes[name] - place.s_m
        return None


class Crossing(NamedTuple):
    """A way of the route through a junction; arc lengths are those along the route [m]."""

    line_m: float  # where the junction begins, with the stop line
    end_m: float  # where it ends
    has_stop_sign: bool
    # Planned speed in the junction, without others [m/s]; workspaces begun before use it.
    mean_mps: float
    conflicts: list[Conflict]
    junction: str  # its name on the map

    def last_stop_m(self, front_m: float) -> float:
        """Return where the centre of a car can stop last, without being in the way of others."""
        spaces_m = [one.own_m[0] - BESIDE_M for one in self.conflicts]
        return max(self.line_m, *spaces_m, 0.0) - front_m + OVER_M


Places = Sequence[Tuple[float, LanePlace]]


def crossings(
    network: Network, route: Route, places: Places, speed_mps: np.ndarray
) -> list[Crossing]:
    """Return the crossings of a route, in order.

    Args:
        network: the lanes
        route: the route
        places: places on the lanes along it
        speed_mps: (N,) planned speed at its points [m/s]
    """
    found: list[Crossing] = []
    last: tuple[LanePlace, float] | None = None  # on the lane before the junction
    is_inside = False
    for s_m, place in places:
        if network.lanes[place.lane].junction:
            is_inside = True
            continue
        if last is not None and is_inside:
            before, before_m = last
            ways, edge = network.ways.get(before.lane, ()), edge_of(place.lane)
            # Of some ways to the same road, which differ in the lane there, the first one.
            way = next((one for one in ways if edge_of(one.connection.end) == edge), None)
            if way is not None:
                found.append(_crossing(network, route, way, before_m, s_m, speed_mps))
        last, is_inside = (place, s_m), False
    return found


def places_along(network: Network, route: Route) -> Iterator[tuple[float, LanePlace]]:
    """Yield arc lengths of a route and the places on the lanes there."""
    z_m = math.nan  # of the last place: the next one is on its level
    for s_m in np.append(np.arange(0.0, route.length_m, _STEP_M), route.length_m).tolist():
        x, y = route.line.point_at(s_m)
        place = network.nearest(x, y, route.line.heading_at(s_m), _LANE_M, z_m)
        if place is not None:
            z_m = network.height_of(place)
            yield s_m, place


def limits_along(network: Network, route: Route) -> np.ndarray:
    """Return (N,) speed limits at the points of a route, inf before its first lane [m/s].

    In a junction, where lanes overlap, the limit is that of the lane before it.
    """
    places = ((s_m, network.lanes[place.lane]) for s_m, place in places_along(network, route))
    found = [(s_m, lane.speed_limit_mps) for s_m, lane in places if not lane.junction]
    s_m, limits_mps = np.array([(-math.inf, math.inf), *found]).T
    return limits_mps[np.searchsorted(s_m, route.s, side="right") - 1]


def heights_along(network: Network, route: Route, places: Places) -> np.ndarray:
    """Return the height (N,) of the lanes at the points of a route [m]; see `places_along`."""
    s_m, heights_m = zip(*((s, network.height_of(place)) for s, place in places))
    return np.interp(route.s, s_m, heights_m)


def _crossing(
    network: Network, route: Route, way: Way, before_m: float, after_m: float, speed_mps: np.ndarray
) -> Crossing:
    """Return a way between two places on the route, before its junction and after it [m]."""
    own, reach = way.connection, (before_m, 1.0, after_m - before_m + 1.0)
    start, end = network.lanes[own.start], network.lanes[own.end]
    (start_x, start_y), (end_x, end_y) = start.points_m[-1].tolist(), end.points_m[0].tolist()
    line_m = route.line.project(start_x, start_y, *reach).s_m
    end_m = route.line.project(end_x, end_y, *reach).s_m
    own_s = np.arange(line_m, end_m + _SAMPLE_M, _SAMPLE_M)
    points = np.array([route.line.point_at(s) for s in own_s.tolist()])
    conflicts = [
        _conflict(network, one, own, own_s, points, one in way.first)
        for one in network.junctions[way.junction].connections
        if edge_of(one.start) != edge_of(own.start) and not network.is_over(own, one)
    ]
    has_stop_sign = own.line == STOP and own.signal < 0
    inside = speed_mps[(route.s >= line_m) & (route.s <= end_m)]
    mean_mps = float(inside.mean()) if len(inside) else math.inf
    found = [one for one in conflicts if one]
    return Crossing(line_m, end_m, has_stop_sign, mean_mps, found, way.junction)


def _conflict(
    network: Network,
    way: Connection,
    own: Connection,
    own_s: np.ndarray,
    own_points: np.ndarray,
    is_first: bool,
) -> Conflict | None:
    """Return where a way meets the car's own, None if it does not."""
    lanes, inside_m, points, s = {}, 0.0, [], []
    for name in way.through:
        lane = network.lanes[name]
        # A lane of a direct junction may have no length.
        at = np.arange(0.0, max(lane.length_m, 1e-3), _SAMPLE_M)
        points.append(lane.at(at))
        s.append(inside_m + at)
        inside_m += lane.length_m
        lanes[name] = -inside_m
    if not points:
        return None
    its_s = np.concatenate(s)
    its_points = np.concatenate(points)
    away_m = np.hypot(*(own_points[:, None] - its_points).transpose(2, 0, 1))
    near = away_m < _BODY_M
    merges = edge_of(way.end) == edge_of(own.end)
    if near.any():
        together = np.flatnonzero(near.any(axis=1))
        middle = int(together[len(together) // 2])
        its_middle = int(away_m[middle].argmin())
        along = _direction(own_points, middle) @ _direction(its_points, its_middle)
        merges |= along > _ALONG
    else:
        if not is_first:
            return None
        near[:] = True  # they end on lanes beside one another
    mine, its = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    queue = [(way.start, 0.0)]
    while queue:
        name, distance_m = queue.pop()
        if name == own.start or distance_m >= lanes.get(name, _UPSTREAM_M):
            continue
        lanes[name] = distance_m
        lane = network.lanes[name]
        queue += [(one, distance_m + lane.length_m) for one in lane.predecessors]
    own_m = float(own_s[mine[0]]), float(own_s[mine[-1]])
    its_m = float(its_s[its[0]]), float(its_s[its[-1]])
    return Conflict(lanes, own_m, its_m, is_first, bool(merges))


def _direction(points_m: np.ndarray, index: int) -> np.ndarray:
    """Return the unit vector along a line at one of its points."""
    first = min(index, len(points_m) - 2)
    step_m = points_m[first + 1] - points_m[first]
    return step_m / max(float(np.hypot(*step_m)), 1e-9)


def time_s(distance_m: float, speed_mps: float, most_mps: float, mps2: float) -> float:
    """Return the time for a distance, accelerating up to a speed; for workspaces begun before."""
    distance_m = max(distance_m, 0.0)
    if speed_mps >= most_mps:
        return distance_m / speed_mps
    until_m = (most_mps**2 - speed_mps**2) / (2.0 * mps2)
    if distance_m <= until_m:
        return (math.sqrt(speed_mps**2 + 2.0 * mps2 * distance_m) - speed_mps) / mps2
    return (most_mps - speed_mps) / mps2 + (distance_m - until_m) / most_mps
