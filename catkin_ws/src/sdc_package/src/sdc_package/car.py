"""The car without ROS: `command = Car.step(observation)`.

The nodes local_planner.py and simple_controller.py call the same two halves, `LocalPlanner.plan`
and `Controller.command`, with what they receive.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Mapping, Protocol

import numpy as np

from sdc_common.driving import Command, Observation, Path, points_as_sent
from sdc_common.planning.stop_line import StopLine
from sdc_package.controller import Controller
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner, OffRouteError, PlannerSettings
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch

if TYPE_CHECKING:
    from sdc_map.global_planner import GlobalPlanner


class PathPlanner(Protocol):
    """Plans the path ahead."""

    @property
    def reason(self) -> str:
        """What limits the speed at the start of the last path, see speed_reasons; "" if unknown."""

    @property
    def detail(self) -> str:
        """Because of which road user, "" if the reason says it all."""

    def plan(self, observation: Observation) -> Path:
        """Return the path ahead of the car.

        Raises:
            OffRouteError: there is none
        """
        raise NotImplementedError


class MissionDriver:
    """Plans the path ahead along a mission, with stops at its traffic lights.

    Args:
        waypoints_m: (N, 2) waypoints of the mission [m]
        settings: parameters of the local planner
        stop_lines: stop line of each traffic light by its id
        missions: plans another mission when it is needed, None for this one alone
        road_mps: (N,) speed limits at the waypoints, None for no limits [m/s]
    """

    detail = ""

    def __init__(
        self,
        waypoints_m: np.ndarray,
        settings: PlannerSettings,
        stop_lines: Mapping[int, StopLine] | None = None,
        missions: GlobalPlanner | None = None,
        road_mps: np.ndarray | None = None,
    ):
        self._settings, self._missions = settings, missions
        self._follow(waypoints_m, road_mps)
        self._lights = TrafficLightMonitor(settings.traffic_lights)
        self._lights.lines = dict(stop_lines or {})
        self._rows, self._path = np.empty((0, 3)), Path(())

    def _follow(
        self, waypoints_m: np.ndarray, road_mps: np.ndarray | None, start_mps: float = 0.0
    ) -> None:
        points = points_as_sent(waypoints_m)
        if road_mps is not None:
            road_mps = np.asarray(road_mps, np.float32).astype(float)
        self._planner = LocalPlanner(points, self._settings, road_mps, start_mps)
        self._search = WaypointSearch(self._planner.route.points)

    @property
    def reason(self) -> str:
        """What limits the speed at the start of the last path."""
        return self._planner.reason

    def plan(self, observation: Observation) -> Path:
        """See PathPlanner; the same object as long as the path is the same."""
        x, y = observation.x_m, observation.y_m
        if self._missions is not None:
            mission = self._missions.update(x, y, observation.yaw_rad, observation.z_m)
            if mission is not None:
                self._follow(mission.points_m, mission.limits_mps, observation.speed_mps)
        self._lights.states = dict(observation.light_states)
        first = self._search.first_ahead(x, y)
        rows = self._planner.plan(first, x, y, observation.yaw_rad, observation.obstacles)
        rows = self._planner.stop_for(self._lights, rows, observation.speed_mps)
        if rows is not self._rows:
            self._rows, self._path = rows, Path.from_rows(rows)
        return self._path


class Car:
    """Planner and controller of the car.

    Args:
        planner: plans the path ahead
        controller: follows it
        path_timeout_s: time without a path after which the car brakes to a stop [s]

    Attributes:
        path: the path of the last step, None if there was none
        reason: what limited the speed in the last step, "" if unknown
        detail: because of whom, "" if the reason says it all
    """

    def __init__(self, planner: PathPlanner, controller: Controller, path_timeout_s: float):
        self.path: Path | None = None
        self.reason = self.detail = ""
        self._planner, self._controller = planner, controller
        self._path_timeout_s = path_timeout_s
        self._reference = ReferencePath()

    def step(self, observation: Observation) -> Command | None:
        """Return the command that answers an observation.

        Without a path the last command stays in force; after the timeout the car brakes along the
        last path.
        """
        try:
            self.path = self._planner.plan(observation)
        except OffRouteError:
            self.path, self.reason, self.detail = None, "", ""
            last = self._controller.last_answered
            if last is None or observation.stamp_s - last.stamp_s <= self._path_timeout_s:
                return None
            self.reason = "path_timeout"
            return self._controller.stop(observation, self._reference)
        self.reason = self._planner.reason
        self.detail = self._planner.detail
        self._reference.update(self.path.points)
        return self._controller.command(observation, self._reference)
