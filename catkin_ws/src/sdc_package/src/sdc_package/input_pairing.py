"""Pair each odometry with the local path that answers it."""

from __future__ import annotations

import threading
from typing import Any, Callable, NamedTuple, Sequence

from sdc_common.geometry.angles import wrap_angle
from sdc_package.local_path import ReferencePath, Row
from sdc_package.odometry import pose_and_speed
from sdc_package.watchdog import PATH, InputWatchdog

# After a longer gap the controllers continue as after this one.
_MAX_STEP_S = 0.2


class Motion(NamedTuple):
    """Pose and motion of the car.

    Attributes:
        stamp: stamp of the odometry (rospy.Time)
        x_m: position in the map frame [m]
        y_m: position in the map frame [m]
        yaw_rad: heading, counter-clockwise from the x axis [rad]
        speed_mps: speed over the ground [m/s]
        yaw_rate_radps: change of the heading since the last answered odometry [rad/s]
        step_s: time since the last answered odometry, at most 0.2 [s]
    """

    stamp: Any
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    yaw_rate_radps: float
    step_s: float


class InputPairing:
    """Calls `answer(motion, path)` once for each odometry, when its path has arrived.

    The local planner publishes one path for each odometry. A path has no stamp, and the two arrive
    on separate connections in any order: each path belongs to the odometry that waits, or else to
    the next one. An odometry that arrives twice is ignored. A lock serializes the calls of several
    threads.

    While an input has timed out, `stop(missing, motion, path)` is called instead, with the name of
    the input, the last motion and the last path (None if there is none).
    """

    def __init__(
        self,
        answer: Callable[[Motion, ReferencePath], None],
        stop: Callable[[str, Motion | None, ReferencePath | None], None],
        watchdog: InputWatchdog,
        path_needed: bool = True,
    ):
        """Set the callbacks.

        Args:
            answer: called with each pair
            stop: called while an input is missing
            watchdog: measures the age of the inputs
            path_needed: whether an odometry waits for its path
        """
        self._answer = answer
        self._stop = stop
        self._watchdog = watchdog
        self._path_needed = path_needed
        self._lock = threading.Lock()
        self._path = ReferencePath()
        self._motion: Motion | None = None
        self._last_answered: Motion | None = None
        self._odometry_waits = False
        self._path_waits = False

    def add_odometry(self, odometry: Any) -> None:
        """Add a nav_msgs/Odometry.

        Raises:
            ValueError: the message is invalid, see `pose_and_speed`; it is ignored
        """
        with self._lock:
            stamp = odometry.header.stamp
            if self._motion is not None and stamp == self._motion.stamp:
                return
            motion = self._motion = self._motion_of(odometry)
            self._watchdog.odometry_received(stamp.to_nsec())
            self._odometry_waits = True
            if self._path_waits or not self._path_needed:
                self._answer_pair(motion)
            elif self._watchdog.path_timed_out:
                self._stop(PATH, motion, self._known_path)

    def add_path(self, rows: Sequence[Row]) -> None:
        """Add the (x, y, v) points of a path [m, m, m/s].

        Raises:
            ValueError: the path is invalid, see `ReferencePath.update`; it is ignored
        """
        with self._lock:
            self._path.update(rows)
            self._path_waits = True
            if self._odometry_waits and self._motion is not None:
                self._answer_pair(self._motion)

    def check(self, now: Any) -> None:
        """Stop the car if an input has timed out at this time (rospy.Time)."""
        with self._lock:
            missing = self._watchdog.timed_out(now.to_nsec(), self._path_needed)
            if missing is not None:
                self._stop(missing, self._motion, self._known_path)

    @property
    def _known_path(self) -> ReferencePath | None:
        return None if self._path.empty else self._path

    def _answer_pair(self, motion: Motion) -> None:
        self._odometry_waits = self._path_waits = False
        self._watchdog.path_received()
        self._last_answered = motion
        self._answer(motion, self._path)

    def _motion_of(self, odometry: Any) -> Motion:
        x, y, yaw, speed = pose_and_speed(odometry)
        stamp = odometry.header.stamp
        last = self._last_answered
        step_s = min(max(stamp.to_sec() - last.stamp.to_sec(), 0.0), _MAX_STEP_S) if last else 0.0
        yaw_rate = wrap_angle(yaw - last.yaw_rad) / step_s if last and step_s > 0.0 else 0.0
        return Motion(stamp, x, y, yaw, speed, yaw_rate, step_s)
