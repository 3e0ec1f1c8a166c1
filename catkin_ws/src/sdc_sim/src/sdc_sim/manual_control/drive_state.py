"""The newest values of a drive, collected from messages for the window of the manual control."""

from __future__ import annotations

import threading
from typing import Any, Callable

from sdc_common.driving import Command
from sdc_common.ros.conversion import pose_and_speed, yaw_from_quaternion
from sdc_sim.manual_control import hud
from sdc_sim.ros.waypoint_messages import waypoint_rows


class DriveState:
    """The newest values of a drive, all in the map frame. Callbacks may run in any thread.

    Args:
        notice_s: time for which a notice is visible [s]
        clock: returns the current wall time [s]

    Attributes:
        stamp: stamp of the newest odometry; None if there is none
        pose: x, y [m], yaw [rad]; None if unknown
        path: rows of x, y [m], target speed [m/s]; None if unknown
        obstacles: rows of x, y [m], yaw [rad], length, width [m]; None if unknown
    """

    def __init__(self, notice_s: float, clock: Callable[[], float]):
        self.stamp: Any = None
        self.pose: tuple[float, float, float] | None = None
        self.path: list[tuple] | None = None
        self.obstacles: list[tuple] | None = None
        self._clock = clock
        self._lock = threading.Lock()
        self._notices = hud.Notices(notice_s)
        self._frame_rate = hud.FrameRate()
        self._readings: dict[str, Any] = {}
        self._obstacle_kinds: dict[int, str] = {}

    def on_odometry(self, odometry: Any) -> None:
        """Store pose and speed of a nav_msgs/Odometry.

        Raises:
            ValueError: a value is not finite; the previous values stay.
        """
        x, y, yaw, speed = pose_and_speed(odometry)
        with self._lock:
            self._frame_rate.count(self._clock())
            self.stamp, self.pose = odometry.header.stamp, (x, y, yaw)
            self._readings.update(
                time_s=self.stamp.to_sec(), x_m=x, y_m=y, yaw_rad=yaw, speed_mps=speed
            )

    def on_status(self, status: Any) -> None:
        """Store the active command of a CarlaEgoVehicleStatus."""
        with self._lock:
            self._readings.update(command=status.control)

    def on_obstacles(self, message: Any) -> None:
        """Store the obstacles of an ObstacleArray."""
        self._obstacle_kinds = {obstacle.id: obstacle.kind for obstacle in message.obstacles}
        self.obstacles = [
            (
                obstacle.pose.position.x,
                obstacle.pose.position.y,
                yaw_from_quaternion(obstacle.pose.orientation),
                obstacle.size.x,
                obstacle.size.y,
            )
            for obstacle in message.obstacles
        ]

    def on_path(self, path: Any) -> None:
        """Store a LocalPath.

        Raises:
            ValueError: the message has other fields; the previous path stays.
        """
        self.path = waypoint_rows(path, "x", "y", "v")

    def on_world_info(self, info: Any) -> None:
        """Store the map name of a CarlaWorldInfo."""
        with self._lock:
            self._readings.update(map_name=info.map_name)

    def on_collision(self, event: Any) -> None:
        """Show a notice for a CarlaCollisionEvent."""
        kind = self._obstacle_kinds.get(event.other_actor_id)
        self.notify(hud.collision_text(event.other_actor_id, kind))

    def on_lane_invasion(self, event: Any) -> None:
        """Show a notice for a CarlaLaneInvasionEvent."""
        self.notify(hud.crossed_line_text(event.crossed_lane_markings))

    def notify(self, text: str) -> None:
        """Show a notice."""
        with self._lock:
            self._notices.add(text, self._clock())

    def readings(self, command: Command, manual: bool, client_fps: float) -> hud.Readings:
        """Return the values of the head-up display.

        Args:
            command: command to show until the vehicle reports its active command
            manual: whether the person drives
            client_fps: frame rate of the window [1/s]
        """
        with self._lock:
            values: dict[str, Any] = {"command": command, **self._readings}
            server_fps = self._frame_rate.per_second(self._clock())
        return hud.Readings(manual=manual, client_fps=client_fps, server_fps=server_fps, **values)

    def notices(self) -> list[tuple[str, float]]:
        """Return rows of (text, opacity in 0..1)."""
        with self._lock:
            return self._notices.visible(self._clock())
