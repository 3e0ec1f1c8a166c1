"""The newest values of a drive, collected from messages for the window of the manual control."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Any

from sdc_common.ros.odometry import pose_and_speed
from sdc_common.validation import check_positive
from sdc_sim.manual_control import hud
from sdc_sim.ros.evaluator_input import obstacle_box
from sdc_sim.ros.waypoint_messages import waypoint_rows

_MAX_NOTICES = 4
# The frame rate is the mean of so many odometry messages.
_COUNTED = 40


class DriveState:
    """The newest values of a drive, all in the map frame. Callbacks may run in any thread.

    Args:
        notice_s: time for which a notice is visible [s]
        clock: returns the current wall time [s]

    Raises:
        ValueError: notice_s is not positive.
    """

    def __init__(self, notice_s: float, clock: Callable[[], float] = time.monotonic):
        check_positive(notice_s=notice_s)
        self.stamp: Any = None  # stamp of the newest odometry; None if there is none
        self.pose: tuple[float, float, float] | None = None  # x, y [m], yaw [rad]; None if unknown
        self.path: list[tuple] = []  # rows of x, y [m], target speed [m/s]
        self.obstacles: list[tuple] = []  # rows of x, y [m], yaw [rad], length, width [m]
        self.command: Any = None  # the active command of the vehicle; None if unknown
        self._clock, self._notice_s = clock, notice_s
        self._notices: dict[str, float] = {}
        self._received_s: deque[float] = deque(maxlen=_COUNTED)
        self._readings: dict[str, Any] = {}
        self._obstacle_kinds: dict[int, str] = {}

    def on_odometry(self, odometry: Any) -> None:
        """Store pose and speed of a nav_msgs/Odometry.

        Raises:
            ValueError: a value is not finite; the previous values stay.
        """
        x, y, yaw, speed = pose_and_speed(odometry)
        self._received_s.append(self._clock())
        self.stamp, self.pose = odometry.header.stamp, (x, y, yaw)
        self._readings.update(
            time=hud.clock(self.stamp.to_sec()),
            heading=hud.compass(yaw),
            x_m=x,
            y_m=y,
            speed_kmh=3.6 * speed,
        )

    def on_status(self, status: Any) -> None:
        """Store the active command of a CarlaEgoVehicleStatus."""
        self.command = status.control

    def on_obstacles(self, message: Any) -> None:
        """Store the obstacles of an ObstacleArray."""
        self._obstacle_kinds = {obstacle.id: obstacle.kind for obstacle in message.obstacles}
        self.obstacles = [obstacle_box(obstacle)[1:] for obstacle in message.obstacles]

    def on_path(self, path: Any) -> None:
        """Store a LocalPath.

        Raises:
            ValueError: the message has other fields; the previous path stays.
        """
        self.path = waypoint_rows(path, "x", "y", "v")

    def on_world_info(self, info: Any) -> None:
        """Store the map name of a CarlaWorldInfo."""
        self._readings.update(map_name=info.map_name)

    def on_collision(self, event: Any) -> None:
        """Show a notice for a CarlaCollisionEvent."""
        number = event.other_actor_id
        self.notify(f"Collision with {self._obstacle_kinds.get(number) or f'actor {number}'}")

    def on_lane_invasion(self, event: Any) -> None:
        """Show a notice for a CarlaLaneInvasionEvent."""
        self.notify(hud.crossed_line_text(event.crossed_lane_markings))

    def readings(self, is_manual: bool, client_fps: float) -> dict[str, Any]:
        """Return the readings of the head-up display by name, without those that are unknown."""
        received_s = list(self._received_s)
        over_s = self._clock() - received_s[0] if received_s else 0.0
        return {
            "driver": "manual" if is_manual else "autopilot",
            "client_fps": client_fps,
            "server_fps": (len(received_s) - 1) / over_s if over_s > 0.0 else 0.0,
            **self._readings,
        }

    def notify(self, text: str) -> None:
        """Show a notice. A repeated one starts again; only the newest ones stay."""
        self._notices.pop(text, None)
        self._notices[text] = self._clock()
        for old in list(self._notices)[:-_MAX_NOTICES]:
            self._notices.pop(old, None)

    def notices(self) -> list[tuple[str, float]]:
        """Return rows of (text, opacity in 0..1), the oldest first.

        A notice is opaque for the first half of its time, then fades out.
        """
        left = [
            (text, 1.0 - (self._clock() - since_s) / self._notice_s)
            for text, since_s in list(self._notices.items())
        ]
        return [(text, min(1.0, 2.0 * share)) for text, share in left if share > 0.0]
