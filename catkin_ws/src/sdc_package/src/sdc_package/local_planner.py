"""Plan the path ahead of the car, with a target speed on each point."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Callable

import numpy as np

from sdc_common.geometry.polyline import Place
from sdc_common.geometry.road_line import LONGEST_STEP_M, road_route
from sdc_common.planning.speed_profile import SpeedLimits, limited_speeds
from sdc_common.validation import check_positive
from sdc_package.obstacles import HARD_MPS2, ObstacleMargins, Obstacles, nearby, speed_caps
from sdc_package.traffic_lights import TrafficLightMargins, TrafficLightMonitor

if TYPE_CHECKING:
    from sdc_package.behaviour.streets import StreetBehaviour

# The car moves less than this between two odometry messages, unless it is moved to another place.
_WINDOW_BACK_M = 3.0
_WINDOW_AHEAD_M = 8.0
# The car brakes while its planner is started again, so that it moves less than this.
_RESUME_WITHIN_M = 60.0
# Additional time to a car that is followed on a road; on streets their rules decide about it [s].
_TIME_GAP_S = 1.0
# Below this share of the planned speed, the car's acceleration limits its speed.
_REACHED = 0.9
# On streets the car accelerates by this, and aims at a speed so much greater, so far ahead, unless
# it passes someone: its way is so far to the left of the route.
_STARTS_MPS2, _STARTS_MPS, _AIM_AHEAD_M, _PASSES_M = 1.2, 0.2, 0.3, 1.0


class OffRouteError(ValueError):
    """The car is too far from its route to join it."""


@dataclass(frozen=True)
class PlannerSettings:
    """Parameters of the local planner."""

    limits: SpeedLimits  # limits of the speed profile
    lookahead_m: float  # length of the planned path [m]
    join_within_m: float  # maximum distance from the route at which the car joins it [m]
    obstacles: ObstacleMargins  # margins to obstacles
    traffic_lights: TrafficLightMargins  # margins at traffic lights

    def __post_init__(self):
        check_positive(lookahead_m=self.lookahead_m, join_within_m=self.join_within_m)

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> PlannerSettings:
        """Read the parameters of config/local_planner.yaml.

        Args:
            parameter: function that returns the value of a parameter

        Raises:
            TypeError: a section lacks a parameter or has an unknown one
            ValueError: a value is out of range
        """
        limits = SpeedLimits(
            cruise_mps=parameter("planned_speed_mps"),
            lateral_mps2=parameter("lateral_acceleration_mps2"),
            acceleration_mps2=parameter("acceleration_mps2"),
            braking_mps2=parameter("braking_mps2"),
            lateral_jerk_mps3=parameter("lateral_jerk_mps3"),
        )
        obstacles = ObstacleMargins(**parameter("caution"))
        lights = TrafficLightMargins(**parameter("traffic_lights"))
        return cls(limits, parameter("lookahead_m"), parameter("join_within_m"), obstacles, lights)


class LocalPlanner:
    """Tracks the car's place on one route and cuts out the path ahead of it.

    The planner searches the whole route once, and from then on only around the last place, so that
    the car's place never jumps where a route passes close to itself.

    Args:
        waypoints_m: (N, 2) waypoints of the mission [m]
        settings: parameters
        road_mps: (N,) speed limit of the road at the waypoints, None for no limit [m/s]
        start_mps: speed of the car that begins to follow it [m/s]
        streets: what the car decides on a map, None elsewhere

    Attributes:
        route: the line of the road that the waypoints describe
        speed: speed profile at the points of the route [m/s]
        reason: what limits the speed at the first point of the last plan, see speed_reasons

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
        streets: StreetBehaviour | None = None,
    ):
        self.waypoints_m = waypoints_m
        self.settings = settings
        self.route = route = road_route(waypoints_m)
        limits = settings.limits
        limits = replace(limits, start_mps=max(limits.start_mps, start_mps))
        caps: np.ndarray | float = math.inf
        if road_mps is not None:
            share = np.linspace(0.0, 1.0, len(waypoints_m))  # waypoints are evenly spaced on a map
            caps = np.interp(route.s / route.length_m, share, road_mps)
        self.speed, self._reasons = limited_speeds(route.s, route.curvature, limits, caps)
        self.reason = self._reasons[0]
        self._path = np.column_stack([self.route.points, self.speed])
        self._ahead = slice(0, 0)
        self._rows = self._path[self._ahead]
        stopping_m = settings.limits.cruise_mps**2 / (2.0 * settings.limits.braking_mps2)
        margins = settings.obstacles
        # The distance ahead within which an obstacle can limit the planned speeds.
        self._horizon_m = settings.lookahead_m + stopping_m + margins.gap_m + margins.car_front_m
        self._place: Place | None = None
        self._speed_mps = start_mps
        self._xy = math.nan, math.nan
        self._obstacles: Obstacles = ()
        is_on_lanes = streets and streets.follow(route, self.speed, limits.braking_mps2)
        self._streets = streets if is_on_lanes else None
        self._window_ahead_m = _WINDOW_AHEAD_M

    @property
    def place(self) -> Place:
        """Return the car's place on the route, after the first plan or after `resume`."""
        assert self._place is not None, "the car's place is known after the first plan"
        return self._place

    @property
    def detail(self) -> str:
        """Because of whom the last reason limits the speed, "" if there is no more to say."""
        return self._streets.details.get(self.reason, "") if self._streets else ""

    @property
    def s_m(self) -> float:
        """Return the car's distance along the route [m]; negative: unknown yet."""
        return -1.0 if self._place is None else self._place.s_m

    def plan(
        self, first: int, x_m: float, y_m: float, yaw_rad: float, obstacles: Obstacles = ()
    ) -> np.ndarray:
        """Return the path ahead of the car.

        Args:
            first: index, among `route.points`, of the first waypoint ahead of the car. Where the
                route passes the car more than once, the planner replaces it with that of the car's
                own pass.
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]
            obstacles: the detected obstacles

        Returns:
            (n, 3) rows of x, y and target speed, n >= 2, that end `lookahead_m` ahead or at the end
            of the route [m, m, m/s]; the same array as long as the rows are the same

        Raises:
            OffRouteError: the car is farther than `join_within_m` from the route
            ValueError: a number is not finite, or `first` cannot be the first waypoint ahead
        """
        if not (math.isfinite(x_m) and math.isfinite(y_m) and math.isfinite(yaw_rad)):
            raise ValueError(f"the car's pose ({x_m}, {y_m}, {yaw_rad}) is not finite")
        self._update_place(x_m, y_m, yaw_rad)
        ahead = self._rows_ahead(self._first_on_this_pass(first, x_m, y_m))
        if ahead != self._ahead:
            self._ahead, self._rows = ahead, self._path[ahead]
        self.reason = self._reasons[ahead.start]
        self._obstacles = obstacles
        streets, rows = self._streets, self._rows
        obstacles = nearby(self.route, self.place.s_m, obstacles, self._horizon_m)
        follows: tuple = None, _TIME_GAP_S
        if streets is not None:
            obstacles = streets.relevant(self.place.s_m, self._speed_mps, obstacles)
            way, margins = streets.manoeuvres.way, streets.margins
            rows = way.moved(rows, ahead)
            follows = way.offset_at, margins.time_gap_s, self._speed_mps, margins.follow_gap_m
        if not obstacles:
            return rows
        own = self.settings
        given = own.obstacles, own.limits.braking_mps2, self._horizon_m, *follows
        at = self.route, self.route.s[ahead], self.place.s_m
        each = np.array([speed_caps(*at, [one], *given) for one in obstacles])
        if streets is not None:
            nearest = obstacles[int(np.argmin(each[:, 0]))]
            streets.details["obstacle"] = f"{nearest.kind or 'one'} {nearest.id}"
        return self._capped(rows, each.min(axis=0), "obstacle")

    def stop_for(
        self, lights: TrafficLightMonitor, rows: np.ndarray, speed_mps: float
    ) -> np.ndarray:
        """Return the rows of the last plan with the stops that lights and streets demand, if any.

        Args:
            lights: the known traffic lights
            rows: the last result of `plan`
            speed_mps: speed of the car [m/s]
        """
        self._speed_mps = speed_mps
        if self.reason in ("cruise", "bend") and speed_mps < _REACHED * rows[0, 2]:
            self.reason = "accelerating"  # after a stop; the profile does not know of it
        way = self._streets.manoeuvres.way if self._streets else None
        if way and way.offset_m.max() < _PASSES_M and speed_mps < rows[0, 2]:
            beyond_m = np.maximum(self.route.s[self._ahead] - self.place.s_m - _AIM_AHEAD_M, 0.0)
            most_mps = np.sqrt((speed_mps + _STARTS_MPS) ** 2 + 2.0 * _STARTS_MPS2 * beyond_m)
            rows = self._capped(rows, most_mps, "accelerating")
        braking_mps2 = self.settings.limits.braking_mps2
        stop_s = lights.stop_s(self.route, self.place.s_m, speed_mps, braking_mps2, self._horizon_m)
        if stop_s is not None:
            rows = self._stopped_at(rows, stop_s, "traffic_light", speed_mps)
        if self._streets is not None:
            rows = self._on_streets(self._streets, rows, speed_mps, stop_s)
        return rows

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

    def _on_streets(
        self, streets: StreetBehaviour, rows: np.ndarray, speed_mps: float, stop_s: float | None
    ) -> np.ndarray:
        """Return rows that keep the distance to the one ahead, and stop at the next junction."""
        seen, s_m = self._obstacles, self.place.s_m
        red_m = math.inf if stop_s is None else stop_s
        stop = streets.stop(s_m, speed_mps, seen, self._horizon_m, red_m)
        rows = rows if stop is None else self._stopped_at(rows, *stop, speed_mps)
        plan = streets.manoeuvres
        stops_m = red_m, stop[0] if stop else math.inf
        plan.decide(s_m, self.place.cross_track_m, speed_mps, seen, min(stops_m))
        if plan.most_mps < rows[0, 2]:
            rows = self._capped(rows, np.full(len(rows), plan.most_mps), plan.reason)
        if math.isfinite(plan.stop_m):
            rows = self._stopped_at(rows, plan.stop_m, "obstacle", speed_mps)
        elif plan.reason and self.reason in ("cruise", "bend", "accelerating"):
            self.reason = plan.reason
        if streets.must_brake_hard(s_m, speed_mps, seen):
            rows = self._capped(rows, np.zeros(len(rows)), "obstacle")
        return rows

    def _stopped_at(
        self, rows: np.ndarray, stop_s: float, reason: str, speed_mps: float
    ) -> np.ndarray:
        """Return rows with which the car's centre stops at an arc length, for this reason."""
        s, s_m = self.route.s[self._ahead], self.place.s_m
        last_s, after = self.route.last_point_s(stop_s), int(np.searchsorted(s, stop_s))
        if last_s - s_m < speed_mps**2 / (2.0 * HARD_MPS2) and 0 < after < len(s):
            # It needs all the room that there is: it stops between two points.
            rows, share = rows.copy(), (s[after] - stop_s) / (s[after] - s[after - 1])
            rows[after, :2] += share * (rows[after - 1, :2] - rows[after, :2])
            last_s = stop_s
        needed_mps2 = speed_mps**2 / max(2.0 * (last_s - s_m), 0.1)
        braking_mps2 = max(self.settings.limits.braking_mps2, min(needed_mps2, HARD_MPS2))
        caps = np.sqrt(2.0 * braking_mps2 * np.maximum(last_s - s, 0.0))
        return self._capped(rows, caps, reason)

    def _capped(self, path: np.ndarray, caps: np.ndarray, reason: str) -> np.ndarray:
        """Return (n, 3) rows of x, y, v with v limited to (n,) speeds, for this reason."""
        if caps[0] < path[0, 2]:
            self.reason = reason
        return np.column_stack([path[:, :2], np.minimum(path[:, 2], caps)])

    def _rows_ahead(self, first: int) -> slice:
        """Return the rows of the path ahead, at least two."""
        until_s_m = self.place.s_m + self.settings.lookahead_m
        last = bisect_right(self.route.line.s, until_s_m)
        first = min(first, len(self._path) - 2)
        return slice(first, max(first + 2, min(last, len(self._path))))

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
