"""Evaluation of one drive along a known route, event by event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Protocol

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.evaluation.command_matching import COMMAND_FIELDS, CommandMatching, CommandTrace
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.evaluation.reason_trace import ReasonTrace
from sdc_sim.evaluation.route_progress import COMPLETED, DriveSample, RouteProgress
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.evaluation.scene_record import LIGHTS, SceneRecord
from sdc_sim.evaluation.timeline import IGNORED, RESTARTED, Timeline

_NS_PER_S = 1_000_000_000
# A longer time between two odometry messages counts as unseen.
_MAX_GAP_S = 1.0
# The pace of the first seconds does not predict the rest of the drive.
_MIN_PACE_S = 5.0
# Commands of a tick can arrive during so many later ones; then its row of the trace is complete.
_OPEN_TICKS = 1000
_STORED_TICKS = 200
# Kinds of obstacles and the report's names for them.
_COLLISION_KINDS = {"car": "vehicle", "pedestrian": "pedestrian", "obstacle": "static"}


class TraceStore(Protocol):
    """Stores the complete rows of a trace: the fields of DriveSample, then throttle, brake, steer.

    Attributes:
        failure: why rows cannot be stored, or None
    """

    failure: OSError | None

    def append(self, rows: np.ndarray, reasons: Sequence[str]) -> None:
        """Store (n, 11) rows and what limited the speed in each."""

    def rows(self) -> np.ndarray:
        """Return all stored rows: (n, 11)."""

    def clear(self) -> None:
        """Remove all rows."""


@dataclass
class DriveResult:
    """An evaluated drive.

    Attributes:
        metrics: the content of report.json
        progress: the samples and events of the drive; with a trace store, the newest samples only
        commands: (n, 3) throttle, brake and steer of each of these samples, NaN if unknown
        reasons: what limited the speed in each of these samples, "" if unknown
        planned: (m, 3) arc length [m], planned speed [m/s] and time [s]; with a trace store, empty
        limit_mps: (N,) greatest speed at each point of the route [m/s]
        snapshots: time [s], completed share of the route [%] and JPEG of each camera picture
        scene: what was around the car; with a trace store, only the newest
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

    def __init__(
        self,
        rules: EvaluationRules,
        route: Route,
        keep_trace: bool,
        trace_store: TraceStore | None = None,
    ):
        """Start an evaluation.

        Args:
            rules: what the drive is evaluated by
            route: the route of the mission
            keep_trace: keep all samples and commands, which `result` needs
            trace_store: takes the complete rows of the trace, which are then not kept in memory
        """
        self.route = route
        self.ideal = IdealDrive(route, rules.speed_limits())
        self.world_restarts = 0
        self.referee_restarts = 0
        self.unseen_s = 0.0
        self._rules = rules
        self._keep_trace = keep_trace
        self._trace_store = trace_store
        self._snapshots: list = []
        self._red_lights = RedLightDetector(rules.car_front_m)
        self._obstacle_kinds: dict = {}
        self._start()

    def _start(self) -> None:
        self.progress = RouteProgress(
            self.route,
            self._rules.termination_limits(self.ideal.duration_s),
            keep_samples=self._keep_trace,
        )
        self.matching = CommandMatching()
        self._started_at_s: float | None = None
        self._timeline = Timeline()
        self._red_lights.reset_car()
        self._commands = CommandTrace()
        self._reasons = ReasonTrace()
        self._planned: list = []
        self.scene = SceneRecord(keep=self._keeps_all)
        if self._trace_store is not None:
            self._trace_store.clear()

    @property
    def _keeps_all(self) -> bool:
        return self._keep_trace and self._trace_store is None

    @property
    def over(self) -> bool:
        """Return whether the drive has ended."""
        return self.progress.status is not None

    @property
    def awaits_messages(self) -> bool:
        """Return whether messages about the ticks so far are on their way, unless a node ended."""
        stamps = self._commands.stamps(len(self.progress.samples))
        return self.matching.pending or (bool(stamps) and self._reasons.is_late(stamps[-1]))

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

    def _column(self, name: str, stored: np.ndarray | None) -> np.ndarray:
        """Return one field of all samples, the stored ones first: (n,)."""
        column = self.progress.column(name)
        if stored is None:
            return column
        return np.concatenate([stored[:, DriveSample._fields.index(name)], column])

    def result(self, ended_at_s: float | None) -> DriveResult:
        """Return the evaluated drive.

        Args:
            ended_at_s: wall clock at the end of the drive [s], None without a wall clock
        """
        stored = None
        if self._trace_store is not None:
            stored = self._trace_store.rows()[:, : -len(COMMAND_FIELDS)]
        least_s = self.ideal.duration_s
        if self.progress.status == COMPLETED:
            least_s = self.ideal.least_time_s(
                *(self._column(name, stored) for name in ("s_m", "cross_track_m"))
            )
        metrics = self.progress.metrics(least_s, self._rules.lane_width_m, stored)
        wall_s = None
        if ended_at_s is not None and self._started_at_s is not None:
            wall_s = ended_at_s - self._started_at_s
        metrics.update(
            wall_duration_s=wall_s,
            real_time_factor=None if wall_s is None else metrics["duration_s"] / max(wall_s, 1e-3),
            ticks=len(self.progress.samples) + (0 if stored is None else len(stored)),
            missed_ticks=self.matching.missed,
            ticks_by_stamp=self.matching.answered,
            ticks_by_order=self.matching.by_order,
            unseen_s=self.unseen_s,
            referee_restarts=self.referee_restarts,
            world_restarts=self.world_restarts,
            assumed_limits=list(self._rules.assumed),
        )
        return DriveResult(
            metrics,
            self.progress,
            self._commands.as_array(len(self.progress.samples)),
            self._reasons_of(len(self.progress.samples)),
            np.fromiter(chain.from_iterable(self._planned), float).reshape(-1, 3),
            self.ideal.speed_mps,
            self._snapshots,
            self.scene,
            self._red_lights.lines,
        )

    def _reasons_of(self, ticks: int) -> list[str]:
        """Return the reason of each of the first ticks, for a drive that keeps its trace."""
        return [self._reasons.at(stamp_ns) for stamp_ns in self._commands.stamps(ticks)]

    def _on_odometry(
        self, stamp_ns: int, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> bool:
        if self.over:
            return False
        time_s = stamp_ns / _NS_PER_S
        last_s = self._timeline.now_s
        step = self._timeline.advance(time_s)
        if step == IGNORED:
            return False
        if step == RESTARTED:
            self.world_restarts += 1
            self._start()
            self._timeline.advance(time_s)
        elif last_s is not None and time_s - last_s > _MAX_GAP_S:
            self.unseen_s += time_s - last_s
            self._red_lights.reset_car()
        self.matching.add_odometry(stamp_ns)
        sample = self.progress.update(time_s, x_m, y_m, yaw_rad, speed_mps)
        self._count_red(self._red_lights.update_car(stamp_ns, self.route, sample.s_m))
        if self._keep_trace:
            self._commands.add_odometry(stamp_ns)
        if self._trace_store is not None:
            self._store_rows(self._trace_store)
        return True

    def _store_rows(self, store: TraceStore) -> None:
        if len(self.progress.samples) < _OPEN_TICKS + _STORED_TICKS:
            return
        samples = np.array(self.progress.samples[:_STORED_TICKS], dtype=float)
        rows = np.hstack([samples, self._commands.as_array(_STORED_TICKS)])
        store.append(rows, self._reasons_of(_STORED_TICKS))
        self._reasons.forget_before(self._commands.stamps(_STORED_TICKS)[-1])
        self.progress.forget(_STORED_TICKS)
        self._commands.forget(_STORED_TICKS)

    def _on_command(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        self.matching.add_command(stamp_ns)
        if self._keep_trace:
            self._commands.add_command(stamp_ns, throttle, brake, steer)

    def _on_planned(self, speed_mps: float) -> None:
        if self._keeps_all and self.progress.samples and not self.over:
            last = self.progress.samples[-1]
            self._planned.append((last.s_m, speed_mps, last.time_s))

    def _on_reason(self, stamp_ns: int, name: str) -> None:
        if self._keep_trace:
            self._reasons.add(stamp_ns, name)

    def _on_scene(self, kind: str, time_s: float | None, content: Any) -> None:
        if time_s is None and self.progress.samples:
            time_s = self.progress.samples[-1].time_s
        if time_s is not None:
            self.scene.add(kind, time_s, content)

    def _on_obstacle(self, obstacle_id: int, kind: str) -> None:
        self._obstacle_kinds[obstacle_id] = kind

    def _on_stop_lines(self, lines: dict) -> None:
        self._red_lights.set_lines(lines)

    def _on_lights(self, stamp_ns: int, states: dict) -> None:
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

    def _on_snapshot(self, time_s: float, percent: float, jpeg: bytes) -> None:
        self._snapshots.append((time_s, percent, jpeg))

    def _on_resumed(self) -> None:
        self.referee_restarts += 1
