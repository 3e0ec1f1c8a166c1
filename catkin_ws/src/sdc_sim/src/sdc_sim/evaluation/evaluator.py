"""Watches a drive: takes what is heard, in the order of hearing, and tells what came of it."""

from __future__ import annotations

import hashlib
import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, ideal_duration, speed_profile
from sdc_sim.evaluation.command_matching import CommandMatching
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.evaluation.metrics import COEFFICIENTS
from sdc_sim.evaluation.route_progress import RouteProgress, TerminationLimits
from sdc_sim.evaluation.timeline import LEFT_OUT, RESTARTED, Timeline

# The names under which the local planner knows its limits: what the ideal duration is reckoned with.
PLANNER_LIMITS = {
    "cruise_mps": "planned_speed_mps",
    "lateral_mps2": "lateral_acceleration_mps2",
    "acceleration_mps2": "acceleration_mps2",
    "braking_mps2": "braking_mps2",
    "lateral_jerk_mps3": "lateral_jerk_mps3",
}

# What was heard before the route is kept: lockstep may be some ticks ahead of it.
_EARLY = 3000
_NANOSECONDS = 1_000_000_000
# Over a longer time between two odometry messages, nobody knows what the car did.
_UNSEEN_S = 1.0
# So early in a drive its pace tells nothing about the rest.
_SETTING_OFF_S = 5.0
# What the bodies of the obstacles topic are in the report. What is not known there: a world's own things have the number 0 in
# CARLA, and all else that it counts as an actor is most likely a vehicle.
_KINDS = {"car": "vehicle", "pedestrian": "pedestrian", "obstacle": "static"}


class EvaluationRules(NamedTuple):
    """What a drive is judged by (config/referee.yaml). planner: the local planner's limits by their names there; assumed: the names
    of those that it did not tell."""

    off_route_m: float
    off_route_s: float
    blocked_s: float
    finish_within_m: float
    timeout_ratio: float
    timeout_margin_s: float
    lane_width_m: float
    car_front_m: float
    planner: dict
    assumed: list = ()

    @classmethod
    def read(cls, parameter) -> EvaluationRules:
        """The rules by a function that gives a parameter of config/referee.yaml by its name; the planner's limits are assumed ones."""
        planner = parameter("assumed_planner")
        return cls(
            planner=planner,
            assumed=list(planner),
            **{name: parameter(name) for name in cls._fields if name not in ("planner", "assumed")},
        )

    def drive_limits(self, ideal_duration_s: float) -> TerminationLimits:
        """The limits of a drive that could have taken so long."""
        return TerminationLimits(
            self.off_route_m,
            self.off_route_s,
            self.blocked_s,
            self.finish_within_m,
            self.timeout_ratio * ideal_duration_s + self.timeout_margin_s,
        )


@dataclass
class DriveResult:
    """A drive as it is reported. commands: (n, 3) throttle, brake and steer that answered each sample, or else were in
    force, NaN where none were;
    planned: (m, 2) distance and planned speed; limit_mps: (N,) the greatest speed at each point of the route."""

    figures: dict
    drive: RouteProgress
    commands: np.ndarray
    planned: np.ndarray
    limit_mps: np.ndarray


