"""Plan the mission over a network of lanes: from where the car is to its goals.

python3 -m sdc_package.global_planner REPORT ARG:=VALUE ... writes the first mission of a drive on a
map beside the report, and prints the arguments of all.launch, one per line.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, field
from typing import Iterator, Sequence

import numpy as np
import yaml

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.route import interpolate
from sdc_sim.road.lane_graph import CHANGE_M, LaneGraph, NoRouteError, drawn_places
from sdc_sim.road.network import Network, RoadLane, arc_lengths
from sdc_sim.road.network_file import MapError, load_network

Point = Sequence[float]

# A goal or a car that is farther from all lanes is on none.
NEAR_M = 20.0
_STEP_M = 1.0
# A change of lanes takes so long, and at least CHANGE_M.
_CHANGE_S = 4.0
# The car drives elsewhere if it is so far from the mission, and a lane is nearer by this.
_LOST_M, _NEARER_M = 3.0, 1.0
_BACK_M, _AHEAD_M = 5.0, 15.0


@dataclass(frozen=True)
class Mission:
    """A way over lanes.

    Attributes:
        points_m: (N, 2) points, about 1 m apart [m]
        limits_mps: (N,) speed limit at each of them [m/s]
        lanes: ids of the lanes, in order
        ends_m: distance along the points of each goal [m]
        time_s: time at the speed limits [s]
    """

    points_m: np.ndarray = field(repr=False)
    limits_mps: np.ndarray = field(repr=False)
    lanes: tuple[str, ...]
    ends_m: tuple[float, ...]
    time_s: float


class GlobalPlanner:
    """Plans a mission to the goals, and another one when it is needed.

    A new mission is planned for new goals, when a lane of the mission is closed, and when the car
    is on a lane that the mission does not lead to.

    Attributes:
        network: the lanes
        goals: points (x, y) to which the car drives, in order; passed ones are removed [m]
        closed: ids of closed lanes
        mission: the last mission, None before the first one
        graph: the ways between the lanes
    """

    def __init__(self, network: Network, goals: Sequence[Point] = ()):
        self.network = network
        self.closed: set[str] = set()
        self.mission: Mission | None = None
        self.graph = LaneGraph(network)
        self.drive_to(goals)

    def drive_to(self, goals: Sequence[Point]) -> None:
        """Replace the goals; the next update plans a mission to them."""
        self.goals = [(float(x), float(y)) for x, y in goals]
        self._ends_m: list[float] = []
        self._due = bool(self.goals)

    def close(self, lane: str) -> None:
        """Close a lane; the next update plans another mission if this one leads over it.

        Raises:
            ValueError: there is no such lane
        """
        if lane not in self.network.lanes:
            raise ValueError(f"the map {self.network.name} has no lane {lane!r}")
        self.closed.add(lane)
        self._due |= self.mission is not None and lane in self.mission.lanes

    def update(self, x_m: float, y_m: float, yaw_rad: float) -> Mission | None:
        """Return a new mission if one is needed.

        Args:
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]

        Raises:
            NoRouteError: a goal cannot be reached; the last mission stays
        """
        lost = self.mission is not None and self._is_lost(x_m, y_m, yaw_rad)
        if not (self._due or lost):
            return None
        self._due = False
        self.mission = mission = self.plan(x_m, y_m, yaw_rad)
        self._line = Polyline(mission.points_m.tolist(), extend=False)
        self._s_m, self._ends_m = 0.0, list(mission.ends_m)
        return mission

    def plan(self, x_m: float, y_m: float, yaw_rad: float | None = None) -> Mission:
        """Return the fastest mission from a pose to all goals, in order.

        Raises:
            NoRouteError: the car is on no lane, or a goal cannot be reached
        """
        start = self.network.nearest(x_m, y_m, yaw_rad, NEAR_M)
        if start is None:
            raise NoRouteError(f"no lane is within {NEAR_M:g} m of ({x_m:.1f}, {y_m:.1f})")
        lanes: list[str] = []
        pieces, ends_m, time_s = [], [], 0.0
        for x, y in self.goals:
            name = f"the goal ({x:.1f}, {y:.1f})"
            goal = self.network.nearest(x, y, within_m=NEAR_M)
            if goal is None:
                raise NoRouteError(f"{name} is on no lane; give a point within {NEAR_M:g} m of one")
            try:
                way, seconds = self.graph.route(start, goal, self.closed)
            except NoRouteError as error:
                text = f"{name} cannot be reached from lane {start.lane}: {error}"
                raise NoRouteError(text) from None
            time_s += seconds
            lanes += way
            pieces += list(self._pieces(way, start.s_m, goal.s_m))
            ends_m.append(sum(float(arc_lengths(points)[-1]) for points, _ in pieces))
            start = goal
        return Mission(*_resampled(pieces), tuple(lanes), tuple(ends_m), time_s)

    def _is_lost(self, x_m: float, y_m: float, yaw_rad: float) -> bool:
        """Return whether the car is on a lane to which the mission does not lead."""
        place = self._line.project(x_m, y_m, self._s_m, _BACK_M, _AHEAD_M)
        self._s_m = place.s_m
        while len(self._ends_m) > 1 and place.s_m > self._ends_m[0]:
            del self._ends_m[0], self.goals[0]
        if place.distance_m < _LOST_M:
            return False
        lane = self.network.nearest(x_m, y_m, yaw_rad)
        return lane is not None and place.distance_m - abs(lane.cross_track_m) > _NEARER_M

    def _pieces(
        self, way: Sequence[str], start_m: float, end_m: float
    ) -> Iterator[tuple[np.ndarray, float]]:
        """Return points and speed limit of each stretch of a way [m, m/s].

        A stretch of road with several lanes is shared between them.
        """
        lanes = [self.network.lanes[name] for name in way]
        first = 0
        while first < len(lanes):
            last = first  # of the lanes beside one another
            while last + 1 < len(lanes) and way[last + 1] in (lanes[last].left, lanes[last].right):
                last += 1
            begin = start_m / lanes[first].length_m if first == 0 else 0.0
            end = end_m / lanes[last].length_m if last == len(lanes) - 1 else 1.0
            window = (end - begin) / (last - first + 1)
            for number in range(first, last + 1):
                at = begin + window * (number - first)
                if number > first:
                    length_m = max(CHANGE_M, _CHANGE_S * lanes[number].speed_limit_mps)
                    until = at + min(window, length_m / lanes[number].length_m)
                    points = _change(lanes[number - 1], lanes[number], at, until)
                    yield points, lanes[number].speed_limit_mps
                    at = until
                yield _stretch(lanes[number], at, begin + window * (number - first + 1))
            first = last + 1


def file_points(points_m: np.ndarray) -> np.ndarray:
    """Return points (N, 2) as they are after they were written to the file of ./drive [m]."""
    return np.array([[float(f"{x:.6f}"), float(f"{y:.6f}")] for x, y in points_m.tolist()])


def _stretch(lane: RoadLane, start: float, end: float) -> tuple[np.ndarray, float]:
    """Return the points of a lane between shares of its length, and its speed limit [m, m/s]."""
    start_m, end_m = start * lane.length_m, end * lane.length_m
    inside = lane.s_m[(lane.s_m > start_m) & (lane.s_m < end_m)]
    return lane.at(np.array([start_m, *inside, end_m])), lane.speed_limit_mps


def _change(lane: RoadLane, other: RoadLane, start: float, end: float) -> np.ndarray:
    """Return the points of a smooth change between lanes, between shares of their lengths."""
    t = np.linspace(0.0, 1.0, int((end - start) * lane.length_m / _STEP_M) + 2)
    share = start + (end - start) * t
    weight = (t**3 * (10.0 - 15.0 * t + 6.0 * t * t))[:, None]
    ways = (one.at(share * one.length_m) for one in (lane, other))
    return (1.0 - weight) * next(ways) + weight * next(ways)


def _resampled(pieces: Sequence[tuple[np.ndarray, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return points about 1 m apart along pieces of lines, and the speed limit at each."""
    points = np.vstack([part for part, _ in pieces])
    limits = np.repeat([limit for _, limit in pieces], [len(part) for part, _ in pieces])
    s = arc_lengths(points)
    kept = np.append(True, np.diff(s) > 1e-3)
    points, limits, s = points[kept], limits[kept], s[kept]
    at = np.linspace(0.0, s[-1], max(2, round(s[-1] / _STEP_M) + 1))
    here = np.minimum(np.searchsorted(s, at, side="right") - 1, len(s) - 1)
    return interpolate(at, s, points), limits[here]


