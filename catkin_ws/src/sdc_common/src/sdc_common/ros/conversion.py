"""Conversion of what the car and the world receive and send to and from messages, validated.

The class of a message is an argument where a student writes its definition.
"""

from __future__ import annotations

import math
from typing import Any, Sequence

import rospy
from carla_msgs.msg import CarlaTrafficLightInfoList
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from sdc_msgs.msg import ObstacleArray
from sensor_msgs.msg import Image

from sdc_common.driving import Command, DetectedObstacle, Observation
from sdc_common.planning.stop_line import StopLine

# Where a simulator with `truth: false` publishes what it otherwise publishes as odometry.
GROUND_TRUTH = "/sim/ground_truth/odometry"
# The wheels of a JointState that do not steer.
REAR_WHEELS = ("rear_left_wheel", "rear_right_wheel")


def yaw_from_quaternion(q: Quaternion) -> float:
    """Return the yaw of a unit quaternion, counter-clockwise from the x axis [rad].

    Reference: J. Diebel, Representing Attitude: Euler Angles, Unit Quaternions, and Rotation
    Vectors, 2006, equation 290.
    """
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def pose_and_speed(odometry: Odometry) -> tuple[float, float, float, float]:
    """Return x [m], y [m], yaw [rad] and speed [m/s] of an odometry message.

    The speed is the magnitude of the twist, which is the same in every frame.

    Raises:
        ValueError: a number is not finite, or the orientation is not a unit quaternion
    """
    position = odometry.pose.pose.position
    q = odometry.pose.pose.orientation
    velocity = odometry.twist.twist.linear
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise ValueError("its orientation is not a unit quaternion")
    speed = math.hypot(velocity.x, velocity.y)
    numbers = (position.x, position.y, yaw_from_quaternion(q), speed)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("one of its numbers is not finite")
    return numbers


def true_odometry_topic(ego: str) -> str:
    """Return the topic with the true odometry of the vehicle.

    Args:
        ego: prefix of the topics of the vehicle, such as /carla/ego_vehicle
    """
    return ego + "/odometry" if rospy.get_param("/sim/truth", True) else GROUND_TRUTH


def odometry_message(
    stamp: Any,
    pose: tuple[float, float, float],
    twist: tuple[float, float, float],
    vehicle_frame: str = "ego_vehicle",
) -> Odometry:
    """Return the odometry of a vehicle in the map.

    Args:
        stamp: stamp of the message (rospy.Time)
        pose: x [m], y [m], yaw [rad]
        twist: speed forward and to the left [m/s], yaw rate [rad/s]
        vehicle_frame: frame of the vehicle
    """
    message = Odometry(child_frame_id=vehicle_frame)
    message.header.stamp, message.header.frame_id = stamp, "map"
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, yaw = pose
    orientation.z, orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, angular.z = twist
    return message


def vehicle_transform(odometry: Odometry) -> TransformStamped:
    """Return the transform from the map to the vehicle of an odometry message."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position, translation = odometry.pose.pose.position, message.transform.translation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    message.transform.rotation = odometry.pose.pose.orientation
    return message


def check_image(message: Image) -> None:
    """Check the size of an image before its pixels are read.

    Raises:
        ValueError: the image is empty, or its data are too short for its size
    """
    if not (
        0 < message.width <= message.step and 0 < message.height * message.step <= len(message.data)
    ):
        raise ValueError(
            f"{message.width} x {message.height} pixels in rows of {message.step} bytes "
            f"do not match {len(message.data)} bytes of data"
        )


def rear_axle_speed(
    names: Sequence[str], rates_radps: Sequence[float], wheel_radius_m: float
) -> float:
    """Return the speed of the rear axle, the mean of its wheels [m/s].

    Args:
        names: names of the wheels
        rates_radps: angular velocity of each wheel
        wheel_radius_m: radius of the wheels

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


def detected_obstacles(array: ObstacleArray) -> list[DetectedObstacle]:
    """Return the obstacles in a message.

    Raises:
        ValueError: a number is not finite
    """
    obstacles = []
    for one in array.obstacles:
        position, size = one.pose.position, one.size
        yaw = yaw_from_quaternion(one.pose.orientation)
        obstacles.append(DetectedObstacle(position.x, position.y, yaw, size.x, size.y, one.speed))
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
