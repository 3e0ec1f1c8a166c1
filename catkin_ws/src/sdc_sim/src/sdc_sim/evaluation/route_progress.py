"""Progress of a drive along its route: position, infractions, and when and how the drive ends."""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.route import Place, Route
from sdc_sim.evaluation.metrics import COEFFICIENTS, WITHOUT_STREETS, drive_metrics
from sdc_sim.evaluation.rules import EvaluationRules

COMPLETED, COLLISION, OFF_ROUTE = "completed", "collision", "off_route"
BLOCKED, TIMEOUT, ABORTED = "blocked", "timeout", "aborted"

# The position is searched this far around the last one, and farther ahead by the greatest distance
# that the car can have driven since.
_WINDOW_M = 5.0
_SPEED_MARGIN_MPS = 5.0
_STANDSTILL_MPS = 0.05
_MIN_PROGRESS_M = 0.1


class DriveSample(NamedTuple):
    """One odometry and its position relative to the route; errors are positive to the left.

    Past the end of the route, the cross-track error is measured from its straight continuation.
    """

    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    s_m: float
    cross_track_m: float
    heading_error_rad: float


class DriveEvent(NamedTuple):
    """An infraction or the end of the drive, with its time and place."""

    name: str
    time_s: float
    s_m: float
    x_m: float
    y_m: float


