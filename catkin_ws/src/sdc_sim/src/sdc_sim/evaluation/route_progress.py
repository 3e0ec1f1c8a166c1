"""Judges a drive while it goes on: where the car is on its route, what it did wrong, and when it is over."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.route import Place, Route
from sdc_sim.evaluation.metrics import COEFFICIENTS, measure

COMPLETED, COLLISION, OFF_ROUTE = "completed", "collision", "off_route"
BLOCKED, TIMEOUT, ABORTED = "blocked", "timeout", "aborted"

# The place is sought this far around the last one on the route, and as far ahead again as the car may have come since then.
_WINDOW_M = 5.0
_SPEEDING_UP_MPS = 5.0
_STANDSTILL_MPS = 0.05
_PROGRESS_M = 0.1


class TerminationLimits(NamedTuple):
    """When a drive is over: metres, seconds of simulated time."""

    off_route_m: float
    off_route_s: float
    blocked_s: float
    finish_within_m: float
    timeout_s: float

    def checked(self) -> TerminationLimits:
        """The limits themselves. Raises ValueError for one that is not positive."""
        for name, value in self._asdict().items():
            if not value > 0.0:
                raise ValueError(f"{name} must be positive, got {value}")
        return self


class DriveSample(NamedTuple):
    """One odometry, placed on the route: seconds, metres, radians, m/s; errors positive to the left."""

    time_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    s_m: float
    cross_track_m: float
    heading_error_rad: float


class Event(NamedTuple):
    """Something that happened on the way, at this place and time: an infraction, or how the drive ended."""

    name: str
    time_s: float
    s_m: float
    x_m: float
    y_m: float


class RouteProgress:
    """Follows one drive along one route, from its first odometry to its end.

    The place on the route is searched near the drive's own progress only, so that a route which passes close to itself is
    measured against the pass that is being driven. keep_samples: False keeps the last sample alone, for a drive of many hours.
    """

    def __init__(self, route: Route, limits: TerminationLimits, keep_samples: bool = True):
        self.route = route
        self.limits = limits.checked()
        self.keep_samples = keep_samples
        self.samples = []
        self.status = None
        self.progress_m = 0.0
        self.infractions = dict.fromkeys(COEFFICIENTS, 0)
        self.events = []
        self._started_at_s = 0.0
        self._progress_at_s = 0.0
        self._seen_at_s = self._seen_at_m = 0.0
        self._collided_at_s = None

    @property
    def completion_percent(self) -> float:
        """Share of the route that lies behind the car; all of it once the drive is completed."""
        return 100.0 if self.status == COMPLETED else 100.0 * self.progress_m / self.route.length_m

    @property
    def duration_s(self) -> float:
        """Simulated time since the first odometry."""
        return self.samples[-1].time_s - self._started_at_s if self.samples else 0.0

    def update(
        self, time_s: float, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> DriveSample:
        """Take one odometry; sets `status` when it ends the drive. Raises ValueError when time does not move on."""
        if self.samples and time_s <= self.samples[-1].time_s:
            raise ValueError(f"time went from {self.samples[-1].time_s:.3f} s to {time_s:.3f} s")
        place = self._place(time_s, x_m, y_m, yaw_rad, speed_mps)
        sample = DriveSample(
            time_s,
            x_m,
            y_m,
            yaw_rad,
            speed_mps,
            place.s_m,
            place.cross_track_m,
            wrap_angle(yaw_rad - place.heading_rad),
        )
        if not self.samples:
            self._started_at_s = self._progress_at_s = self._seen_at_s = time_s
            self._seen_at_m = place.s_m
        if not self.keep_samples:
            self.samples.clear()
        self.samples.append(sample)
        if place.distance_m <= self.limits.off_route_m:
            self._seen_at_s, self._seen_at_m = time_s, place.s_m
            if place.s_m > self.progress_m + _PROGRESS_M:
                self._progress_at_s = time_s
            self.progress_m = max(self.progress_m, place.s_m)
        status = self._judge(sample, place)
        if status is not None:
            self._end(status)
        return sample

    def infraction(self, name: str) -> None:
        """Count one: a key of the report's `infractions`. Raises ValueError for another name."""
        if name not in self.infractions:
            raise ValueError(f"'{name}' is no infraction; they are: {', '.join(self.infractions)}")
        self.infractions[name] += 1
        self._note(name)

    def collision(self, kind: str, time_s: float = None) -> None:
        """The car ran into a pedestrian, a vehicle or something static: the drive ends with the odometry of that time.

        Messages travel on connections of their own: later odometry may have been heard already and is left out again, or that
        odometry may still be under way. None: now. Raises ValueError for another kind.
        """
        name = "collision_" + kind
        if self.status is not None or self._collided_at_s is not None:
            return
        if time_s is not None and self.keep_samples:
            self._go_back_to(time_s)
        self.infraction(name)
        if time_s is None or (self.samples and self.samples[-1].time_s >= time_s):
            self._end(COLLISION)
        else:
            self._collided_at_s = time_s

    def _go_back_to(self, time_s: float) -> None:
        while len(self.samples) > 1 and self.samples[-1].time_s > time_s:
            self.samples.pop()
        self.progress_m = max(
            (
                sample.s_m
                for sample in self.samples
                if abs(sample.cross_track_m) <= self.limits.off_route_m
            ),
            default=0.0,
        )

    def _end(self, status: str) -> None:
        self.status = status
        self._note(status)

    def _note(self, name: str) -> None:
        if self.samples:
            last = self.samples[-1]
            self.events.append(Event(name, last.time_s, last.s_m, last.x_m, last.y_m))

    def _place(
        self, time_s: float, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> Place:
        if not self.samples:
            return self.route.locate(x_m, y_m, yaw_rad)
        last = self.samples[-1]
        ahead_m = _WINDOW_M + (time_s - self._seen_at_s) * (
            max(last.speed_mps, speed_mps) + _SPEEDING_UP_MPS
        )
        return self.route.project(x_m, y_m, self._seen_at_m, _WINDOW_M, ahead_m)

    def _judge(self, sample: DriveSample, place: Place):
        if self._collided_at_s is not None and sample.time_s >= self._collided_at_s:
            return COLLISION
        at_rest = sample.speed_mps < _STANDSTILL_MPS
        left_m = self.route.length_m - place.s_m
        if (
            at_rest
            and left_m < self.limits.finish_within_m
            and place.distance_m < self.limits.finish_within_m
        ):
            return COMPLETED
        if sample.time_s - self._seen_at_s > self.limits.off_route_s:
            return OFF_ROUTE
        if sample.time_s - self._progress_at_s > self.limits.blocked_s:
            return BLOCKED
        if self.duration_s > self.limits.timeout_s:
            return TIMEOUT
        return None

    def column(self, name: str) -> np.ndarray:
        """All values of one field of Sample, in the order of time: (n,)."""
        return np.array([getattr(sample, name) for sample in self.samples])

    def figures(self, ideal_duration_s: float, lane_width_m: float = math.inf) -> dict:
        """The report's figures, units in their names; None where a drive is too short to tell. The car is off its lane where its
        centre is farther than half the lane's width from the route."""
        return {
            "status": self.status or (ABORTED if self._collided_at_s is None else COLLISION),
            "route_length_m": self.route.length_m,
            "route_completion_percent": self.completion_percent,
            "duration_s": self.duration_s,
            "ideal_duration_s": ideal_duration_s,
            "time_ratio": self.duration_s / ideal_duration_s,
            **measure(
                {name: self.column(name) for name in DriveSample._fields},
                self.completion_percent,
                self.infractions,
                lane_width_m,
            ),
        }
