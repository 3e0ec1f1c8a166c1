"""Plans the road ahead: where the car is on its route, and how fast it may be on each point of it."""

from __future__ import annotations

import math
import zlib

import numpy as np

from sdc_common.geometry.route import Route, respace
from sdc_common.planning.speed_profile import SpeedLimits, speed_profile
from sdc_common.validation import check_positive
from sdc_package.obstacles import ObstacleMargins, speed_caps
from sdc_package.traffic_lights import TrafficLightMonitor

# A planned path neither wastes messages on points closer than this nor leaves a bend's speed to two far points.
_SHORTEST_STEP_M = 0.4
_LONGEST_STEP_M = 1.25
# A car that drives moves less than this between two odometry messages; one that moves more was picked up and put elsewhere.
_WINDOW_BACK_M = 3.0
_WINDOW_AHEAD_M = 8.0
# A car whose planner was away has braked meanwhile: it is not farther on than this.
_RESUME_WITHIN_M = 40.0


class OffRouteError(ValueError):
    """The car is too far from its route to join it."""


class LocalPlanner:
    """Follows the car's progress along one route and cuts out the road ahead of it.

    The place on the whole route is searched once; from then on only its neighbourhood is looked at, so that a route that
    passes close to itself never makes the car jump from one pass to the other.
    """

    def __init__(
        self,
        waypoints_m: np.ndarray,
        limits: SpeedLimits,
        lookahead_m: float,
        join_within_m: float,
        caution: ObstacleMargins,
    ):
        check_positive(lookahead_m=lookahead_m, join_within_m=join_within_m)
        self.waypoints_m = waypoints_m
        self._fingerprint = zlib.crc32(np.ascontiguousarray(waypoints_m, float).tobytes())
        self.route = Route(respace(waypoints_m, _SHORTEST_STEP_M, _LONGEST_STEP_M))
        self.speed = speed_profile(self.route, limits)
        self.lookahead_m = lookahead_m
        self.join_within_m = join_within_m
        self.limits = limits
        self.caution = caution
        self.place = None
        self._last_xy = None
        self._ahead = slice(0, 0)
        self._window_ahead_m = _WINDOW_AHEAD_M
        self._path = np.column_stack([self.route.points, self.speed])

    def plan(self, first: int, x_m: float, y_m: float, yaw_rad: float, obstacles=()) -> np.ndarray:
        """Return the road ahead of the car as (n, 3) rows of x, y (metres) and target speed (m/s), n >= 2. `obstacles` are those known now.

        `first` is the index, among `route.points`, of the first waypoint ahead of the car, as WaypointSearch finds it. The first row is
        this waypoint, unless it belongs to another pass of a route that comes by here more than once; the last row lies
        `lookahead_m` ahead or ends the route.
        Raises OffRouteError when the car is farther than `join_within_m` from the route, ValueError for numbers
        that are not finite and for a waypoint that cannot be the first one ahead.
        """
        if not (math.isfinite(x_m) and math.isfinite(y_m) and math.isfinite(yaw_rad)):
            raise ValueError(f"the car's pose ({x_m}, {y_m}, {yaw_rad}) is not finite")
        self._follow(x_m, y_m, yaw_rad)
        count = len(self._path)
        first = self._first_on_this_pass(first, x_m, y_m)
        last = int(np.searchsorted(self.route.s, self.place.s_m + self.lookahead_m, side="right"))
        first = min(first, count - 2)
        ahead = slice(first, max(first + 2, min(last, count)))
        path = self._path[ahead]
        if obstacles:
            caps = speed_caps(
                self.route,
                self.route.s[ahead],
                self.place.s_m,
                obstacles,
                self.caution,
                self.limits.braking_mps2,
                self._horizon_m,
            )
            path = np.column_stack([path[:, :2], np.minimum(path[:, 2], caps)])
        self._ahead = ahead
        return path

    def is_for(self, waypoints_m: np.ndarray) -> bool:
        """Whether this is a planner for that route."""
        return np.array_equal(self.waypoints_m, waypoints_m)

    def memory(self) -> dict:
        """Where the car is on this route, as plain data; after the first plan."""
        x_m, y_m = self._last_xy
        return {"route": self._fingerprint, "s_m": self.place.s_m, "x_m": x_m, "y_m": y_m}

    def recall(self, memory) -> bool:
        """Look for the car from where `memory` of a planner before this one said: in the right pass of a route that comes by here
        more than once. Returns whether it was a memory of this route."""
        if not memory or memory["route"] != self._fingerprint:
            return False
        self._last_xy = memory["x_m"], memory["y_m"]
        self.place = self.route.project(
            *self._last_xy, memory["s_m"], _WINDOW_BACK_M, _WINDOW_BACK_M
        )
        self._window_ahead_m = _RESUME_WITHIN_M
        return True

    def stop_for(
        self, lights: TrafficLightMonitor, rows: np.ndarray, speed_mps: float
    ) -> np.ndarray:
        """Return the rows of the last plan with the stop that the traffic lights ask for, if they do; the car drives at `speed_mps`."""
        braking_mps2 = self.limits.braking_mps2
        stop_s = lights.stop_s(self.route, self.place.s_m, speed_mps, braking_mps2, self._horizon_m)
        if stop_s is None:
            return rows
        caps = np.sqrt(
            2.0
            * braking_mps2
            * np.maximum(self.route.last_point_s(stop_s) - self.route.s[self._ahead], 0.0)
        )
        return np.column_stack([rows[:, :2], np.minimum(rows[:, 2], caps)])

    @property
    def _horizon_m(self) -> float:
        """So far ahead something may stand for which the last point of the path must be driven more slowly."""
        return (
            self.lookahead_m
            + self.limits.cruise_mps**2 / (2.0 * self.limits.braking_mps2)
            + self.caution.gap_m
            + self.caution.car_front_m
        )

    def _first_on_this_pass(self, first: int, x_m: float, y_m: float) -> int:
        if not 0 <= first < len(self._path):
            raise ValueError(f"waypoint {first} is none of the route's {len(self._path)}")
        x, y = self._path[first, :2]
        distance_m = math.hypot(x - x_m, y - y_m)
        if distance_m > self.place.distance_m + 2.0 * _LONGEST_STEP_M:
            raise ValueError(
                f"waypoint {first} is {distance_m:.1f} m away from the car, but the route {self.place.distance_m:.1f} m: "
                "it is not the first one ahead"
            )
        if abs(self.route.s[first] - self.place.s_m) <= 2.0 * _LONGEST_STEP_M:
            return first
        return int(np.searchsorted(self.route.s, self.place.s_m, side="left"))

    def _follow(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        place = None
        if self.place is not None and math.dist(self._last_xy, (x_m, y_m)) < self._window_ahead_m:
            place = self.route.project(
                x_m, y_m, self.place.s_m, _WINDOW_BACK_M, self._window_ahead_m
            )
        if place is None or place.distance_m > self.join_within_m:
            place = self.route.locate(x_m, y_m, yaw_rad)
        if place.distance_m > self.join_within_m:
            raise OffRouteError(
                f"the car is {place.distance_m:.1f} m from the route, more than the {self.join_within_m:g} m "
                "within which it may join; bring it back to the road"
            )
        self.place = place
        self._last_xy = (x_m, y_m)
        self._window_ahead_m = _WINDOW_AHEAD_M