class Evaluator:
    """All that is heard of one drive, whatever connection it comes on.

    With a journal it keeps no sample itself, so that a drive may last for days: the result is made from the journal at the end,
    and a watch that finds the journal of a killed one goes on where that stopped.
    """

    def __init__(self, rules: EvaluationRules, journal: EventLog = None):
        self.rules = rules
        self.drive = None
        self.ideal_duration_s = None
        self.answers = CommandMatching()
        self.world_restarts = 0
        self.referee_restarts = 0
        self.unseen_s = 0.0
        self.began_at_s = None
        self._journal = journal
        self._route = None
        self._limit_mps = self._ideal_s = None
        self._early = deque(maxlen=_EARLY)
        self._kinds = {}
        self._red_lights = RedLightDetector(rules.car_front_m)
        self._begin()

    def _begin(self):
        self._timeline = Timeline()
        self._red_lights.begin()
        self._stamps = []
        self._commands = {}
        self._fallbacks = []
        self._planned = []

    @property
    def over(self) -> bool:
        """Whether the drive has ended."""
        return self.drive is not None and self.drive.status is not None

    @property
    def missing(self) -> list:
        """The topics without which the drive has not begun."""
        return [
            topic
            for topic, there in (
                ("/planner/mission_waypoints", self.drive is not None),
                ("/carla/ego_vehicle/odometry", self.drive and self.drive.samples),
            )
            if not there
        ]

    @property
    def write_failure(self):
        """Why the journal cannot be written, or None."""
        return self._journal.failure if self._journal is not None else None

    def mission(self, points_m) -> None:
        """Take the route, (N, 2) metres, and resume the drive along it that the journal holds. Raises ValueError where it is none."""
        route = Route(np.asarray(points_m, dtype=float).reshape(-1, 2))
        limits = SpeedLimits(
            **{ours: self.rules.planner[theirs] for ours, theirs in PLANNER_LIMITS.items()}
        )
        self._limit_mps = speed_profile(route, limits)
        self.ideal_duration_s = ideal_duration(route, self._limit_mps)
        self._ideal_s = np.append(
            0.0,
            np.cumsum(
                np.diff(route.s)
                / np.maximum(0.5 * (self._limit_mps[:-1] + self._limit_mps[1:]), 1e-3)
            ),
        )
        self._route = route
        self.drive = self._new_drive()
        if self._journal is not None:
            self._open_journal(["route", hashlib.sha256(route.points.tobytes()).hexdigest()])
        early, self._early = self._early, ()
        for event in early:
            self._take(event)

    def _open_journal(self, head: list) -> None:
        events = self._journal.events()
        if self._journal.resumed and next(events, None) == head:
            self._replay(events)
            self._take(["resumed"])
        else:
            self._journal.begin()
            self._journal.write(head)

    def _replay(self, events) -> None:
        for event in events:
            self._apply(event)

    def time_left_s(self) -> float:
        """What the rest of the route takes at the ideal speeds, stretched as the way so far was, seconds of the drive's time."""
        ideal_s = float(np.interp(self.drive.samples[-1].s_m, self._route.s, self._ideal_s))
        stretched = max(1.0, self.drive.duration_s / ideal_s) if ideal_s > _SETTING_OFF_S else 1.0
        return stretched * (self.ideal_duration_s - ideal_s)

    def _new_drive(self) -> RouteProgress:
        return RouteProgress(
            self._route,
            self.rules.drive_limits(self.ideal_duration_s),
            keep_samples=self._journal is None,
        )

    def odometry(
        self, stamp_ns: int, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> bool:
        """Where the car is; returns whether that was news."""
        return self._take(["odometry", stamp_ns, x_m, y_m, yaw_rad, speed_mps])

    def command(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        """What the car is told; it answers the odometry with its stamp, or else the last one heard."""
        self._take(["command", stamp_ns, throttle, brake, steer])

    def planned(self, speed_mps: float) -> None:
        """The planned speed at the car's place."""
        self._take(["planned", speed_mps])

    def obstacle(self, number: int, kind: str) -> None:
        """A body with this number is of this kind, as the obstacles topic calls it."""
        if self._kinds.get(number) != kind:
            self._take(["obstacle", number, kind])

    def stop_lines(self, lines: dict) -> None:
        """Where the traffic lights' stop lines are: (x, y, half the width) in metres by their lights' numbers."""
        self._take(["stop_lines", [[number, *line] for number, line in lines.items()]])

    def lights(self, stamp_ns: int, states: dict) -> None:
        """What the traffic lights show, by their numbers. A stamp of 0: just now."""
        if self._red_lights.is_news(states):
            self._take(["lights", stamp_ns, [list(item) for item in states.items()]])

    def collision(self, stamp_ns: int, number: int) -> None:
        """The car ran into the body with this number. A stamp of 0: just now."""
        self._take(["collision", stamp_ns, number])

    def infraction(self, name: str) -> None:
        """Count a key of the report's infractions, such as red_light. Raises ValueError for another name."""
        if name not in COEFFICIENTS:
            raise ValueError(f"'{name}' is no infraction; they are: {', '.join(COEFFICIENTS)}")
        self._take(["infraction", name])

    def wall_clock(self, now_s: float) -> None:
        """Tell the wall clock's time: it counts while the drive begins. Lockstep repeats its first tick until all are there."""
        if self.answers.asked < 2:
            self._take(["wall_clock", now_s])

    def _take(self, event: list):
        if self.drive is None:
            self._early.append(event)
            return True
        if self._journal is not None:
            self._journal.write(event)
        return self._apply(event)

    def _apply(self, event: list):
        return getattr(self, "_on_" + event[0])(*event[1:])

    def _on_odometry(self, stamp_ns, x_m, y_m, yaw_rad, speed_mps) -> bool:
        if self.over:
            return False
        time_s = stamp_ns / _NANOSECONDS
        last_s = self._timeline.now_s
        moment = self._timeline.take(time_s)
        if moment == LEFT_OUT:
            return False
        if moment == RESTARTED:
            self.world_restarts += 1
            self.drive = self._new_drive()
            self.answers = CommandMatching()
            self._begin()
            self._timeline.take(time_s)
        elif last_s is not None and time_s - last_s > _UNSEEN_S:
            self.unseen_s += time_s - last_s
            self._red_lights.begin()
        self.answers.ask(stamp_ns)
        self.drive.update(time_s, x_m, y_m, yaw_rad, speed_mps)
        self._run_red_lights(
            self._red_lights.move(stamp_ns, self._route, self.drive.samples[-1].s_m)
        )
        if self._journal is None:
            self._stamps.append(stamp_ns)
            self._fallbacks.append(self._fallbacks[-1] if self._fallbacks else None)
        return True

    def _on_command(self, stamp_ns, throttle, brake, steer) -> None:
        self.answers.answer(stamp_ns)
        if self._journal is None:
            self._commands.setdefault(stamp_ns, (throttle, brake, steer))
            if self._fallbacks:
                self._fallbacks[-1] = (throttle, brake, steer)

    def _on_planned(self, speed_mps) -> None:
        if self._journal is None and self.drive.samples and not self.over:
            self._planned.append((self.drive.samples[-1].s_m, speed_mps))

    def _on_obstacle(self, number, kind) -> None:
        self._kinds[number] = kind

    def _on_stop_lines(self, lines) -> None:
        self._red_lights.place({number: line for number, *line in lines})

    def _on_lights(self, stamp_ns, states) -> None:
        self._run_red_lights(
            self._red_lights.show(stamp_ns, {number: state for number, state in states})
        )

    def _run_red_lights(self, count: int) -> None:
        for _ in range(0 if self.over else count):
            self.drive.infraction("red_light")

    def _on_collision(self, stamp_ns, number) -> None:
        if self.over:
            return
        kind = _KINDS.get(self._kinds.get(number), "vehicle" if number else "static")
        self.drive.collision(kind, stamp_ns / _NANOSECONDS if stamp_ns else None)

    def _on_infraction(self, name) -> None:
        if not self.over:
            self.drive.infraction(name)

    def _on_wall_clock(self, now_s) -> None:
        self.began_at_s = now_s

    def _on_resumed(self) -> None:
        self.referee_restarts += 1

    def result(self, ended_at_s: float = None) -> DriveResult:
        """The drive as it is reported; ended_at_s on the clock of `wall_clock`, None where none ran."""
        if self._journal is not None:
            again = Evaluator(self.rules)
            again.mission(self._route.points)
            events = self._journal.events()
            next(events)
            again._replay(events)
            return again.result(ended_at_s)
        figures = self.drive.figures(self.ideal_duration_s, self.rules.lane_width_m)
        wall_s = (
            ended_at_s - self.began_at_s
            if ended_at_s is not None and self.began_at_s is not None
            else None
        )
        figures.update(
            wall_duration_s=wall_s,
            real_time_factor=figures["duration_s"] / max(wall_s, 1e-3)
            if wall_s is not None
            else None,
            ticks=len(self.drive.samples),
            missed_ticks=self.answers.missed,
            unseen_s=self.unseen_s,
            referee_restarts=self.referee_restarts,
            world_restarts=self.world_restarts,
            assumed_limits=list(self.rules.assumed),
        )
        planned = np.array(self._planned, dtype=float).reshape(-1, 2)
        return DriveResult(
            figures, self.drive, self._answers_to_samples(), planned, self._limit_mps
        )

    def _answers_to_samples(self) -> np.ndarray:
        commands = np.full((len(self.drive.samples), 3), math.nan)
        for row, (stamp_ns, fallback) in enumerate(
            zip(self._stamps[: len(commands)], self._fallbacks)
        ):
            answer = self._commands.get(stamp_ns, fallback)
            if answer is not None:
                commands[row] = answer
        return commands
