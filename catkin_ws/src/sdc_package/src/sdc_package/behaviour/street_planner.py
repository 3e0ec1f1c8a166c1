"""Plan the path ahead of the car on a map: along its mission, with the rules of the streets."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sdc_common.driving import Observation, Path, other_level, points_as_sent
from sdc_common.geometry.route import smooth_step
from sdc_common.planning.stop_line import StopLine
from sdc_map.crossings import Crossing
from sdc_map.mirror import negated
from sdc_map.network import Network
from sdc_package.behaviour.decision import Decision, decide
from sdc_package.behaviour.offset_path import OffsetPath
from sdc_package.behaviour.predict import Predictor
from sdc_package.behaviour.propose import KEEP, PULLS_OUT_M
from sdc_package.behaviour.road import road_along
from sdc_package.behaviour.scene import AT_REST_MPS, Stop, StreetScene, Tracker
from sdc_package.behaviour.score import load_score
from sdc_package.local_planner import LocalPlanner
from sdc_package.street_settings import StreetSettings
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_package.waypoint_search import WaypointSearch

if TYPE_CHECKING:
    from sdc_map.global_planner import GlobalPlanner

# It aims at a speed that is so much greater than its own [m/s], at a point so far ahead [m].
_AIM_FASTER_MPS = 0.2
_AIM_AHEAD_M = 0.3
# A decision in so many plans, 20 a second.
_EVERY = 2


class StreetPlanner:
    """Plans the path ahead on a network of streets, see PathPlanner.

    Where traffic is on the left, it plans in the mirror image of the streets, by the same rules.

    Args:
        network: the streets
        settings: parameters
        lights: the known traffic lights; `plan` sets their states
        missions: plans another mission when it is needed; None: `follow` sets it
        keeps_route: whether the car keeps its route, and does not pass, change lanes or make room

    Raises:
        ValueError: the score of the settings cannot be loaded

    Attributes:
        decision: the last one, with all that was proposed
    """

    def __init__(
        self,
        network: Network,
        settings: StreetSettings,
        lights: TrafficLightMonitor,
        missions: GlobalPlanner | None = None,
        keeps_route: bool = False,
    ):
        self._settings, self._missions, self._y_sign = settings, missions, network.y_sign
        # Those of the observation, and those where it plans.
        self._known_lights = self._lights = lights
        if self._y_sign < 0.0:
            self._lights = TrafficLightMonitor(lights.margins)
        self._network = network.right_hand
        self._keeps_route, self._score = keeps_route, load_score(settings.score_function)
        self._predictor = Predictor(self._network, settings.prediction.ahead_m)
        self._tracker = Tracker(settings.prediction)
        self._local: LocalPlanner | None = None
        self._rows, self._path = np.empty((0, 3)), Path(())
        self.decision = Decision()

    @property
    def reason(self) -> str:
        """What limits the speed at the start of the last path."""
        return self._local.reason if self._local else ""

    @property
    def detail(self) -> str:
        """Because of whom, "" if the reason says it all."""
        is_decided = self.reason and self.reason == self.decision.reason
        return self.decision.detail if is_decided else ""

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
        local = LocalPlanner(points_m, self._settings.planner, road_mps, start_mps)
        route = local.route
        road = self._road = road_along(self._network, route, local.speed)
        self._crossings = list(road.crossings)  # those ahead
        self._entered: list[Crossing] = []  # that in which the car cannot stop any more
        self.way = OffsetPath(route, float(local.speed.max()), self._settings)
        self._stood_since_s, self._plans, self.decision = math.inf, 0, Decision()
        self._local, self._search = local, WaypointSearch(route.points)

    def resume(self, s_m: float) -> None:
        """Continue from a distance along the route, see `LocalPlanner.resume`."""
        if self._local is not None:
            self._local.resume(s_m)

    def plan(self, observation: Observation) -> Path:
        """See PathPlanner; the same object as long as the path is the same."""
        speed_mps = observation.speed_mps
        if self._missions is not None:
            pose = observation.x_m, observation.y_m, observation.yaw_rad
            mission = self._missions.update(*pose, observation.z_m)
            if mission is not None:
                self.follow(mission.points_m, mission.limits_mps, speed_mps)
        if self._y_sign < 0.0:
            others = [negated(user, "y_m", "yaw_rad") for user in observation.obstacles]
            observation = replace(negated(observation, "y_m", "yaw_rad"), obstacles=others)
            known = self._known_lights.lines.items()
            self._lights.lines = {number: negated(line, "y_m") for number, line in known}
        x_m, y_m, yaw_rad = observation.x_m, observation.y_m, observation.yaw_rad
        local = self._local
        assert local is not None, "a mission is followed before the first plan"
        rows = local.free_path(self._search.first_ahead(x_m, y_m), x_m, y_m, yaw_rad)
        flat, lines = self._network.is_flat, self._lights.lines
        seen = ((n, state) for n, state in observation.light_states.items() if n in lines)
        self._lights.states = {n: s for n, s in seen if flat or self._on_level(local, lines[n])}
        self._tracker.update(observation.obstacles, observation.stamp_s)
        place = local.place
        if not self._plans and abs(place.cross_track_m) > PULLS_OUT_M:
            out = smooth_step(local.route.s, place.s_m, self._settings.proposals.shift_m)
            self.way.follow(place.cross_track_m * (1.0 - out), place.s_m)
        self.way.follow(self.way.offset_m, place.s_m)
        stop = self._stop(local, observation)
        if self._plans % _EVERY == 0:
            self._decide(local, observation, stop)
        self._plans += 1
        rows = self.way.moved(rows, local.ahead)
        rows = self._limited(local, rows, speed_mps, stop)
        if rows is not self._rows:
            self._rows, self._path = rows, Path.from_rows(rows * (1.0, self._y_sign, 1.0))
        return self._path

    def _on_level(self, local: LocalPlanner, line: StopLine) -> bool:
        """Return whether a stop line is not one above or below the route."""
        s_m = line.along(local.route, local.s_m, local.horizon_m) or local.s_m
        return not other_level(line.z_m, np.interp(s_m, local.route.s, self._road.z_m))

    def _stop(self, local: LocalPlanner, observation: Observation) -> Stop | None:
        """Return where the car must stop for a light or a stop sign."""
        s_m, speed_mps, front_m = local.place.s_m, observation.speed_mps, self._settings.front_m
        while self._crossings and s_m > self._crossings[0].last_stop_m(front_m):
            self._entered, self._stood_since_s = [self._crossings.pop(0)], math.inf
        light_s_m = local.light_stop_s(self._lights, speed_mps)
        stops = [] if light_s_m is None else [Stop(light_s_m, "traffic_light")]
        if self._crossings:
            crossing, margins = self._crossings[0], self._settings.streets
            stop_m = crossing.line_m - front_m - margins.gap_m
            if speed_mps < 0.5 * AT_REST_MPS and stop_m - s_m < 2.0 * margins.gap_m:
                self._stood_since_s = min(self._stood_since_s, observation.stamp_s)
            soonest_m = s_m + speed_mps**2 / (2.0 * margins.hardest_mps2)
            must_stop = crossing.has_stop_sign and math.isinf(self._stood_since_s)
            if must_stop and soonest_m <= stop_m + margins.gap_m:
                stops.append(Stop(stop_m, "stop_sign"))
        return min(stops, default=None)

    def _decide(self, local: LocalPlanner, observation: Observation, stop: Stop | None) -> None:
        s_m, stood_s = local.place.s_m, observation.stamp_s - self._stood_since_s
        if not (observation.obstacles or self.way.until_m):
            self.decision = Decision()
            return
        has_waited = observation.speed_mps > AT_REST_MPS or stood_s > self._settings.streets.waits_s
        crossings = [*self._entered, *self._crossings[:2]]
        known = self._road, self.way, self._settings, self._tracker, observation
        scene = StreetScene(*known, s_m, local.horizon_m, crossings, stop, has_waited)
        self.decision = decide(scene, self._predictor, self._score, self._keeps_route)
        chosen = self.decision.proposal
        if chosen is not None and chosen.way.name != KEEP:
            self.way.follow(chosen.way.offset_m, s_m)

    def _limited(
        self, local: LocalPlanner, rows: np.ndarray, speed_mps: float, stop: Stop | None
    ) -> np.ndarray:
        """Return rows with the speeds and the stops that were decided."""
        decision = self.decision
        local.note_acceleration(rows, speed_mps)
        if len(decision.speed_mps):
            s_m, square = local.route.s[local.ahead], np.square(decision.speed_mps)
            caps = np.sqrt(np.interp(s_m, decision.s_m, square))
            rows = local.limited(rows, caps, local.reason)
            local.reason = decision.reason or local.reason
        elif speed_mps < rows[0, 2]:  # where all is free, it starts gently
            ahead_m = np.maximum(local.route.s[local.ahead] - local.s_m - _AIM_AHEAD_M, 0.0)
            square = 2.0 * self._settings.streets.starts_mps2 * ahead_m
            caps = np.sqrt((speed_mps + _AIM_FASTER_MPS) ** 2 + square)
            rows = local.limited(rows, caps, "accelerating")
        if stop is not None:
            rows = local.stopped_at(rows, stop.s_m, stop.reason, speed_mps)
        if math.isfinite(decision.stop_m):
            rows = local.stopped_at(rows, decision.stop_m, decision.reason, speed_mps)
        return rows
