"""Evaluation of a drive from its messages, as plain numbers."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from sdc_common.geometry.road_line import road_route
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.evaluation.event_file import EventFile
from sdc_sim.evaluation.rules import EvaluationRules

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
        if self.started or any(name == "odometry" for name, *_ in self._early):
            return missing
        return [*missing, self.odometry_topic]

    def set_route(self, points_m: np.ndarray | Sequence) -> None:
        """Set the route (N, 2) [m]; a later one continues the drive if the rules allow it.

        Raises:
            ValueError: the points are not a route
        """
        points = np.asarray(points_m, dtype=float).reshape(-1, 2)
        if self.drive is not None:
            if self.rules.new_missions:
                self.add("mission", points.tolist())
            return
        self.drive = DriveEvaluation(self.rules, road_route(points), self._event_file is None)
        if self._event_file is not None:
            self._event_file.append(["route", points.tolist(), self.rules._asdict()])
        early, self._early = self._early, deque()
        for event in early:
            self.add(*event)

    def add(self, name: str, *arguments: Any) -> bool:
        """Add an event of a drive.

        Args:
            name: of a method `_on_NAME` of DriveEvaluation
            arguments: of this method, as plain data

        Returns:
            False for an odometry that is ignored, such as one with a repeated stamp
        """
        event = [name, *arguments]
        if self.drive is None:
            self._early.append(event)
            return True
        if not self.drive.changes(event):
            return True
        if self._event_file is not None:
            self._event_file.append(event)
        return self.drive.apply(event)

    def result(self) -> DriveEvaluation:
        """Return the drive with its whole trace; the route must be set."""
        assert self.drive is not None
        if self._event_file is None:
            return self.drive
        return evaluate_events(self._event_file.events())


def evaluate_events(events: Iterable[list]) -> DriveEvaluation:
    """Return the evaluated drive of these events, with its whole trace.

    Raises:
        ValueError: the events have no route
    """
    events = iter(events)
    head = next(events, None)
    if head is None:
        raise ValueError("the drive has no route")
    _, points_m, rules = head
    route = road_route(np.array(points_m))
    drive = DriveEvaluation(EvaluationRules(**rules), route, keep_trace=True)
    for event in events:
        drive.apply(event)
    return drive