def first_mission(
    planner: GlobalPlanner, start: Point | None, goals: Sequence[Point], seed: int
) -> Mission:
    """Return the mission from a start to goals; what is not given is drawn from the seed.

    Raises:
        NoRouteError: a goal cannot be reached
    """
    if not (start and goals):
        begin, end = drawn_places(planner.graph, seed, start)
        start, goals = start or begin, goals or [end]
    planner.drive_to(goals)
    return planner.plan(start[0], start[1])


def launch_arguments(report: str, given: dict[str, str]) -> dict[str, str]:
    """Write the first mission beside the report; return the arguments of all.launch.

    Raises:
        ValueError: an argument is not valid, or a goal cannot be reached
    """
    options = yaml.safe_load(given.get("sim_options") or "{}")
    if given.get("seed"):
        seed = int(given["seed"]) if given["seed"].isdecimal() else -1
        if options.setdefault("seed", seed) != seed or seed < 0:
            text = "must be a number of at least 0, and no other than the seed in sim_options"
            raise ValueError(f"seed:={given['seed']}: {text}")
    planner = GlobalPlanner(load_network(given["map"]))
    start, goals = _points("start", given), _points("goal", given)
    mission = first_mission(planner, start[0] if start else None, goals, options.get("seed", 0))
    path = os.path.splitext(os.path.abspath(report))[0] + ".route.csv"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    # The y axis of a waypoint file points to the right.
    np.savetxt(path, mission.points_m * (1.0, -1.0), fmt="%.6f", delimiter=",")
    return {
        **given,
        "waypoints_path": path,
        "map": os.path.abspath(os.path.expanduser(given["map"])),
        "goal": str([list(goal) for goal in planner.goals]),
        "sim_options": yaml.safe_dump(options, default_flow_style=True, width=10**6).strip(),
    }


def _points(name: str, given: dict[str, str]) -> list[Point]:
    text = given.get(name, "")
    try:
        numbers = [[float(one) for one in part.split(",")] for part in text.split(";") if text]
    except ValueError:
        numbers = [[]]
    if any(len(point) != 2 for point in numbers) or not np.isfinite(numbers).all():
        raise ValueError(f"{name}:={text}: must be X,Y [m]")
    return list(numbers)


def main() -> None:
    """Run the command line."""
    given = dict(one.split(":=", 1) for one in sys.argv[2:] if ":=" in one)
    try:
        arguments = launch_arguments(sys.argv[1], given)
    except (MapError, ValueError) as error:
        sys.exit(f"drive: {error}")
    print("\n".join([f"{name}:={value}" for name, value in arguments.items()]))


if __name__ == "__main__":
    main()
