"""Pair each odometry with the local path that answers it."""

from __future__ import annotations

import threading
from typing import Any, Callable, Sequence

from sdc_common.driving import Observation
from sdc_common.validation import check_positive
from sdc_package.local_path import ReferencePath, Row
from sdc_package.odometry import pose_and_speed


class InputPairing:
    """Calls `answer(observation, path)` once for each odometry, when its path has arrived.

    The local planner publishes one path for each odometry. A path has no stamp, and the two arrive
    on separate connections in any order: each path belongs to the odometry that waits, or else to
    the next one. An odometry that arrives twice is ignored. A lock serializes the calls of several
    threads.

    While an input is older than the timeout, `stop(missing, observation, path)` is called instead,
    with the name of the input, the last observation (None if there is none) and the last path.
    Times are stamps in integer nanoseconds. The age of the path is measured from odometry to
    odometry: the clock arrives on a separate connection. Without `path_needed`, no odometry waits
    for its path.

    Raises:
        ValueError: the timeout is not positive
    """

    def __init__(
        self,
        answer: Callable[[Observation, ReferencePath], None],
        stop: Callable[[str, Observation | None, ReferencePath], None],
        timeout_s: float,
        path_needed: bool = True,
    ):
        self._answer, self._stop = answer, stop
        check_positive(patience_s=timeout_s)
        self._timeout_ns, self._path_needed = round(timeout_s * 1e9), path_needed
        self._odometry_ns = self._path_ns = 0  # of the last odometry, and of the last answered one
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
            self._odometry_ns, self._odometry_waits = stamp_ns, True
            if self._path_waits or not self._path_needed:
                self._answer_pair(self._observation)
            elif self._path_ns and self._path_is_old:
                self._stop("path", self._observation, self._path)

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
            if now_ns - self._odometry_ns > self._timeout_ns:
                self._stop("odometry", self._observation, self._path)
            elif self._path_needed and self._path_is_old:
                self._stop("path", self._observation, self._path)

    @property
    def _path_is_old(self) -> bool:
        return self._odometry_ns - self._path_ns > self._timeout_ns

    def _answer_pair(self, observation: Observation) -> None:
        self._odometry_waits = self._path_waits = False
        self._path_ns = self._odometry_ns
        self._answer(observation, self._path)
