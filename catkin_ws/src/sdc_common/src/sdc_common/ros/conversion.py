"""Conversion of what the car receives and sends, besides odometry, to and from messages.

The class of a message is an argument where a student writes its definition.
"""

from __future__ import annotations

import math
from typing import Any, Sequence

import rospy
from carla_msgs.msg import CarlaTrafficLightInfoList
from sdc_msgs.msg import ObstacleArray
from sensor_msgs.msg import Image

from sdc_common.driving import Command, DetectedObstacle, Observation
from sdc_common.planning.stop_line import StopLine
from sdc_common.ros.odometry import yaw_from_quaternion

# The wheels of a JointState that do not steer.
REAR_WHEELS = ("rear_left_wheel", "rear_right_wheel")


def rear_axle_speed(
    names: Sequence[str], rates_radps: Sequence[float], wheel_radius_m: float
) -> float:
    """Return the speed of the rear axle, the mean of its wheels, from those of all wheels [m/s].

    Raises:
        ValueError: a rear wheel is missing, or its speed is not finite
    """
    rates = dict(zip(names, rates_radps))
    if not set(REAR_WHEELS) <= set(rates):
        raise ValueError(f"the wheels {' and '.join(REAR_WHEELS)} are missing in {list(names)}")
    speed = wheel_radius_m * sum(rates[name] for name in REAR_WHEELS) / len(REAR_WHEELS)
    if not math.isfinite(speed):
        raise ValueError("a wheel speed is not finite")
    return speed


def check_image(message: Image) -> None:
    """Check the size and the byte order of an image before its pixels are read.

    Raises:
        ValueError: the image is empty, its data are too short for its size, or it is big-endian,
            which cv_bridge cannot read with NumPy 2
    """
    if message.is_bigendian:
        raise ValueError("the picture is big-endian; publish it with is_bigendian false")
    if not (
        0 < message.width <= message.step and 0 < message.height * message.step <= len(message.data)
    ):
        raise ValueError(
            f"{message.width} x {message.height} pixels in rows of {message.step} bytes "
            f"do not match {len(message.data)} bytes of data"
        )


def detected_obstacles(array: ObstacleArray) -> list[DetectedObstacle]:
    """Return the obstacles in a message.

    Raises:
        ValueError: a number is not finite
    """
    obstacles = []
    for body in array.obstacles:
        position, size = body.pose.position, body.size
        yaw = yaw_from_quaternion(body.pose.orientation)
        box = position.x, position.y, yaw, size.x, size.y
        obstacles.append(DetectedObstacle(*box, body.speed, body.id, body.kind, position.z))
    return obstacles


def stop_lines(info: CarlaTrafficLightInfoList) -> dict[int, StopLine]:
    """Return the stop line of each traffic light, by the light's id.

    The line crosses the middle of the light's trigger volume.

    Raises:
        ValueError: a number is not finite
    """
    lines = {}
    for light in info.traffic_lights:
        yaw = yaw_from_quaternion(light.transform.orientation)
        c, s = math.cos(yaw), math.sin(yaw)
        centre, size = light.trigger_volume.center, light.trigger_volume.size
        line = StopLine(
            light.transform.position.x + c * centre.x - s * centre.y,
            light.transform.position.y + s * centre.x + c * centre.y,
            0.5 * max(abs(size.x), abs(size.y)),
            light.transform.position.z + centre.z,
        )
        if not all(map(math.isfinite, line)):
            raise ValueError(f"a number of traffic light {light.id} is not finite")
        lines[light.id] = line
    return lines


def stamp_of(content: Observation | Command) -> rospy.Time:
    """Return the stamp of an observation or a command as a message has it."""
    return rospy.Time(*divmod(content.stamp_ns, 1_000_000_000))


def command_message(command: Command, message_class: Any) -> Any:
    """Return a command as a message of this class, CarlaVehicleControl of a package."""
    message = message_class(
        throttle=command.throttle,
        steer=command.steer,
        brake=command.brake,
        hand_brake=command.hand_brake,
        reverse=command.reverse,
    )
    message.header.stamp = stamp_of(command)
    return message
