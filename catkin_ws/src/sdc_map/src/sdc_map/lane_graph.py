"""Find the fastest way over a network of lanes."""

from __future__ import annotations

import heapq
from typing import AbstractSet, Iterable, Mapping, Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from sdc_map.network import LanePlace, Network, RoadLane

# A change of lanes takes so long, and at least so much of a lane.
CHANGE_S = 4.0
CHANGE_M = 25.0
_LANDMARKS = 24
_UNREACHABLE_S = 1e9
# Drawn places keep this distance from the ends of a lane, and from one another along the way.
_MARGIN_M, _SHORTEST_M = 5.0, 100.0
_DRAWS = 1000


class NoRouteError(ValueError):
    """A goal that cannot be reached; the message is one line."""


class LaneGraph:
    """The lanes for cars and the ways from one to the next.

    Leaving a lane at its end costs its length at its speed limit, and a change to a neighbour costs
    CHANGE_S, up to twice as much where it must be shorter than usual. The search is A* with
    landmarks: distances from and to a few lanes are computed once and bound those between all
    others.

    Reference: A. V. Goldberg and C. Harrelson, "Computing the Shortest Path: A* Search Meets Graph
    Theory", SODA 2005.
    """

    def __init__(self, network: Network):
        self.network = network
        cars = {lane.id: lane for lane in network.driving}
        leads = {name: list(_leads(lane, cars)) for name, lane in cars.items()}
        comes: dict[str, list[str]] = {name: [] for name in cars}
        for name, edges in leads.items():
            for following, _ in edges:
                comes[following].append(name)
        # A lane between two others, as most in junctions, is a part of the edge between them.
        inner = {name for name in cars if len(leads[name]) == len(comes[name]) == 1}
        self._lanes = sorted(network.driving, key=lambda lane: lane.id in inner)
        self._outer = len(cars) - len(inner)
        self._number = {lane.id: number for number, lane in enumerate(self._lanes)}
        self._edges = [
            [(self._number[name], cost) for name, cost in leads[lane.id]] for lane in self._lanes
        ]
        self._long_edges = [[self._extended(*one) for one in edges] for edges in self._edges]
        self._place_landmarks()

    def _extended(self, following: int, cost_s: float) -> tuple[int, float, list[int]]:
        """Return the end of an edge behind all inner lanes, its cost, and these lanes."""
        through: list[int] = []
        while following >= self._outer and following not in through:
            through.append(following)
            ((following, more_s),) = self._edges[following]
            cost_s += more_s
        return following, cost_s, through

    def _place_landmarks(self) -> None:
        rows = [(i, j, cost) for i, edges in enumerate(self._edges) for j, cost in edges]
        i, j, cost = zip(*rows) if rows else ((), (), ())
        graph = csr_matrix((cost, (i, j)), (len(self._lanes), len(self._lanes)))
        landmark, bounds = 0, []
        nearest_s = np.full(len(self._lanes), np.inf)
        for _ in range(_LANDMARKS):
            there, back = (
                np.minimum(dijkstra(one, indices=landmark), _UNREACHABLE_S)
                for one in (graph, graph.T)
            )
            # From v to t it is at least as far as from a landmark to t, less from it to v; and as
            # from v to the landmark, less from t to it.
            bounds += [-there, back]
            nearest_s = np.minimum(nearest_s, np.minimum(there, back))
            landmark = int(np.argmax(np.where(nearest_s < _UNREACHABLE_S, nearest_s, -1.0)))
        self._bounds = np.array(bounds)
        self._outer_bounds = np.ascontiguousarray(self._bounds[:, : self._outer])

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
            ways = [[first], *beside.values()]
            sources = [
                ([*way, j], cost + CHANGE_S * (len(way) - 1))
                for way in ways
                for j, cost in self._edges[way[-1]]
                if self._lanes[j].id in self._lanes[way[-1]].successors
            ]
        shut = {self._number[name] for name in closed if name in self._number}
        late_s = _change_s(end, max(goal.s_m, CHANGE_M)) - _change_s(end, end.length_m)
        found = self._search(sources, last, shut, late_s)
        if found is None:
            raise NoRouteError("no way leads there" + (", past the closed lanes" if shut else ""))
        way, cost_s = found
        return [self._lanes[number].id for number in way], cost_s + before_s + after_s

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

    def _search(
        self,
        sources: list[tuple[list[int], float]],
        last: int,
        shut: AbstractSet[int],
        late_s: float,
    ) -> tuple[list[int], float] | None:
        """Return the lanes and the cost of the cheapest way from a source to the last lane.

        A change to the last lane costs so much more, since the goal is before its end.
        """
        beside = {number for _, number in self._beside(last)}
        bounds = self._outer_bounds - self._bounds[:, last : last + 1]
        left_s = np.append(np.max(bounds, axis=0, initial=0.0), 0.0)
        outer = self._outer
        queue: list[tuple[float, int]] = []
        best: dict[int, float] = {}
        # Of each lane that was reached: the lane before it, None for a source, and those between.
        came: dict[int, tuple[int | None, list[int]]] = {}
        for way, cost in sources:
            if cost < best.get(way[-1], np.inf) and shut.isdisjoint(way[1:]):
                best[way[-1]], came[way[-1]] = cost, (None, way[:-1])
                heapq.heappush(queue, (cost + left_s[min(way[-1], outer)], way[-1]))
        done: set[int] = set()
        while queue:
            bound, number = heapq.heappop(queue)
            if number == last or bound >= _UNREACHABLE_S:
                break
            if number in done:
                continue
            done.add(number)
            for following, cost, through in self._long_edges[number]:
                if last >= outer and last in through:
                    through = through[: through.index(last)]
                    following, cost = last, self._cost(number, [*through, last])
                total = best[number] + cost + late_s * (following == last and number in beside)
                if total < best.get(following, np.inf) and (
                    not shut or shut.isdisjoint([*through, following])
                ):
                    best[following], came[following] = total, (number, through)
                    heapq.heappush(queue, (total + left_s[min(following, outer)], following))
        return None if last not in best else (_way_to(last, came), best[last])

    def _cost(self, number: int, through: Sequence[int]) -> float:
        """Return the cost of a way along edges [s]."""
        total_s = 0.0
        for following in through:
            total_s += next(cost for end, cost in self._edges[number] if end == following)
            number = following
        return total_s


def _way_to(last: int, came: Mapping[int, tuple[int | None, list[int]]]) -> list[int]:
    """Return the lanes of a way, from the lane before each lane and those between."""
    way: list[int] = []
    number: int | None = last
    while number is not None:
        before, through = came[number]
        way = [*through, number, *way]
        number = before
    return way


def _leads(lane: RoadLane, cars: Mapping[str, RoadLane]) -> Iterable[tuple[str, float]]:
    """Return the lanes that follow one another or lie beside it, with the costs [s]."""
    for name in lane.successors:
        if name in cars:
            yield name, lane.length_m / lane.speed_limit_mps
    for name in (lane.left, lane.right):
        if name in cars and lane.length_m >= CHANGE_M:
            yield name, _change_s(lane, lane.length_m)


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
