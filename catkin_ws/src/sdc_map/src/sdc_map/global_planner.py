"""Plan the mission over a network of lanes: from where the car is to its goals."""

from __future__ import annotations

import math
from typing import Callable, Sequence

from sdc_common.geometry.polyline import Polyline
from sdc_map.lane_graph import LaneGraph, NoRouteError
from sdc_map.mission import Mission, Point, plan_mission
from sdc_map.network import Network

# The car drives elsewhere if it is so far from the mission, and a lane is nearer by this.
_LOST_M, _NEARER_M = 3.0, 1.0
_BACK_M, _AHEAD_M = 5.0, 15.0


class GlobalPlanner:
    """Plans a mission to the goals, and another one when it is needed.

    A new mission is planned for new goals, when a lane of the mission is closed, and when the car
    is on a lane that the mission does not lead to.

    Attributes:
        network: the lanes
        goals: points (x, y) to which the car drives, in order; passed ones are removed [m]
        closed: ids of closed lanes
        mission: the last mission, None before the first one
        problem: why the last update gave no mission although one was needed, "" if none was
        graph: the ways between the lanes
        on_mission: called with each new mission
    """

    def __init__(self, network: Network, goals: Sequence[Point] = ()):
        self.network = network
        self.closed: set[str] = set()
        self.problem = ""
        self.mission: Mission | None = None
        self.graph = LaneGraph(network)
        self.on_mission: Callable[[Mission], None] = lambda _: None
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

    def update(
        self, x_m: float, y_m: float, yaw_rad: float, z_m: float = math.nan
    ) -> Mission | None:
        """Return a new mission if one is needed.

        Args:
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]
            z_m: height of the car, NaN if it is not known [m]

        Raises:
            NoRouteError: a goal cannot be reached, and there is no mission yet that could stay
        """
        self.problem = ""
        lost = self.mission is not None and self._is_lost(x_m, y_m, yaw_rad, z_m)
        if not (self._due or lost):
            return None
        self._due, pose = False, (x_m, y_m, yaw_rad)
        try:
            mission = plan_mission(self.graph, self.goals, *pose, self.closed, z_m)
        except NoRouteError as error:
            if self.mission is None:
                raise
            self.problem = str(error)
            return None
        self.mission = mission
        self._line = Polyline(mission.points_m.tolist(), extend=False)
        self._s_m, self._ends_m = 0.0, list(mission.ends_m)
        self.on_mission(mission)
        return mission

    def _is_lost(self, x_m: float, y_m: float, yaw_rad: float, z_m: float) -> bool:
        """Return whether the car is on a lane to which the mission does not lead."""
        place = self._line.project(x_m, y_m, self._s_m, _BACK_M, _AHEAD_M)
        self._s_m = place.s_m
        while len(self._ends_m) > 1 and place.s_m > self._ends_m[0]:
            del self._ends_m[0], self.goals[0]
        if place.distance_m < _LOST_M:
            return False
        lane = self.network.nearest(x_m, y_m, yaw_rad, z_m=z_m)
        if lane is None or place.distance_m - abs(lane.cross_track_m) <= _NEARER_M:
            return False
        # Beside a lane of the mission, the local planner passes another road user.
        assert self.mission is not None
        lanes = [self.network.lanes[name] for name in self.mission.lanes]
        return lane.lane not in {name for one in lanes for name in (one.left, one.right)}
