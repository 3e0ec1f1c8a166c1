"""Plan the path ahead of the car, with a target speed on each point."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import replace

import numpy as np

from sdc_common.geometry.polyline import Place
from sdc_common.geometry.road_line import LONGEST_STEP_M, road_route
from sdc_common.planning.speed_profile import limited_speeds
from sdc_package.braking import FIRM_MPS2, HARD_MPS2, braking_for
from sdc_package.obstacle_prediction import Obstacles
from sdc_package.obstacles import speed_caps
from sdc_package.planner_settings import PlannerSettings
from sdc_package.traffic_lights import TrafficLightMonitor

# The car moves less than this between two odometry messages, unless it is moved to another place.
_WINDOW_BACK_M = 3.0
_WINDOW_AHEAD_M = 8.0
# The car brakes while its planner is started again, so that it moves less than this.
_RESUME_WITHIN_M = 60.0
# Additional time to an obstacle that is followed [s].
_TIME_GAP_S = 1.0
# Below this share of the planned speed, the car's acceleration limits its speed.
_REACHED = 0.9


class OffRouteError(ValueError):
    """The car is too far from its route to join it."""


class LocalPlanner:
    """Tracks the car's place on one route and cuts out the path ahead of it.

    The planner searches the whole route once, and from then on only around the last place, so that
    the car's place never jumps where a route passes close to itself.

    Args:
        waypoints_m: (N, 2) waypoints of the mission [m]
        settings: parameters
        road_mps: (N,) speed limit of the road at the waypoints, None for no limit [m/s]
        start_mps: speed of the car that begins to follow it [m/s]

    Attributes:
        route: the line of the road that the waypoints describe
        speed: speed profile at the points of the route [m/s]
        reason: what limits the speed at the first point of the last plan, see speed_reasons
        ahead: the points of the route that the last plan has
        horizon_m: distance ahead within which an obstacle can limit the speeds of the last plan [m]

    Raises:
        ValueError: there are fewer than 2 waypoints, one is not finite, or one repeats the one
            before it
    """

    def __init__(
        self,
        waypoints_m: np.ndarray,
        settings: PlannerSettings,
        road_mps: np.ndarray | None = None,
        start_mps: float = 0.0,
    ):
        self.waypoints_m = waypoints_m
        self.settings = settings
        self.route = route = road_route(waypoints_m)
        limits = settings.limits
        limits = replace(limits, start_mps=max(limits.start_mps, start_mps))
        caps: np.ndarray | float = math.inf
        if road_mps is not None:
            share = np.linspace(0.0, 1.0, len(waypoints_m))  # these waypoints are evenly spaced
            caps = np.interp(route.s / route.length_m, share, road_mps)
        self.speed, self._reasons = limited_speeds(route.s, route.curvature, limits, caps)
        self.reason = self._reasons[0]
        self._path = np.column_stack([self.route.points, self.speed])
        self.ahead = slice(0, 0)
        self._rows = self._path[self.ahead]
        self.horizon_m = 0.0
        self._place: Place | None = None
        self._xy = math.nan, math.nan
        self._window_ahead_m = _WINDOW_AHEAD_M

    @property
    def place(self) -> Place:
        """Return the car's place on the route, after the first plan or after `resume`."""
        assert self._place is not None, "the car's place is known after the first plan"
        return self._place

    @property
    def s_m(self) -> float:
        """Return the car's distance along the route [m]; negative: unknown yet."""
        return -1.0 if self._place is None else self._place.s_m

    def plan(
        self, first: int, x_m: float, y_m: float, yaw_rad: float, obstacles: Obstacles = ()
    ) -> np.ndarray:
        """Return the path ahead of the car, behind the obstacles on it.

        Args:
            first: index, among `route.points`, of the first waypoint ahead of the car. Where the
                route passes the car more than once, the planner replaces it with that of the car's
                own pass.
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]
            obstacles: the detected obstacles

        Returns:
            (n, 3) rows of x, y and target speed, n >= 2, that end `lookahead_m` ahead,
            `lookahead_s` at the planned speed, or at the end of the route [m, m, m/s]; the same
            array as long as the rows are the same

        Raises:
            OffRouteError: the car is farther than `join_within_m` from the route
            ValueError: a number is not finite, or `first` cannot be the first waypoint ahead
        """
        rows = self.free_path(first, x_m, y_m, yaw_rad)
        if not obstacles:
            return rows
        margins, braking_mps2 = self.settings.obstacles, self.settings.limits.braking_mps2
        caps = speed_caps(
            self.route,
            self.route.s[self.ahead],
            self.place.s_m,
            obstacles,
            margins,
            braking_mps2,
            self.horizon_m,
            _TIME_GAP_S,
        )
        return self.limited(rows, caps, "obstacle")

    def free_path(self, first: int, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Return the path ahead of a car that is alone on the road; see `plan`."""
        if not (math.isfinite(x_m) and math.isfinite(y_m) and math.isfinite(yaw_rad)):
            raise ValueError(f"the car's pose ({x_m}, {y_m}, {yaw_rad}) is not finite")
        self._update_place(x_m, y_m, yaw_rad)
        ahead = self._points_ahead(self._first_on_this_pass(first, x_m, y_m))
        if ahead != self.ahead:
            self.ahead, self._rows = ahead, self._path[ahead]
            self.horizon_m = self._horizon_m(ahead)
        self.reason = self._reasons[ahead.start]
        return self._rows

    def stop_for(
        self, lights: TrafficLightMonitor, rows: np.ndarray, speed_mps: float
    ) -> np.ndarray:
        """Return the rows of the last plan with the stop that the lights demand, if any.

        Args:
            lights: the known traffic lights
            rows: the last result of `plan`
            speed_mps: speed of the car [m/s]
        """
        self.note_acceleration(rows, speed_mps)
        stop_s = self.light_stop_s(lights, speed_mps)
        if stop_s is not None:
            rows = self.stopped_at(rows, stop_s, "traffic_light", speed_mps)
        return rows

    def note_acceleration(self, rows: np.ndarray, speed_mps: float) -> None:
        """Set the reason of a car that accelerates after a stop; the profile has none."""
        if self.reason in ("cruise", "bend") and speed_mps < _REACHED * rows[0, 2]:
            self.reason = "accelerating"

    def light_stop_s(self, lights: TrafficLightMonitor, speed_mps: float) -> float | None:
        """Return the arc length at which the car stops for a light, None if for none [m]."""
        return lights.stop_s(self.route, self.place.s_m, speed_mps, FIRM_MPS2, self.horizon_m)

    def stopped_at(
        self, rows: np.ndarray, stop_s: float, reason: str, speed_mps: float
    ) -> np.ndarray:
        """Return rows with which the car's centre stops at an arc length, for this reason."""
        s, s_m = self.route.s[self.ahead], self.place.s_m
        last_s, after = self.route.last_point_s(stop_s), int(np.searchsorted(s, stop_s))
        if last_s - s_m < speed_mps**2 / (2.0 * HARD_MPS2) and 0 < after < len(s):
            # It needs all the room that there is: it stops between two points.
            rows, share = rows.copy(), (s[after] - stop_s) / (s[after] - s[after - 1])
            rows[after, :2] += share * (rows[after - 1, :2] - rows[after, :2])
            last_s = stop_s
        usual_mps2 = self.settings.limits.braking_mps2
        braking_mps2 = braking_for(usual_mps2, speed_mps, last_s - s_m)
        caps = np.sqrt(2.0 * braking_mps2 * np.maximum(last_s - s, 0.0))
        return self.limited(rows, caps, reason)

    def limited(self, path: np.ndarray, caps: np.ndarray, reason: str) -> np.ndarray:
        """Return (n, 3) rows of x, y, v with v limited to (n,) speeds, for this reason."""
        if caps[0] < path[0, 2]:
            self.reason = reason
        return np.column_stack([path[:, :2], np.minimum(path[:, 2], caps)])

    def is_for(self, waypoints_m: np.ndarray) -> bool:
        """Return whether this planner plans along exactly these waypoints."""
        return np.array_equal(self.waypoints_m, waypoints_m)

    def resume(self, s_m: float) -> None:
        """Continue from a distance, on the pass of the route on which the car was.

        Args:
            s_m: distance along the route [m]; negative: unknown
        """
        if 0.0 <= s_m <= self.route.length_m:
            self._xy = self.route.line.point_at(s_m)
            self._place = self.route.line.project(*self._xy, s_m, _WINDOW_BACK_M, _WINDOW_BACK_M)
            self._window_ahead_m = _RESUME_WITHIN_M

    def _points_ahead(self, first: int) -> slice:
        """Return the points of the path ahead, at least two."""
        first = min(first, len(self._path) - 2)
        last = bisect_right(self.route.line.s, self.place.s_m + self._lookahead_m(first))
        return slice(first, max(first + 2, min(last, len(self._path))))

    def _lookahead_m(self, first: int) -> float:
        """Return the length of the path that begins at a point of the route [m]."""
        settings = self.settings
        return max(settings.lookahead_m, settings.lookahead_s * float(self.speed[first]))

    def _horizon_m(self, ahead: slice) -> float:
        """Return the length of a path and the distance to stop from the fastest point on it [m]."""
        settings, fastest_mps = self.settings, float(self.speed[ahead].max())
        stopping_m = fastest_mps**2 / (2.0 * settings.limits.braking_mps2)
        margins = settings.obstacles
        return self._lookahead_m(ahead.start) + stopping_m + margins.gap_m + margins.car_front_m

    def _first_on_this_pass(self, first: int, x_m: float, y_m: float) -> int:
        """Return the index of the first waypoint ahead on the car's own pass of the route."""
        if not 0 <= first < len(self._path):
            raise ValueError(
                f"waypoint {first} does not exist, the route has {len(self._path)} waypoints"
            )
        place = self.place
        distance_m = math.dist(self.route.line.points[first], (x_m, y_m))
        if distance_m > place.distance_m + 2.0 * LONGEST_STEP_M:
            raise ValueError(
                f"waypoint {first} cannot be the first one ahead: it is {distance_m:.1f} m away "
                f"from the car, the route only {place.distance_m:.1f} m"
            )
        if abs(self.route.line.s[first] - place.s_m) <= 2.0 * LONGEST_STEP_M:
            return first
        return bisect_left(self.route.line.s, place.s_m)

    def _update_place(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Find the car's place around the last one, or on the whole route if it is not there."""
        join_within_m, place = self.settings.join_within_m, None
        if self._place is not None and math.dist(self._xy, (x_m, y_m)) < self._window_ahead_m:
            place = self.route.line.project(
                x_m, y_m, self._place.s_m, _WINDOW_BACK_M, self._window_ahead_m
            )
        if place is None or place.distance_m > join_within_m:
            place = self.route.locate(x_m, y_m, yaw_rad)
        if place.distance_m > join_within_m:
            raise OffRouteError(
                f"the car is {place.distance_m:.1f} m from the route, more than join_within_m, "
                f"which is {join_within_m:g} m; bring it back to the road"
            )
        self._place, self._xy = place, (x_m, y_m)
        self._window_ahead_m = _WINDOW_AHEAD_M
