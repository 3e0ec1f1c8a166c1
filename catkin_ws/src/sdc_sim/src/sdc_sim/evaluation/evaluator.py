"""Evaluation of a drive from its messages, as plain numbers."""

from __future__ import annotations

import base64
from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from sdc_common.geometry.road_line import road_route
from sdc_common.ros.stop_lines import StopLine
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation, DriveResult
from sdc_sim.evaluation.event_file import EventFile
from sdc_sim.evaluation.metrics import COEFFICIENTS
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.evaluation.scene_record import PICTURE

# Events before the route are kept up to this number: in lockstep, odometry can be some ticks ahead.
_MAX_EARLY_EVENTS = 3000


class Evaluator:
    """The evaluation of one drive, whose events can arrive in any order across topics.

    With a file of events, no samples are kept in memory, so that a drive can last for days:
    `result` evaluates the file.
    """

    def __init__(self, rules: EvaluationRules, event_file: EventFile | None = None):
        self.rules = rules
        self.odometry_topic = "/carla/ego_vehicle/odometry"
        self.drive: DriveEvaluation | None = None
        self._event_file = event_file
        self._last_wall_s: float | None = None
        self._early: deque = deque(maxlen=_MAX_EARLY_EVENTS)

    @property
    def started(self) -> bool:
        """Return whether both the route and an odometry have been received."""
        return self.drive is not None and bool(self.drive.progress.samples)

    @property
    def over(self) -> bool:
        """Return whether the drive has ended."""
        return self.drive is not None and self.drive.over

    @property
    def missing_topics(self) -> list:
        """Return the topics without which the drive cannot start."""
        missing = [] if self.drive else ["/planner/mission_waypoints"]
        return missing if self.started else [*missing, self.odometry_topic]

    @property
    def write_failure(self) -> OSError | None:
        """Return why the file of events cannot be written, or None."""
        return self._event_file.failure if self._event_file is not None else None

    def set_route(self, points_m: np.ndarray | Sequence) -> None:
        """Set the route.

        Args:
            points_m: (N, 2) waypoints of the mission [m]

        Raises:
            ValueError: the points are not a route
        """
        points = np.asarray(points_m, dtype=float).reshape(-1, 2)
        self.drive = DriveEvaluation(self.rules, road_route(points), self._event_file is None)
        if self._event_file is not None:
            self._event_file.append(["route", points.tolist(), self.rules._asdict()])
        early, self._early = self._early, deque()
        for event in early:
            self._take(event)

    def add_odometry(
        self,
        stamp_ns: int,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        wall_s: float | None = None,
    ) -> bool:
        """Add a pose and speed of the car.

        Args:
            stamp_ns: simulated time [ns]
            x_m: position in the map [m]
            y_m: position in the map [m]
            yaw_rad: heading, counter-clockwise from the x axis [rad]
            speed_mps: magnitude of the velocity [m/s]
            wall_s: wall clock at which the message arrived [s], None without a wall clock

        Returns:
            False for a message that is ignored, such as one with a repeated stamp
        """
        if not self.over:
            self._last_wall_s = wall_s
        used = self._take(["odometry", stamp_ns, x_m, y_m, yaw_rad, speed_mps])
        if wall_s is not None and self.drive is not None and self.drive.needs_wall_clock:
            self._take(["wall_clock", wall_s])
        return used

    def add_command(self, stamp_ns: int, throttle: float, brake: float, steer: float) -> None:
        """Add a command; it answers the odometry with its stamp, or else the last one received."""
        self._take(["command", stamp_ns, throttle, brake, steer])

    def add_planned_speed(self, speed_mps: float) -> None:
        """Add the planned speed at the car's position."""
        self._take(["planned", speed_mps])

    def add_reason(self, stamp_ns: int, name: str) -> None:
        """Add what limits the planned speed from the odometry with this stamp on."""
        self._take(["reason", stamp_ns, name])

    def is_scene_due(self, kind: str) -> bool:
        """Return whether the page of the report needs the present content of this kind."""
        drive = self.drive
        if drive is None or not drive.progress.samples:
            return False
        return drive.scene.is_due(kind, drive.progress.samples[-1].time_s)

    def add_scene(self, kind: str, content: Any, time_s: float | None = None) -> None:
        """Add what is around the car; see SceneRecord.

        Args:
            kind: path, obstacles or picture
            content: plain data, or the bytes of the picture
            time_s: simulated time [s]; None: that of the last odometry
        """
        if kind == PICTURE:
            content = _text(content)
        if self.drive is not None and self.drive.scene.is_new(kind, content):
            self._take(["scene", kind, time_s, content])

    def add_obstacle(self, obstacle_id: int, kind: str) -> None:
        """Add the kind of an obstacle, as the obstacles topic names it."""
        if self.drive is None or self.drive.is_new_kind(obstacle_id, kind):
            self._take(["obstacle", obstacle_id, kind])

    def set_stop_lines(self, lines: dict[int, StopLine]) -> None:
        """Set the stop lines of the traffic lights by light id."""
        self._take(["stop_lines", [[light_id, *line] for light_id, line in lines.items()]])

    def set_lights(self, stamp_ns: int, states: dict[int, int]) -> None:
        """Set the states of all traffic lights by light id; the stamp 0 means now."""
        if self.drive is None or self.drive.needs_lights(states):
            self._take(["lights", stamp_ns, list(states.items())])

    def add_collision(self, stamp_ns: int, obstacle_id: int) -> None:
        """Add a collision with an obstacle; the stamp 0 means now."""
        self._take(["collision", stamp_ns, obstacle_id])

    def add_snapshot(self, time_s: float, percent: float, jpeg: bytes) -> None:
        """Add a camera picture for the report.

        Args:
            time_s: simulated time [s]
            percent: completed share of the route [%]
            jpeg: the picture
        """
        self._take(["snapshot", time_s, percent, _text(jpeg)])

    def add_infraction(self, name: str) -> None:
        """Count an infraction.

        Args:
            name: a key of the report's infractions, such as red_light

        Raises:
            ValueError: the name is unknown
        """
        if name not in COEFFICIENTS:
            raise ValueError(f"unknown infraction '{name}'; write one of {', '.join(COEFFICIENTS)}")
        self._take(["infraction", name])

    def _take(self, event: list) -> bool:
        if self.drive is None:
            self._early.append(event)
            return True
        if self._event_file is not None:
            self._event_file.append(event)
        return self.drive.apply(event)

    def result(self) -> DriveResult:
        """Return the evaluated drive; the route must be set."""
        assert self.drive is not None
        if self._event_file is None:
            return self.drive.result(self._last_wall_s)
        return evaluate_events(self._event_file.events(), self._last_wall_s)


def _text(data: bytes) -> str:
    """Return bytes as text, for an event."""
    return base64.b64encode(data).decode()


def evaluate_events(events: Iterable[list], ended_at_s: float | None = None) -> DriveResult:
    """Return the evaluated drive, with its whole trace.

    Args:
        events: of a drive whose route is known
        ended_at_s: wall clock at the end of the drive [s], None if it is unknown

    Raises:
        ValueError: the events have no route
    """
    events = iter(events)
    head = next(events, None)
    if head is None:
        raise ValueError("the drive has no route")
    _, points_m, rules = head
    drive = DriveEvaluation(
        EvaluationRules(**rules), road_route(np.array(points_m)), keep_trace=True
    )
    for event in events:
        drive.apply(event)
    return drive.result(ended_at_s)
