"""Evaluation of one drive along a known route, event by event."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Any

import numpy as np

from sdc_common.driving import REASON_REPEAT_NS
from sdc_common.geometry.road_line import road_route
from sdc_common.geometry.route import Route
from sdc_map.crossings import limits_along
from sdc_map.network_file import load_network
from sdc_sim.evaluation.command_matching import COMMAND_FIELDS, CommandTrace
from sdc_sim.evaluation.ideal_drive import IdealDrive
from sdc_sim.evaluation.infractions import RedLightDetector
from sdc_sim.evaluation.route_progress import COMPLETED, DriveSample, RouteProgress
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.evaluation.street_rules import StreetRules

# The numbers in a row of the trace.
COLUMNS = (*DriveSample._fields, *COMMAND_FIELDS)
# What was around the car: rows of x, y [m] and target speed [m/s] of the path; rows of id, x, y
# [m], yaw [rad], length and width [m] of obstacles; states of lights by id; a JPEG in base64.
PATH, OBSTACLES, LIGHTS, PICTURE = "path", "obstacles", "lights", "picture"
_SCENE_INTERVAL_S = 0.5
_NS_PER_S = 1_000_000_000
# A longer time between two odometry messages counts as unseen.
_MAX_GAP_S = 1.0
_AT_REST_MPS = 0.5  # a slower car may wait for a red light
# The pace of the first seconds does not predict the rest of the drive.
_MIN_PACE_S = 5.0
# A reason applies until the next one, but no longer than this after its stamp.
_REASON_VALID_NS = 1_000_000_000
_MAX_REASON_LENGTH, _MAX_DETAIL_LENGTH = 40, 80
_JOIN_M = 30.0  # another mission begins within this distance of the car along the last mission
_APART_M = 0.5  # least distance of its first point from the last point that is kept
# Kinds of obstacles and the report's names for them.
_COLLISION_KINDS = {"pedestrian": "pedestrian", "obstacle": "static"}


class DriveEvaluation:
    """The state of a drive after the events so far.

    An event is a list: its name and its arguments. For each name there is a method `_on_NAME`,
    whose parameters are the arguments. Stamps are integers [ns]; of lights and collisions, 0 means
    now.
    """

    def __init__(self, rules: EvaluationRules, route: Route, keep_trace: bool):
        """Start an evaluation; `keep_trace` keeps all that a report needs."""
        self.route = route
        self._network = load_network(rules.map) if rules.map else None
        # The fastest drive, with the greatest speed at each point of the route.
        self.ideal = self._ideal_drive(rules)
        timeout_s = rules.timeout_s(self.ideal.duration_s)
        self.progress = RouteProgress(route, rules, timeout_s, keep_samples=keep_trace)
        self._mission_m: list = []
        self._keep_trace = keep_trace
        self._unseen_s = 0.0
        self._wall_s: list = []
        # Entries (time [s], content) of what was around the car, by kind.
        self.scene: dict[str, list] = defaultdict(list)
        # Time [s], completed share of the route [%] and JPEG in base64 of each snapshot.
        self.snapshots: list = []
        self._red_lights = RedLightDetector(rules.car_front_m)
        self._streets = None
        if self._network is not None:
            self._streets = StreetRules(self._network, rules.car_front_m)
            self.progress.on_lane_s = self._streets.on_lane_s
        self._obstacle_kinds: dict = {}
        self._collision: tuple[int, float] | None = None  # id of the obstacle, and time [s]
        self._last_ns = self._last_command_ns = self._last_reason_ns = 0
        self._commands = CommandTrace()
        self.refused_commands = 0  # the world refuses a command with NaN or infinity
        self._reasons: list = []
        self._details: list = []
        self._lane_offsets: dict = {}  # offset in the lane that the camera measured [m] by stamp
        self.planned: list = []  # rows of arc length [m], planned speed [m/s] and time [s]

    def _ideal_drive(self, rules: EvaluationRules) -> IdealDrive:
        network, route = self._network, self.route
        road_mps = limits_along(network, route) if network else np.inf
        return IdealDrive(route, rules.speed_limits(), road_mps)

    @property
    def over(self) -> bool:
        """Return whether the drive has ended."""
        return self.progress.status is not None

    @property
    def awaits_messages(self) -> bool:
        """Return whether messages about the ticks so far are on their way, unless a node ended.

        They are those of a stack whose commands carry stamps, and its reasons if it has any.
        """
        return bool(
            (self._last_command_ns and self._last_command_ns < self._last_ns)
            or (self._last_reason_ns and self._last_ns - self._last_reason_ns >= REASON_REPEAT_NS)
        )

    def changes(self, event: list) -> bool:
        """Return whether an event differs from the last one of its kind, as far as it must."""
        name, *arguments = event
        if name == "obstacle":
            return self._obstacle_kinds.get(arguments[0]) != arguments[1]
        return name != "lights" or self._red_lights.is_relevant(dict(arguments[1]))

    def apply(self, event: list) -> bool:
        """Apply one event; return False for an odometry that is ignored."""
        return getattr(self, "_on_" + event[0])(*event[1:]) is not False

    def is_scene_due(self, kind: str) -> bool:
        """Return whether the page of the report needs the present content of this kind."""
        if not self.progress.samples:
            return False
        entries, now_s = self.scene[kind], self.progress.samples[-1].time_s
        return not entries or not 0.0 <= now_s - entries[-1][0] < _SCENE_INTERVAL_S

    def time_left_s(self) -> float:
        """Return the simulated time [s] to the end of the route at the pace of the drive so far."""
        ideal_s = self.ideal.time_at(self.progress.samples[-1].s_m)
        pace = max(1.0, self.progress.duration_s / ideal_s) if ideal_s > _MIN_PACE_S else 1.0
        return pace * (self.ideal.duration_s - ideal_s)

    @property
    def metrics(self) -> dict:
        """Return the content of report.json."""
        least_s = self.ideal.duration_s
        if self.progress.status == COMPLETED:
            least_s = self.ideal.least_time_s(
                self.progress.column("s_m"), self.progress.column("cross_track_m")
            )
        metrics = self.progress.metrics(least_s)
        wall_s = self._wall_s[-1] - self._wall_s[0] if self._wall_s else None
        metrics.update(
            wall_duration_s=wall_s,
            real_time_factor=None if wall_s is None else metrics["duration_s"] / max(wall_s, 1e-3),
            ticks=len(self.progress.samples),
            **self._commands.counts(),
            unseen_s=self._unseen_s,
            referee_restarts=0,
            world_restarts=0,
            assumed_limits=list(self.progress.rules.assumed),
        )
        if self._streets:
            hit = self._collision and self._streets.is_at_fault(*self._collision)
            metrics["collisions_at_fault"] = int(bool(hit))
        if self._lane_offsets:
            metrics["lane_offset_rms_error_m"] = self._lane_offset_rms_error_m()
        return metrics

    def _lane_offset_rms_error_m(self) -> float | None:
        """Return how well the camera measures; pictures of the last second may be on their way."""
        places = zip(self._commands.stamps, self.progress.column("cross_track_m"))
        errors = [
            self._lane_offsets[stamp] - cross_track_m
            for stamp, cross_track_m in places
            if stamp in self._lane_offsets and stamp < self._last_ns - _NS_PER_S
        ]
        return float(np.sqrt(np.mean(np.square(errors)))) if errors else None

    @property
    def commands(self) -> np.ndarray:
        """Return throttle, brake and steer of each sample, NaN if unknown: (n, 3)."""
        return self._commands.as_array(len(self.progress.samples))

    @property
    def rows(self) -> np.ndarray:
        """Return the rows of the trace: (n, len(COLUMNS))."""
        return np.hstack([self.progress.rows, self.commands])

    @property
    def reasons(self) -> list[str]:
        """Return what limited the speed in each sample, "" if unknown.

        Of two reasons with the same stamp, the later one applies.
        """
        return self._at_samples(self._reasons)

    @property
    def details(self) -> list[str]:
        """Return because of whom, for each sample, "" if the reason says it all."""
        return self._at_samples(self._details)

    def _at_samples(self, texts: list) -> list[str]:
        stamps = self._commands.stamps[: len(self.progress.samples)]
        texts = [(-_REASON_VALID_NS, ""), *sorted(texts, key=lambda text: text[0])]
        since = np.array([stamp for stamp, _ in texts])
        places = np.searchsorted(since, stamps, side="right") - 1
        valid = np.subtract(stamps, since[places]) <= _REASON_VALID_NS
        return [texts[place][1] if is_valid else "" for place, is_valid in zip(places, valid)]

    @property
    def stop_lines(self) -> dict:
        """Return the StopLine of each traffic light by its id."""
        return self._red_lights.lines

    def _on_odometry(
        self,
        stamp_ns: int,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        wall_s: float | None = None,
        z_m: float = math.nan,
    ) -> bool:
        seen = bool(self.progress.samples)
        if self.over or (seen and stamp_ns <= self._last_ns):
            return False
        time_s, last_s = stamp_ns / _NS_PER_S, self._last_ns / _NS_PER_S
        if seen and time_s - last_s > _MAX_GAP_S:
            self._unseen_s += time_s - last_s
            self._red_lights.reset_car()
        self._last_ns = stamp_ns
        if wall_s is not None:
            self._wall_s[1:] = [wall_s]  # the first and the last
        may_wait = seen and speed_mps < _AT_REST_MPS
        if may_wait and self._red_lights.holds(self.route, self.progress.samples[-1].s_m, z_m):
            self.progress.wait_until(time_s)
        sample = self.progress.update(time_s, x_m, y_m, yaw_rad, speed_mps)
        self._count_red(self._red_lights.update_car(stamp_ns, self.route, sample.s_m, z_m))
        if self._streets:
            self._count(self._streets.add_car(stamp_ns, sample, z_m))
        if self._keep_trace:
            self._commands.stamps.append(stamp_ns)
        return True

    def _on_mission(self, points_m: list) -> None:
        """Continue along another mission; the route keeps what was driven of the last one."""
        progress, rules = self.progress, self.progress.rules
        if self.over or points_m == self._mission_m:
            return
        self._mission_m = points_m
        line = road_route(np.array(points_m, float)).points
        near_m = progress.samples[-1].s_m if progress.samples else 0.0
        x, y = line[0].tolist()
        join_m = self.route.line.project(x, y, near_m, _JOIN_M, _JOIN_M).s_m
        driven = self.route.points[self.route.s < join_m - _APART_M]
        self.route = Route(np.vstack([driven, line]))
        self.ideal = self._ideal_drive(rules)
        progress.follow(self.route, rules.timeout_s(self.ideal.duration_s))

    def _on_command(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        self.refused_commands += not all(map(math.isfinite, (throttle, brake, steer)))
        self._answer(stamp_ns, throttle, brake, steer)

    def _on_target(self, *_target: float) -> None:
        """Add a command of unknown pedals."""
        self._answer(0, math.nan, math.nan, math.nan)

    def _answer(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        self._last_command_ns = stamp_ns
        if self._keep_trace:
            self._commands.add_command(stamp_ns, throttle, brake, steer)

    def _on_planned(self, speed_mps: float) -> None:
        if self._keep_trace and self.progress.samples and not self.over:
            last = self.progress.samples[-1]
            self.planned.append((last.s_m, speed_mps, last.time_s))

    def _on_reason(self, stamp_ns: int, name: str) -> None:
        self._last_reason_ns = max(stamp_ns, self._last_reason_ns)
        if self._keep_trace:
            self._reasons.append((stamp_ns, name[:_MAX_REASON_LENGTH]))

    def _on_detail(self, stamp_ns: int, text: str) -> None:
        if self._keep_trace:
            self._details.append((stamp_ns, text[:_MAX_DETAIL_LENGTH]))

    def _on_lane_offset(self, stamp_ns: int, offset_m: float) -> None:
        if self._keep_trace and np.isfinite(offset_m):
            self._lane_offsets[stamp_ns] = offset_m

    def _on_scene(self, kind: str, time_s: float | None, content: Any) -> None:
        """Add what is around the car; without a time [s], that of the last odometry."""
        if time_s is None and self.progress.samples:
            time_s = self.progress.samples[-1].time_s
        if time_s is not None:
            if not self._keep_trace:
                self.scene[kind].clear()
            self.scene[kind].append((time_s, content))

    def _on_obstacle(self, obstacle_id: int, kind: str) -> None:
        self._obstacle_kinds[obstacle_id] = kind

    def _on_others(self, stamp_ns: int, rows: list) -> None:
        """Add all other road users of a map at the time of an odometry, see StreetRules."""
        if self._streets:
            self._count(self._streets.add_others(stamp_ns, rows))

    def _on_stop_lines(self, lines: list) -> None:
        self._red_lights.set_lines({light_id: line for light_id, *line in lines})

    def _on_lights(self, stamp_ns: int, states_by_id: list) -> None:
        states = dict(states_by_id)
        self._on_scene(LIGHTS, stamp_ns / _NS_PER_S if stamp_ns else None, states)
        self._count_red(self._red_lights.update_lights(stamp_ns, states))

    def _count_red(self, count: int) -> None:
        self._count([("red_light", None)] * count)

    def _count(self, infractions: list) -> None:
        for name, sample in [] if self.over else infractions:
            self.progress.add_infraction(name, sample)

    def _on_collision(self, stamp_ns: int, obstacle_id: int) -> None:
        if self.over or self._collision:
            return
        self._collision = obstacle_id, (stamp_ns or self._last_ns) / _NS_PER_S
        # CARLA gives static scenery the id 0. Another actor of unknown kind is likely a vehicle.
        kind = _COLLISION_KINDS.get(
            self._obstacle_kinds.get(obstacle_id, ""), "vehicle" if obstacle_id else "static"
        )
        self.progress.add_collision(kind, stamp_ns / _NS_PER_S if stamp_ns else None)

    def _on_snapshot(self, time_s: float, percent: float, jpeg: str) -> None:
        if self._keep_trace:
            self.snapshots.append((time_s, percent, jpeg))
