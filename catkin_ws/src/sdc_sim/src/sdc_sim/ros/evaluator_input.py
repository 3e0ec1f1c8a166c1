"""Conversion of ROS messages to the evaluator's input: for topics, and for a bag."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleControl,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
)
from nav_msgs.msg import Odometry
from rospy import AnyMsg
from sdc_msgs.msg import CarlaVehicleControl, LaneOffset, Obstacle, ObstacleArray, SpeedReason

from sdc_common.ros.conversion import stop_lines
from sdc_common.ros.odometry import pose_and_speed, yaw_from_quaternion
from sdc_common.ros.speed_reason_publisher import DETAIL_TOPIC
from sdc_common.ros.speed_reason_publisher import TOPIC as REASON_TOPIC
from sdc_sim.evaluation.drive_evaluation import OBSTACLES, PATH
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.ros.waypoint_messages import waypoint_rows

ROUTE_TOPIC = "/planner/mission_waypoints"
PATH_TOPIC = "/planner/local_waypoints"
# The control commands of the versions of the bridge by their md5 sums.
_CONTROLS = {command._md5sum: command for command in (CarlaVehicleControl, CarlaEgoVehicleControl)}
# Of a path with more points, the page of the report shows only some.
_SHOWN_POINTS = 12
_CONTROL_NAMES = " or ".join(command._type for command in _CONTROLS.values())


class EvaluatorInput:
    """One method for each topic that the evaluator needs.

    A method raises ValueError for a message with values that cannot be evaluated.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        wall_clock: Callable[[], float] | None = None,
        role_name: str = "ego_vehicle",
        odometry_topic: str | None = None,
    ):
        """Create the input of an evaluator.

        Args:
            evaluator: receives the content of the messages
            wall_clock: returns the wall clock [s]; None: messages come from a bag
            role_name: name of the vehicle in its topics
            odometry_topic: topic of the true odometry; None: that of the vehicle
        """
        ego = "/carla/" + role_name
        self.evaluator = evaluator
        evaluator.odometry_topic = odometry_topic or ego + "/odometry"
        self._wall_clock = wall_clock
        self._has_commands = False

        def stamped(event: str, field: str) -> Callable[[Any], bool]:
            """Return the method that adds a field of a message with a header as this event."""
            return lambda message: evaluator.add(
                event, message.header.stamp.to_nsec(), getattr(message, field)
            )

        # Odometry is last: a sim in lockstep starts when the referee subscribes to it, and by then
        # the referee must be subscribed to all other topics.
        self.topics = {
            ROUTE_TOPIC: (AnyMsg, self.route),
            PATH_TOPIC: (AnyMsg, self.local_path),
            REASON_TOPIC: (SpeedReason, stamped("reason", "reason")),
            DETAIL_TOPIC: (SpeedReason, stamped("detail", "reason")),
            "/camera/lane_offset": (LaneOffset, stamped("lane_offset", "offset_m")),
            ego + "/vehicle_control_cmd": (AnyMsg, self.command),
            ego + "/ackermann_cmd": (AckermannDrive, self.target),
            ego + "/collision": (CarlaCollisionEvent, stamped("collision", "other_actor_id")),
            ego + "/obstacles": (ObstacleArray, self.obstacles),
            "/carla/traffic_lights/info": (CarlaTrafficLightInfoList, self.light_info),
            "/carla/traffic_lights/status": (CarlaTrafficLightStatusList, self._add_lights),
            # The names of the bridges 0.9.8 to 0.9.10.
            "/carla/traffic_lights_info": (CarlaTrafficLightInfoList, self.light_info),
            "/carla/traffic_lights": (CarlaTrafficLightStatusList, self._add_lights),
            evaluator.odometry_topic: (Odometry, self.odometry),
        }

    def route(self, path: Any) -> None:
        """Set the route, see `Evaluator.set_route`."""
        self.evaluator.set_route(waypoint_rows(path, "x", "y"))

    def odometry(self, odometry: Odometry) -> bool:
        """Add an odometry; return False if it is ignored."""
        stamp_ns, values = odometry.header.stamp.to_nsec(), pose_and_speed(odometry)
        wall_s = self._wall_clock() if self._wall_clock else None
        z_m = odometry.pose.pose.position.z
        return self.evaluator.add("odometry", stamp_ns, *values, wall_s, z_m)

    def command(self, message: Any) -> None:
        """Add a command of any version of the bridge."""
        self._has_commands = True
        command = control_command(message)
        values = command.throttle, command.brake, command.steer
        self.evaluator.add("command", command.header.stamp.to_nsec(), *values)

    def target(self, message: AckermannDrive) -> None:
        """Add a command of unknown pedals, unless a node turns the targets into commands."""
        if not self._has_commands:
            self.evaluator.add("target")

    def local_path(self, path: Any) -> None:
        """Add the planned speed: that of the first point, which is the first not behind the car."""
        rows = waypoint_rows(path, "x", "y", "v")
        for _, _, speed_mps in rows[:1]:
            if math.isfinite(speed_mps):
                self.evaluator.add("planned", speed_mps)
        if self._is_scene_due(PATH):
            shown = [*rows[: -1 : max(1, len(rows) // _SHOWN_POINTS)], *rows[-1:]]
            finite = [row for row in shown if all(map(math.isfinite, row))]
            self.evaluator.add("scene", PATH, None, finite)

    def obstacles(self, array: ObstacleArray) -> None:
        """Add the kinds of the obstacles, and the states of the traffic lights if there are any."""
        for obstacle in array.obstacles:
            self.evaluator.add("obstacle", obstacle.id, obstacle.kind)
        if self._is_scene_due(OBSTACLES):
            boxes = map(obstacle_box, array.obstacles)
            shown = [box for box in boxes if all(map(math.isfinite, box))]
            self.evaluator.add("scene", OBSTACLES, array.header.stamp.to_sec(), shown)
        if self.evaluator.rules.map:
            rows = [
                (*obstacle_box(obstacle), obstacle.pose.position.z, obstacle.speed, obstacle.kind)
                for obstacle in array.obstacles
            ]
            self.evaluator.add("others", array.header.stamp.to_nsec(), rows)
        if array.traffic_lights:
            self._add_lights(array, array.header.stamp.to_nsec())

    def light_info(self, info: CarlaTrafficLightInfoList) -> None:
        """Set the stop lines."""
        lines = [(light_id, *line) for light_id, line in stop_lines(info).items()]
        self.evaluator.add("stop_lines", lines)

    def _add_lights(self, message: Any, stamp_ns: int = 0) -> None:
        """Set the states of the traffic lights; the message of the bridge has no stamp."""
        states = [(light.id, light.state) for light in message.traffic_lights]
        self.evaluator.add("lights", stamp_ns, states)

    def _is_scene_due(self, kind: str) -> bool:
        return self.evaluator.drive is not None and self.evaluator.drive.is_scene_due(kind)


def obstacle_box(obstacle: Obstacle) -> tuple[float, ...]:
    """Return id, x, y [m], yaw [rad], length and width [m] of an obstacle."""
    pose, size = obstacle.pose, obstacle.size
    yaw_rad = yaw_from_quaternion(pose.orientation)
    return obstacle.id, pose.position.x, pose.position.y, yaw_rad, size.x, size.y


def control_command(message: Any) -> Any:
    """Return a control command as the message class of its publisher.

    Raises:
        ValueError: the publisher's type is no control command
    """
    if not isinstance(message, AnyMsg):
        return message
    header = message._connection_header
    message_class = _CONTROLS.get(header["md5sum"])
    if message_class is None:
        raise ValueError(f"its type is {header['type']}; publish {_CONTROL_NAMES}")
    return message_class().deserialize(message._buff)
