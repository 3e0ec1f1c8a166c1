"""Pair each odometry with the local path that answers it."""

from __future__ import annotations

import threading
from typing import Any, Callable, Sequence

from sdc_common.driving import Observation
from sdc_package.local_path import ReferencePath, Row
from sdc_package.odometry import pose_and_speed
from sdc_package.watchdog import PATH, InputWatchdog


class InputPairing:
    """Calls `answer(observation, path)` once for each odometry, when its path has arrived.

    The local planner publishes one path for each odometry. A path has no stamp, and the two arrive
    on separate connections in any order: each path belongs to the odometry that waits, or else to
    the next one. An odometry that arrives twice is ignored. A lock serializes the calls of several
    threads.

    While an input has timed out, `stop(missing, observation, path)` is called instead, with the
    name of the input, the last observation (None if there is none) and the last path. The watchdog
    measures the age of the inputs. Without `path_needed`, no odometry waits for its path.
    """

    def __init__(
        self,
        answer: Callable[[Observation, ReferencePath], None],
        stop: Callable[[str, Observation | None, ReferencePath], None],
        watchdog: InputWatchdog,
        path_needed: bool = True,
    ):
        self._answer, self._stop = answer, stop
        self._watchdog, self._path_needed = watchdog, path_needed
        self._lock = threading.Lock()
        self._path = ReferencePath()
        self._observation: Observation | None = None
        self._odometry_waits = self._path_waits = False

    def add_odometry(self, odometry: Any) -> None:
        """Add a nav_msgs/Odometry.

        Raises:
            ValueError: the message is invalid, see `pose_and_speed`; it is ignored
        """
        with self._lock:
            stamp_ns = odometry.header.stamp.to_nsec()
            if self._observation is not None and stamp_ns == self._observation.stamp_ns:
                return
            self._observation = Observation(stamp_ns, *pose_and_speed(odometry))
            self._watchdog.odometry_received(stamp_ns)
            self._odometry_waits = True
            if self._path_waits or not self._path_needed:
                self._answer_pair(self._observation)
            elif self._watchdog.path_timed_out:
                self._stop(PATH, self._observation, self._path)

    def add_path(self, rows: Sequence[Row]) -> None:
        """Add the (x, y, v) points of a path [m, m, m/s].

        Raises:
            ValueError: the path is invalid, see `ReferencePath.update`; it is ignored
        """
        with self._lock:
            self._path.update(rows)
            self._path_waits = True
            if self._odometry_waits and self._observation is not None:
                self._answer_pair(self._observation)

    def check(self, now_ns: int) -> None:
        """Stop the car if an input has timed out at this time [ns]."""
        with self._lock:
            missing = self._watchdog.timed_out(now_ns, self._path_needed)
            if missing is not None:
                self._stop(missing, self._observation, self._path)

    def _answer_pair(self, observation: Observation) -> None:
        self._odometry_waits = self._path_waits = False
        self._watchdog.path_received()
        self._answer(observation, self._path)
