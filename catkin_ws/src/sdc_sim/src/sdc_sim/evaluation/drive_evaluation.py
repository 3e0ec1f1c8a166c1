"""Evaluation of one drive along a known route, event by event."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_reasons import REPEAT_NS
from sdc_sim.evaluation.command_matching import COMMAND_FIELDS, CommandMatching, CommandTrace
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.evaluation.reason_trace import ReasonTrace
from sdc_sim.evaluation.route_progress import COMPLETED, DriveSample, RouteProgress
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.evaluation.scene_record import LIGHTS, SceneRecord
from sdc_sim.evaluation.stamp_filter import StampFilter

# The numbers in a row of the trace.
COLUMNS = (*DriveSample._fields, *COMMAND_FIELDS)
_NS_PER_S = 1_000_000_000
# A longer time between two odometry messages counts as unseen.
_MAX_GAP_S = 1.0
# The pace of the first seconds does not predict the rest of the drive.
_MIN_PACE_S = 5.0
# Kinds of obstacles and the report's names for them.
_COLLISION_KINDS = {"car": "vehicle", "pedestrian": "pedestrian", "obstacle": "static"}


@dataclass
class DriveResult:
    """An evaluated drive.

    Attributes:
        metrics: the content of report.json
        progress: the samples and events of the drive
        commands: (n, 3) throttle, brake and steer of each of these samples, NaN if unknown
        reasons: what limited the speed in each of these samples, "" if unknown
        planned: (m, 3) arc length [m], planned speed [m/s] and time [s]
        limit_mps: (N,) greatest speed at each point of the route [m/s]
        snapshots: time [s], completed share of the route [%] and JPEG of each camera picture
        scene: what was around the car
        stop_lines: StopLine of each traffic light by id
    """

    metrics: dict
    progress: RouteProgress
    commands: np.ndarray
    reasons: list[str]
    planned: np.ndarray
    limit_mps: np.ndarray
    snapshots: list
    scene: SceneRecord
    stop_lines: dict

    @property
    def rows(self) -> np.ndarray:
        """Return the rows of the trace of these samples: (n, 11)."""
        return np.hstack([self.progress.rows, self.commands])


class DriveEvaluation:
    """The state of a drive after the events so far.

    An event is a list: its name and its arguments. For each name there is a method `_on_NAME`.
    Stamps are integers [ns].
    """

    def __init__(self, rules: EvaluationRules, route: Route, keep_trace: bool):
        """Start an evaluation.

        Args:
            rules: what the drive is evaluated by
            route: the route of the mission
            keep_trace: keep all samples, commands and reasons, which `result` needs
        """
        self.route = route
        self.ideal = IdealDrive(route, rules.speed_limits())
        limits = rules.termination_limits(self.ideal.duration_s)
        self.progress = RouteProgress(route, limits, keep_samples=keep_trace)
        self.scene = SceneRecord(keep=keep_trace)
        self.matching = CommandMatching()
        self.unseen_s = 0.0
        self._rules = rules
        self._keep_trace = keep_trace
        self._snapshots: list = []
        self._red_lights = RedLightDetector(rules.car_front_m)
        self._obstacle_kinds: dict = {}
        self._started_at_s: float | None = None
        self._stamps = StampFilter()
        self._commands = CommandTrace()
        self._reasons = ReasonTrace()
        self._last_reason_ns: int | None = None
        self._planned: list = []

    @property
    def over(self) -> bool:
        """Return whether the drive has ended."""
        return self.progress.status is not None

    @property
    def awaits_messages(self) -> bool:
        """Return whether messages about the ticks so far are on their way, unless a node ended."""
        last_ns, reason_ns = self.matching.last_stamp, self._last_reason_ns
        if self.matching.pending or last_ns is None or reason_ns is None:
            return self.matching.pending
        return last_ns - reason_ns >= REPEAT_NS

    def apply(self, event: list) -> bool:
        """Apply one event; return False for an odometry that is ignored."""
        return getattr(self, "_on_" + event[0])(*event[1:]) is not False

    @property
    def needs_wall_clock(self) -> bool:
        """Return whether the drive has started and its start on the wall clock is unknown."""
        return bool(self.progress.samples) and self._started_at_s is None

    def is_new_kind(self, obstacle_id: int, kind: str) -> bool:
        """Return whether the kind of an obstacle is not known yet."""
        return self._obstacle_kinds.get(obstacle_id) != kind

    def needs_lights(self, states: dict) -> bool:
        """Return whether these states of the traffic lights change anything."""
        return self._red_lights.is_relevant(states)

    def time_left_s(self) -> float:
        """Return the simulated time [s] to the end of the route at the pace of the drive so far."""
        ideal_s = self.ideal.time_at(self.progress.samples[-1].s_m)
        pace = max(1.0, self.progress.duration_s / ideal_s) if ideal_s > _MIN_PACE_S else 1.0
        return pace * (self.ideal.duration_s - ideal_s)

    def result(self, ended_at_s: float | None) -> DriveResult:
        """Return the evaluated drive.

        Args:
            ended_at_s: wall clock at the end of the drive [s], None without a wall clock
        """
        ticks = len(self.progress.samples)
        least_s = self.ideal.duration_s
        if self.progress.status == COMPLETED:
            least_s = self.ideal.least_time_s(
                self.progress.column("s_m"), self.progress.column("cross_track_m")
            )
        metrics = self.progress.metrics(least_s, self._rules.lane_width_m)
        wall_s = None
        if ended_at_s is not None and self._started_at_s is not None:
            wall_s = ended_at_s - self._started_at_s
        metrics.update(
            wall_duration_s=wall_s,
            real_time_factor=None if wall_s is None else metrics["duration_s"] / max(wall_s, 1e-3),
            ticks=ticks,
            missed_ticks=self.matching.missed,
            ticks_by_stamp=self.matching.answered,
            ticks_by_order=self.matching.by_order,
            unseen_s=self.unseen_s,
            referee_restarts=0,
            world_restarts=0,
            assumed_limits=list(self._rules.assumed),
        )
        return DriveResult(
            metrics,
            self.progress,
            self._commands.as_array(ticks),
            [self._reasons.at(stamp_ns) for stamp_ns in self._commands.stamps[:ticks]],
            np.fromiter(chain.from_iterable(self._planned), float).reshape(-1, 3),
            self.ideal.speed_mps,
            self._snapshots,
            self.scene,
            self._red_lights.lines,
        )

    def _on_odometry(
        self, stamp_ns: int, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> bool:
        if self.over:
            return False
        time_s = stamp_ns / _NS_PER_S
        last_s = self._stamps.last_s
        if not self._stamps.accepts(time_s):
            return False
        if last_s is not None and time_s - last_s > _MAX_GAP_S:
            self.unseen_s += time_s - last_s
            self._red_lights.reset_car()
        self.matching.add_odometry(stamp_ns)
        sample = self.progress.update(time_s, x_m, y_m, yaw_rad, speed_mps)
        self._count_red(self._red_lights.update_car(stamp_ns, self.route, sample.s_m))
        if self._keep_trace:
            self._commands.add_odometry(stamp_ns)
        return True

    def _on_command(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        self.matching.add_command(stamp_ns)
        if self._keep_trace:
            self._commands.add_command(stamp_ns, throttle, brake, steer)

    def _on_planned(self, speed_mps: float) -> None:
        if self._keep_trace and self.progress.samples and not self.over:
            last = self.progress.samples[-1]
            self._planned.append((last.s_m, speed_mps, last.time_s))

    def _on_reason(self, stamp_ns: int, name: str) -> None:
        self._last_reason_ns = max(stamp_ns, self._last_reason_ns or stamp_ns)
        if self._keep_trace:
            self._reasons.add(stamp_ns, name)

    def _on_scene(self, kind: str, time_s: float | None, content: Any) -> None:
        if time_s is None and self.progress.samples:
            time_s = self.progress.samples[-1].time_s
        if time_s is not None:
            self.scene.add(kind, time_s, content)

    def _on_obstacle(self, obstacle_id: int, kind: str) -> None:
        self._obstacle_kinds[obstacle_id] = kind

    def _on_stop_lines(self, lines: list) -> None:
        self._red_lights.set_lines({light_id: line for light_id, *line in lines})

    def _on_lights(self, stamp_ns: int, states_by_id: list) -> None:
        states = dict(states_by_id)
        self._on_scene(LIGHTS, stamp_ns / _NS_PER_S if stamp_ns else None, states)
        self._count_red(self._red_lights.update_lights(stamp_ns, states))

    def _count_red(self, count: int) -> None:
        for _ in range(0 if self.over else count):
            self.progress.add_infraction("red_light")

    def _on_collision(self, stamp_ns: int, obstacle_id: int) -> None:
        if self.over:
            return
        # CARLA gives static scenery the id 0. Another actor of unknown kind is likely a vehicle.
        kind = _COLLISION_KINDS.get(
            self._obstacle_kinds.get(obstacle_id, ""), "vehicle" if obstacle_id else "static"
        )
        self.progress.add_collision(kind, stamp_ns / _NS_PER_S if stamp_ns else None)

    def _on_infraction(self, name: str) -> None:
        if not self.over:
            self.progress.add_infraction(name)

    def _on_wall_clock(self, now_s: float) -> None:
        self._started_at_s = now_s

    def _on_snapshot(self, time_s: float, percent: float, jpeg: str) -> None:
        if self._keep_trace:
            self._snapshots.append((time_s, percent, base64.b64decode(jpeg)))
