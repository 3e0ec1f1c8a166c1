"""Find the fastest way over a network of lanes."""

from __future__ import annotations

from typing import AbstractSet, Iterable, Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from sdc_map.network import LanePlace, Network, RoadLane

# A change of lanes takes so long, and at least so much of a lane.
CHANGE_S = 4.0
CHANGE_M = 25.0
# Drawn places keep this distance from the ends of a lane, and from one another along the way.
_MARGIN_M, _SHORTEST_M = 5.0, 100.0
_DRAWS = 1000


class NoRouteError(ValueError):
    """A goal that cannot be reached; the message is one line."""


class LaneGraph:
    """The lanes for cars and the ways from one to the next.

    Leaving a lane at its end costs its length at its speed limit, and a change to a neighbour costs
    CHANGE_S, up to twice as much where it must be shorter than usual.
    """

    def __init__(self, network: Network):
        self.network = network
        self._lanes = network.driving
        self._number = {lane.id: number for number, lane in enumerate(self._lanes)}
        costs: dict[tuple[int, int], float] = {}  # by the numbers of the next lane and of a lane
        for number, lane in enumerate(self._lanes):
            for name, cost_s in self._leads(lane):
                edge = self._number[name], number
                costs[edge] = min(cost_s, costs.get(edge, np.inf))
        ends, starts = zip(*costs) if costs else ((), ())
        size = len(self._lanes), len(self._lanes)
        self._costs_s = csr_matrix(([*costs.values()], (ends, starts)), size)

    def _leads(self, lane: RoadLane) -> Iterable[tuple[str, float]]:
        """Return the lanes that follow a lane or lie beside it, with the costs [s]."""
        for name in lane.successors:
            if name in self._number:
                yield name, lane.length_m / lane.speed_limit_mps
        for name in (lane.left, lane.right):
            if name in self._number and lane.length_m >= CHANGE_M:
                yield name, _change_s(lane, lane.length_m)

    def route(
        self, start: LanePlace, goal: LanePlace, closed: AbstractSet[str] = frozenset()
    ) -> tuple[list[str], float]:
        """Return the lanes of the fastest way and its time [s].

        Two lanes that follow one another are neighbours, or one leads into the other.

        Args:
            start: where the way begins
            goal: where it ends
            closed: lanes that must not be entered

        Raises:
            NoRouteError: there is no way
        """
        first, last = self._number[start.lane], self._number[goal.lane]
        lane, end = self._lanes[first], self._lanes[last]
        before_s = -start.s_m / lane.speed_limit_mps
        after_s = goal.s_m / end.speed_limit_mps
        sources = [([first], 0.0)]
        has_room = lane.length_m - start.s_m >= CHANGE_M
        beside = {number: way for way, number in self._beside(first)} if has_room else {}
        ahead_m = goal.s_m * lane.length_m / end.length_m - start.s_m
        behind = ahead_m < CHANGE_M * (len(beside[last]) - 1 if last in beside else 0)
        if (last == first or last in beside) and behind or not has_room and last != first:
            # The way leaves this stretch of road at its end, and returns to it if it must.
            sources = [
                ([*way, self._number[name]], cost_s + CHANGE_S * (len(way) - 1))
                for way in ([first], *beside.values())
                for name, cost_s in self._leads(self._lanes[way[-1]])
                if name in self._lanes[way[-1]].successors
            ]
        shut = {self._number[name] for name in closed if name in self._number}
        late_s = _change_s(end, max(goal.s_m, CHANGE_M)) - _change_s(end, end.length_m)
        left_s, following = self._search(last, shut, late_s)
        ways = [
            (cost_s + left_s[way[-1]], way) for way, cost_s in sources if shut.isdisjoint(way[1:])
        ]
        cost_s, way = min(ways, default=(np.inf, []))
        if not np.isfinite(cost_s):
            raise NoRouteError("no way leads there" + (", past the closed lanes" if shut else ""))
        while way[-1] != last:
            way.append(int(following[way[-1]]))
        return [self._lanes[number].id for number in way], cost_s + before_s + after_s

    def _search(
        self, last: int, shut: AbstractSet[int], late_s: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the cost from each lane to the last one [s], and the next lane on that way.

        A change to the last lane costs so much more, since the goal is before its end.
        """
        costs_s = self._costs_s.copy()
        begins = costs_s.indptr
        for number in shut:
            costs_s.data[begins[number] : begins[number + 1]] = np.inf
        into = slice(begins[last], begins[last + 1])
        beside = [number for _, number in self._beside(last)]
        costs_s.data[into] += late_s * np.isin(costs_s.indices[into], beside)
        return dijkstra(costs_s, indices=last, return_predecessors=True)

    def _beside(self, first: int) -> Iterable[tuple[list[int], int]]:
        """Return the lanes of the same stretch, with the changes to each."""
        for side in ("left", "right"):
            way = [first]
            while True:
                number = self._number.get(getattr(self._lanes[way[-1]], side))
                if number is None or number in way or self._lanes[number].length_m < CHANGE_M:
                    break
                way = [*way, number]
                yield way, number


def change_m(lane: RoadLane) -> float:
    """Return the usual length of a change to a lane [m]."""
    return max(CHANGE_M, CHANGE_S * lane.speed_limit_mps)


def _change_s(lane: RoadLane, room_m: float) -> float:
    """Return the cost of a change of lanes within a length [s]."""
    return CHANGE_S * min(max(1.0, change_m(lane) / room_m), 2.0)


def drawn_places(
    graph: LaneGraph, seed: int, start: Sequence[float] | None = None
) -> tuple[Sequence[float], Sequence[float]]:
    """Return a start and a goal (x, y) at random places of lanes between which there is a way.

    Args:
        graph: the lanes
        seed: seed of the random numbers
        start: the start, None to draw it, too [m]

    Raises:
        NoRouteError: no such places were found
    """
    random, network = np.random.default_rng(seed), graph.network
    lanes = [lane for lane in network.driving if not lane.junction]
    lanes = [lane for lane in lanes if lane.length_m > 2.0 * _MARGIN_M]
    lengths = np.array([lane.length_m for lane in lanes])
    for _ in range(_DRAWS if lanes else 0):
        drawn: list[Sequence[float]] = []
        for number in random.choice(len(lanes), 2, p=lengths / lengths.sum()):
            s_m = random.uniform(_MARGIN_M, lanes[number].length_m - _MARGIN_M)
            drawn.append(tuple(np.round(lanes[number].at(np.array([s_m]))[0], 3).tolist()))
        begin, end = (network.nearest(*point) for point in (start or drawn[0], drawn[1]))
        assert begin is not None and end is not None
        try:
            way, _ = graph.route(begin, end)
        except NoRouteError:
            continue
        ways = [network.lanes[name] for name in way]
        length_m = sum(a.length_m for a, b in zip(ways, ways[1:]) if b.id in a.successors)
        if length_m - begin.s_m + end.s_m >= _SHORTEST_M:
            return start or drawn[0], drawn[1]
    raise NoRouteError(f"the map {network.name} has no way of {_SHORTEST_M:g} m to draw")
