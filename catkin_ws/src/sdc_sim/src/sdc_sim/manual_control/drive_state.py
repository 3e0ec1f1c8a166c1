"""What a person at the wheel wants to know of the drive: gathered from messages, handed out as what the window shows."""

from __future__ import annotations

import threading

from sdc_common.ros.odometry import pose_and_speed, yaw_from_quaternion
from sdc_sim.manual_control import hud


class DriveState:
    """Takes messages from any thread. clock() tells the time in seconds by which frames are counted and notices fade.

    stamp is the stamp of the newest odometry. pose (x, y, yaw), path (N, 3) x, y, target speed, and obstacles (N, 5) x, y,
    yaw, length, width are in the map frame. Each is None until it is known.
    """

    def __init__(self, notice_s: float, clock):
        self.stamp = self.pose = self.path = self.obstacles = None
        self._clock = clock
        self._lock = threading.Lock()
        self._notices = hud.Notices(notice_s)
        self._frame_rate = hud.FrameRate()
        self._known = {}
        self._kinds = {}

    def on_odometry(self, odometry) -> None:
        """Take where the car is and how fast. Raises ValueError for numbers that are not finite; the last stay then."""
        x, y, yaw, speed = pose_and_speed(odometry)
        with self._lock:
            self._frame_rate.count(self._clock())
            self.stamp, self.pose = odometry.header.stamp, (x, y, yaw)
            self._known.update(
                time_s=self.stamp.to_sec(), x_m=x, y_m=y, yaw_rad=yaw, speed_mps=speed
            )

    def on_status(self, status) -> None:
        """Take the command that the car obeys."""
        with self._lock:
            self._known.update(command=status.control)

    def on_obstacles(self, message) -> None:
        """Take what stands on the road."""
        self._kinds = {obstacle.id: obstacle.kind for obstacle in message.obstacles}
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

    def on_path(self, path) -> None:
        """Take the local path."""
        self.path = [(point.x, point.y, point.v) for point in path.waypoints]

    def on_world_info(self, info) -> None:
        """Take the name of the map."""
        with self._lock:
            self._known.update(map_name=info.map_name)

    def on_collision(self, event) -> None:
        """Say what the car has run into."""
        self.say(hud.collision_text(event.other_actor_id, self._kinds.get(event.other_actor_id)))

    def on_lane_invasion(self, event) -> None:
        """Say which lines the car has crossed."""
        self.say(hud.crossed_line_text(event.crossed_lane_markings))

    def say(self, text: str) -> None:
        """Show a notice."""
        with self._lock:
            self._notices.say(text, self._clock())

    def readings(self, command, manual: bool, client_fps: float) -> hud.Readings:
        """All figures; `command` stands in until the car tells which one it obeys."""
        with self._lock:
            return hud.Readings(
                **{"command": command, **self._known},
                manual=manual,
                client_fps=client_fps,
                server_fps=self._frame_rate.per_second(self._clock()),
            )

    def notices(self):
        """Rows of (text, strength in 0..1)."""
        with self._lock:
            return self._notices.visible(self._clock())