class RouteProgress:
    """One drive along one route, from its first odometry to its end.

    The position is searched only near the progress of the drive, so that on a route that passes
    close to itself, the car is measured against the right pass.
    """

    def __init__(
        self, route: Route, rules: EvaluationRules, timeout_s: float, keep_samples: bool = True
    ):
        """Start a drive; without `keep_samples` only the last one stays, for many hours."""
        self.follow(route, timeout_s)
        self.rules = rules
        self.keep_samples = keep_samples
        self.samples: list[DriveSample] = []
        self.status: str | None = None
        self.progress_m = 0.0
        counted = COEFFICIENTS if rules.map else WITHOUT_STREETS
        self.infractions = dict.fromkeys(counted, 0)
        # Times at which the car is off its route, but on another lane that it may use [s].
        self.on_lane_s: set[float] = set()
        self.events: list[DriveEvent] = []
        self._started_at_s = 0.0
        self._progress_at_s = self._progress_from_m = 0.0
        self._on_route_at_s = self._on_route_at_m = 0.0
        self._collided_at_s: float | None = None

    def follow(self, route: Route, timeout_s: float) -> None:
        """Measure from here on along a route; the car is as far along it as along the last one."""
        self.route, self._timeout_s = route, timeout_s
        self._continuation = Polyline(route.points[-2:].tolist())

    @property
    def completion_percent(self) -> float:
        """Return the share of the route behind the car [%]; 100 for a completed drive."""
        return 100.0 if self.status == COMPLETED else 100.0 * self.progress_m / self.route.length_m

    @property
    def duration_s(self) -> float:
        """Return the simulated time [s] since the first odometry."""
        return self.samples[-1].time_s - self._started_at_s if self.samples else 0.0

    def wait_until(self, time_s: float) -> None:
        """Do not count the time from the last odometry on as time without progress."""
        self._progress_at_s += time_s - self.samples[-1].time_s

    def update(
        self, time_s: float, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> DriveSample:
        """Add one odometry, later than the last one, and set `status` if it ends the drive."""
        place = self._locate(time_s, x_m, y_m, yaw_rad, speed_mps)
        heading_error = wrap_angle(yaw_rad - place.heading_rad)
        cross_track_m = place.cross_track_m
        if place.s_m >= self.route.length_m:
            cross_track_m = self._continuation.nearest(x_m, y_m).cross_track_m
        sample = DriveSample(
            time_s, x_m, y_m, yaw_rad, speed_mps, place.s_m, cross_track_m, heading_error
        )
        if not self.samples:
            self._started_at_s = self._progress_at_s = self._on_route_at_s = time_s
            self._on_route_at_m = place.s_m
        if not self.keep_samples:
            self.samples.clear()
        self.samples.append(sample)
        if place.distance_m <= self.rules.off_route_m:
            self._on_route_at_s, self._on_route_at_m = time_s, place.s_m
            if place.s_m > self._progress_from_m + _MIN_PROGRESS_M:
                self._progress_at_s, self._progress_from_m = time_s, place.s_m
            self.progress_m = max(self.progress_m, place.s_m)
        status = self._termination(sample, place)
        if status is not None:
            self._end(status)
        return sample

    def add_infraction(self, name: str, sample: DriveSample | None = None) -> None:
        """Count an infraction, a key of COEFFICIENTS, at a sample or at the last one."""
        self.infractions[name] += 1
        self._add_event(name, sample)

    def add_collision(self, kind: str, time_s: float | None = None) -> None:
        """End the drive with the odometry at the time of a collision.

        Collisions and odometry arrive on different connections: samples later than the collision
        are removed, and if its odometry has not arrived yet, the drive ends when it does.
        `kind` is pedestrian, vehicle or static. Without a time, it is now.
        """
        if self.status is not None or self._collided_at_s is not None:
            return
        if time_s is not None and self.keep_samples:
            self._remove_samples_after(time_s)
        self.add_infraction("collision_" + kind)
        if time_s is None or (self.samples and self.samples[-1].time_s >= time_s):
            self._end(COLLISION)
        else:
            self._collided_at_s = time_s

    @property
    def rows(self) -> np.ndarray:
        """Return all samples: (n, fields of DriveSample)."""
        values = np.fromiter(chain.from_iterable(self.samples), float)
        return values.reshape(-1, len(DriveSample._fields))

    def column(self, name: str) -> np.ndarray:
        """Return one field of DriveSample for all samples: (n,)."""
        return self.rows[:, DriveSample._fields.index(name)]

    def metrics(self, ideal_duration_s: float) -> dict:
        """Return the metrics of the report; None for those that a short drive does not define."""
        return {
            "status": self.status or (ABORTED if self._collided_at_s is None else COLLISION),
            "route_length_m": self.route.length_m,
            "route_completion_percent": self.completion_percent,
            "duration_s": self.duration_s,
            "ideal_duration_s": ideal_duration_s,
            "time_ratio": self.duration_s / ideal_duration_s,
            **drive_metrics(
                dict(zip(DriveSample._fields, self.rows.T)),
                self.completion_percent,
                self.infractions,
                self.rules.lane_width_m,
                self.on_lane_s,
            ),
        }

    def _remove_samples_after(self, time_s: float) -> None:
        while len(self.samples) > 1 and self.samples[-1].time_s > time_s:
            self.samples.pop()
        limit_m = self.rules.off_route_m
        on_route = (sample.s_m for sample in self.samples if abs(sample.cross_track_m) <= limit_m)
        self.progress_m = max(on_route, default=0.0)

    def _end(self, status: str) -> None:
        self.status = status
        self._add_event(status)

    def _add_event(self, name: str, sample: DriveSample | None = None) -> None:
        if self.samples:
            last = sample or self.samples[-1]
            self.events.append(DriveEvent(name, last.time_s, last.s_m, last.x_m, last.y_m))

    def _locate(
        self, time_s: float, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> Place:
        if not self.samples:
            return self.route.locate(x_m, y_m, yaw_rad)
        max_speed_mps = max(self.samples[-1].speed_mps, speed_mps) + _SPEED_MARGIN_MPS
        ahead_m = _WINDOW_M + (time_s - self._on_route_at_s) * max_speed_mps
        return self.route.line.project(x_m, y_m, self._on_route_at_m, _WINDOW_M, ahead_m)

    def _termination(self, sample: DriveSample, place: Place) -> str | None:
        rules = self.rules
        if self._collided_at_s is not None and sample.time_s >= self._collided_at_s:
            return COLLISION
        to_end_m = max(self.route.length_m - place.s_m, place.distance_m)
        arrived = sample.speed_mps < _STANDSTILL_MPS or not rules.finish_at_rest
        if arrived and to_end_m < rules.finish_within_m:
            return COMPLETED
        if sample.time_s - self._on_route_at_s > rules.off_route_s:
            return OFF_ROUTE
        if sample.time_s - self._progress_at_s > rules.blocked_s:
            return BLOCKED
        if self.duration_s > self._timeout_s:
            return TIMEOUT
        return None
