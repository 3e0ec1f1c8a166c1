"""Plan the path ahead of the car on a map: along its mission, with the rules of the streets."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sdc_common.driving import DetectedObstacle, Observation, Path, other_level, points_as_sent
from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import StopLine
from sdc_map.mirror import negated
from sdc_map.network import Network
from sdc_package.behaviour.manoeuvres import Manoeuvres, StayOnRoute
from sdc_package.behaviour.streets import StreetBehaviour, StreetMargins, name_of
from sdc_package.local_planner import LocalPlanner
from sdc_package.obstacle_prediction import PREDICTION_TIMES_S, Distances, Obstacles
from sdc_package.obstacles import caps_behind
from sdc_package.planner_settings import PlannerSettings
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch

if TYPE_CHECKING:
    from sdc_map.global_planner import GlobalPlanner

# Acceleration of a car that starts [m/s^2], unless it passes another road user.
_STARTS_MPS2 = 1.2
# It aims at a speed that is so much greater than its own [m/s], at a point so far ahead [m].
_AIM_FASTER_MPS = 0.2
_AIM_AHEAD_M = 0.3
# A car whose path is farther to the left of its route passes another road user [m].
_PASSES_M = 1.0
# The level of others is that of the route, from so far behind the car to so far beyond what it
# looks at [m].
_MARGIN_M = 50.0


class StreetPlanner:
    """Plans the path ahead on a network of streets, see PathPlanner.

    Where traffic is on the left, it plans in the mirror image of the streets, by the same rules.

    Args:
        network: the streets
        settings: parameters of the planners
        margins: margins of the car at junctions
        lights: the known traffic lights; `plan` sets their states
        missions: plans another mission when it is needed; None: `follow` sets it
        manoeuvres: decides how far beside its route the car drives: Manoeuvres or StayOnRoute
    """

    def __init__(
        self,
        network: Network,
        settings: PlannerSettings,
        margins: StreetMargins,
        lights: TrafficLightMonitor,
        missions: GlobalPlanner | None = None,
        manoeuvres: type[StayOnRoute] = Manoeuvres,
    ):
        self._settings, self._missions, self._y_sign = settings, missions, network.y_sign
        # Those of the observation, and those where it plans.
        self._known_lights = self._lights = lights
        if self._y_sign < 0.0:
            self._lights = TrafficLightMonitor(lights.margins)
        self._network = network.right_hand
        self._streets = StreetBehaviour(self._network, margins, manoeuvres)
        self._local: LocalPlanner | None = None
        self._rows, self._path = np.empty((0, 3)), Path(())

    @property
    def reason(self) -> str:
        """What limits the speed at the start of the last path."""
        return self._local.reason if self._local else ""

    @property
    def detail(self) -> str:
        """Because of whom, "" if the reason says it all."""
        return self._streets.details.get(self.reason, "")

    @property
    def s_m(self) -> float:
        """Return the car's distance along the route [m]; negative: unknown yet."""
        return self._local.s_m if self._local else -1.0

    def follow(
        self, waypoints_m: np.ndarray, road_mps: np.ndarray | None, start_mps: float = 0.0
    ) -> None:
        """Follow another mission, unless it is the present one.

        Args:
            waypoints_m: (N, 2) waypoints on lanes of the map [m]
            road_mps: (N,) speed limits at the waypoints, None for no limits [m/s]
            start_mps: speed of the car [m/s]

        Raises:
            ValueError: there are fewer than 2 waypoints, one is not finite, one repeats the one
                before it, or they are not on lanes of the map
        """
        points_m = points_as_sent(waypoints_m) * (1.0, self._y_sign)
        if self._local is not None and self._local.is_for(points_m):
            return
        if road_mps is not None:
            road_mps = np.asarray(road_mps, np.float32).astype(float)
        local = LocalPlanner(points_m, self._settings, road_mps, start_mps)
        self._streets.follow(local.route, local.speed, self._settings.limits.braking_mps2)
        self._local, self._search = local, WaypointSearch(local.route.points)

    def resume(self, s_m: float) -> None:
        """Continue from a distance along the route, see `LocalPlanner.resume`."""
        if self._local is not None:
            self._local.resume(s_m)

    def plan(self, observation: Observation) -> Path:
        """See PathPlanner; the same object as long as the path is the same."""
        if self._missions is not None:
            pose = observation.x_m, observation.y_m, observation.yaw_rad
            mission = self._missions.update(*pose, observation.z_m)
            if mission is not None:
                self.follow(mission.points_m, mission.limits_mps, observation.speed_mps)
        if self._y_sign < 0.0:
            others = [negated(one, "y_m", "yaw_rad") for one in observation.obstacles]
            observation = replace(negated(observation, "y_m", "yaw_rad"), obstacles=others)
            lines = self._known_lights.lines.items()
            self._lights.lines = {number: negated(line, "y_m") for number, line in lines}
        x_m, y_m, yaw_rad = observation.x_m, observation.y_m, observation.yaw_rad
        local = self._local
        assert local is not None, "a mission is followed before the first plan"
        rows = local.free_path(self._search.first_ahead(x_m, y_m), x_m, y_m, yaw_rad)
        if not self._network.is_flat:
            observation = self._on_level(local, observation)
        self._lights.states = dict(observation.light_states)
        rows = self._streets.manoeuvres.way.moved(rows, local.ahead)
        rows = self._behind_others(local, rows, observation)
        rows = self._starting_gently(local, rows, observation.speed_mps)
        rows = self._stopping(local, rows, observation)
        if rows is not self._rows:
            self._rows, self._path = rows, Path.from_rows(rows * (1.0, self._y_sign, 1.0))
        return self._path

    def _on_level(self, local: LocalPlanner, observation: Observation) -> Observation:
        """Return what the car observes without road users and lights on other levels.

        They are compared with the route where it is nearest to them: the road may rise.
        """
        route, lines, s_m = local.route, self._lights.lines, local.place.s_m
        ends_m = s_m - _MARGIN_M, s_m + local.horizon_m + _MARGIN_M
        first, last = np.searchsorted(route.s, ends_m)
        points_m, heights_m = route.points[first:last], self._streets.heights_m[first:last]

        def is_on_level(one: DetectedObstacle | StopLine) -> bool:
            away_m = np.hypot(*(points_m - (one.x_m, one.y_m)).T)
            row = int(np.argmin(away_m))
            return not other_level(one.z_m, heights_m[row], away_m[row])

        obstacles = [one for one in observation.obstacles if is_on_level(one)]
        states = {
            number: state
            for number, state in observation.light_states.items()
            if number in lines and is_on_level(lines[number])
        }
        return replace(observation, obstacles=obstacles, light_states=states)

    def _behind_others(
        self, local: LocalPlanner, rows: np.ndarray, observation: Observation
    ) -> np.ndarray:
        """Return rows that keep the distance to those on the path of the car."""
        streets, settings = self._streets, self._settings
        route, place_s_m, speed_mps = local.route, local.place.s_m, observation.speed_mps
        near: Obstacles = nearby(route, place_s_m, observation.obstacles, local.horizon_m)
        obstacles = streets.relevant(place_s_m, speed_mps, near, local.horizon_m)
        if not obstacles:
            return rows
        margins = streets.margins
        distances = Distances(
            settings.obstacles,
            margins.time_gap_s,
            margins.follow_gap_m,
            settings.limits.braking_mps2,
            local.horizon_m,
        )
        s_m, offset_at = route.s[local.ahead], streets.manoeuvres.way.offset_at
        caps = np.array(
            [
                caps_behind(route, s_m, place_s_m, obstacle, distances, speed_mps, offset_at)
                for obstacle in obstacles
            ]
        )
        nearest = obstacles[int(np.argmin(caps[:, 0]))]
        streets.details["obstacle"] = name_of(nearest)
        return local.limited(rows, caps.min(axis=0), "obstacle")

    def _starting_gently(
        self, local: LocalPlanner, rows: np.ndarray, speed_mps: float
    ) -> np.ndarray:
        """Return rows with which a car that is slower than planned accelerates gently."""
        local.note_acceleration(rows, speed_mps)
        passes = self._streets.manoeuvres.way.offset_m.max() >= _PASSES_M
        if passes or speed_mps >= rows[0, 2]:
            return rows
        beyond_m = np.maximum(local.route.s[local.ahead] - local.place.s_m - _AIM_AHEAD_M, 0.0)
        caps = np.sqrt((speed_mps + _AIM_FASTER_MPS) ** 2 + 2.0 * _STARTS_MPS2 * beyond_m)
        return local.limited(rows, caps, "accelerating")

    def _stopping(
        self, local: LocalPlanner, rows: np.ndarray, observation: Observation
    ) -> np.ndarray:
        """Return rows with the stops that lights, streets and manoeuvres demand."""
        streets, manoeuvres = self._streets, self._streets.manoeuvres
        place, speed_mps = local.place, observation.speed_mps
        obstacles = observation.obstacles
        light_s_m = local.light_stop_s(self._lights, speed_mps)
        if light_s_m is not None:
            rows = local.stopped_at(rows, light_s_m, "traffic_light", speed_mps)
        red_s_m = math.inf if light_s_m is None else light_s_m
        stop = streets.stop(place.s_m, speed_mps, obstacles, local.horizon_m, red_s_m)
        if stop is not None:
            rows = local.stopped_at(rows, *stop, speed_mps)
        nearest_stop_m = min(red_s_m, stop[0] if stop else math.inf)
        manoeuvres.decide(place.s_m, place.cross_track_m, speed_mps, obstacles, nearest_stop_m)
        if manoeuvres.most_mps < rows[0, 2]:
            rows = local.limited(rows, np.full(len(rows), manoeuvres.most_mps), manoeuvres.reason)
        if math.isfinite(manoeuvres.stop_m):
            rows = local.stopped_at(rows, manoeuvres.stop_m, "obstacle", speed_mps)
        elif manoeuvres.reason and local.reason in ("cruise", "bend", "accelerating"):
            local.reason = manoeuvres.reason
        if streets.must_brake_hard(place.s_m, speed_mps, obstacles, local.horizon_m):
            rows = local.limited(rows, np.zeros(len(rows)), "obstacle")
        return rows


def nearby(
    route: Route, from_s_m: float, obstacles: Obstacles, horizon_m: float
) -> list[DetectedObstacle]:
    """Return those that may be so near to a place within two seconds: in traffic, few."""
    place, last_s = route.line.point_at(from_s_m), PREDICTION_TIMES_S[-1]
    return [
        obstacle
        for obstacle in obstacles
        if math.dist((obstacle.x_m, obstacle.y_m), place)
        < horizon_m + last_s * obstacle.speed_mps + obstacle.length_m
    ]
