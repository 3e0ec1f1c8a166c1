"""Scenes for the controller: poses and paths, and the commands that the solution gives for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

from sdc_workshop.exam.controller_subject import COMMANDS, ODOMETRY, is_stop
from sdc_workshop.exam.local_planner_subject import PATH, odometry_at
from sdc_workshop.exam.node import Node


@dataclass(frozen=True)
class Scene:
    """A pose and a speed of the car, and a straight path along the line y = x / 2 + 1.

    Attributes:
        text: description
        x: position [m]
        y: position [m]
        yaw: heading [rad]
        speed: speed [m/s]
        planned: returns the target speed of point i [m/s]
    """

    text: str
    x: float
    y: float
    yaw: float
    speed: float
    planned: Callable[[int], float]

    def rows(self) -> list:
        """Return the rows x, y, v of the path."""
        return [(0.9 * i, 0.45 * i + 1.0, self.planned(i)) for i in range(25)]


def _speeding_up(i: int) -> float:
    return (25.0 + 2.0 * 1.5 * (i - 4.6) * 1.006) ** 0.5 if i > 4.6 else 5.0


SCENES = (
    Scene("A car left of its path, too slow", 4.0, 3.6, 0.4636, 1.0, lambda i: 6.0),
    Scene(
        "A car right of its path that points to the left, too fast",
        4.0,
        2.5,
        0.6636,
        12.0,
        lambda i: 6.0,
    ),
    Scene("A car at its target speed, while the plan speeds up", 4.0, 3.1, 0.35, 5.0, _speeding_up),
)


class Drive:
    """Sends scenes to a controller, tick by tick, until its command is right.

    Attributes:
        answer: the last command, or None without one
    """

    STEP_S = 0.2
    # The jerk limit allows so small a change of the acceleration that it takes these ticks.
    TICKS = 14
    _TOLERANCES = {"throttle": 0.03, "steer": 0.002, "brake": 0.03}

    def __init__(self, node: Node, parameters: dict):
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl, LocalPath

        self.answer: Any = None
        self._node = node
        self._parameters = parameters
        self._received = node.subscriber(COMMANDS, CarlaVehicleControl)
        self._odometry = node.publisher(ODOMETRY, Odometry)
        self._path = node.publisher(PATH, LocalPath)
        self._tick: Any = None

    def play(self, scene: Scene) -> str:
        """Send a scene; return "true" when the command is right, "false" when not.

        Without a command, the result is that of Program.wait_until.
        """
        import rospy
        from sdc_package.msg import LocalPath, Waypoint

        if self._tick is None:
            self._tick = rospy.Time.now()
        wanted = self.wanted(scene)
        path = LocalPath([Waypoint(*row) for row in scene.rows()])
        for _ in range(self.TICKS):
            self._tick += rospy.Duration(self.STEP_S)
            stamp, before = self._tick, len(self._received.messages)
            odometry = odometry_at(scene.x, scene.y, scene.yaw, scene.speed, stamp)

            def send(odometry: Any = odometry) -> None:
                self._odometry.publish(odometry)
                self._path.publish(path)

            def answers(stamp: rospy.Time = stamp, before: int = before) -> list:
                return [
                    command
                    for command in self._received.messages[before:]
                    if command.header.stamp == stamp and not is_stop(command)
                ]

            how = self._node.send_until(send, answers)
            if how != "true":
                self.answer = None
                return how
            self.answer = answers()[0]
            if all(
                abs(getattr(self.answer, name) - value) < self._TOLERANCES[name]
                for name, value in wanted.items()
            ):
                return "true"
        return "false"

    def wanted(self, scene: Scene) -> dict:
        """Return the command that the solution gives after all ticks of a scene."""
        from sdc_package.actuation import PedalMap, SteeringMap
        from sdc_package.local_path import ReferencePath
        from sdc_package.pid import PidGains
        from sdc_package.speed_control import SpeedControl, SpeedControlLimits
        from sdc_package.steering.axles import Axles
        from sdc_package.steering.loader import load_steering

        parameters = self._parameters
        path = ReferencePath()
        path.update(scene.rows())
        limits = SpeedControlLimits(**parameters["limits"])
        control = SpeedControl(PidGains(**parameters["pid"]), limits)
        target = path.nearest(scene.x, scene.y, control.preview_m(scene.speed))
        for _ in range(self.TICKS):
            acceleration = control.acceleration(
                target.speed_mps, target.acceleration_mps2, scene.speed, self.STEP_S
            )
        steering = load_steering("stanley", parameters["stanley"], Axles(**parameters["axles"]))
        angle = steering.wheel_angle(path, scene.x, scene.y, scene.yaw, scene.speed, 0.0)
        throttle, brake = PedalMap(**parameters["pedals"]).pedals(acceleration)
        steer, _ = SteeringMap(**parameters["steering"]).command(angle, scene.speed)
        return {"throttle": throttle, "steer": steer, "brake": brake}
