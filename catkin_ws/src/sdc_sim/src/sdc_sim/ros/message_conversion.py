"""Conversion between the simulation's data and ROS messages."""

from __future__ import annotations

import math
from typing import Any, Iterable

import rospy
from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import (
    CarlaBoundingBox,
    CarlaTrafficLightInfo,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatus,
    CarlaTrafficLightStatusList,
)
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from sdc_msgs.msg import Obstacle, ObstacleArray
from std_msgs.msg import Header

from sdc_common.ros.odometry import yaw_from_quaternion
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import LANE_WIDTH_M, TrafficLightPlan, TrafficLightState
from sdc_sim.physics.vehicle import VehicleCommand, VehicleState

MAP_FRAME = "map"
VEHICLE_FRAME = "ego_vehicle"

# Points of RViz that are farther from the origin are refused.
_MAX_DISTANCE_M = 1e5
# Length along the lane and height of a traffic light's trigger volume.
_LINE_DEPTH_M = 1.0
_LINE_HEIGHT_M = 2.0


def map_vector(yaw_rad: float, forward: float, left: float) -> Vector3:
    """Return a vector of the body frame in the map frame."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return Vector3(c * forward - s * left, s * forward + c * left, 0.0)


def quaternion_from_yaw(yaw_rad: float) -> Quaternion:
    """Return the orientation of a body with this heading, counter-clockwise from the x axis."""
    return Quaternion(0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad))


class PlaceError(ValueError):
    """A point or pose that is refused; the message gives the reason."""


def map_point(frame_id: str, point: Point) -> tuple[float, float]:
    """Return (x, y) [m] of a point in the map.

    Raises:
        PlaceError: the frame is not the map, or a value is not finite or too large
    """
    if frame_id.lstrip("/") not in (MAP_FRAME, ""):
        raise PlaceError(f"it is in the frame '{frame_id}'; set RViz's Fixed Frame to map")
    if not (math.isfinite(point.x) and math.isfinite(point.y)):
        raise PlaceError(f"({point.x}, {point.y}) is not finite")
    if max(abs(point.x), abs(point.y)) > _MAX_DISTANCE_M:
        raise PlaceError(
            f"({point.x:g}, {point.y:g}) is farther than {_MAX_DISTANCE_M:g} m from the origin"
        )
    return point.x, point.y


def map_pose(frame_id: str, pose: Pose) -> tuple[float, float, float]:
    """Return (x [m], y [m], yaw [rad]) of a pose in the map.

    Raises:
        PlaceError: as map_point, or the orientation is not a unit quaternion
    """
    x, y = map_point(frame_id, pose.position)
    q = pose.orientation
    if not 0.9 < q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w < 1.1:
        raise PlaceError("its orientation is not a unit quaternion")
    return x, y, yaw_from_quaternion(q)


def vehicle_command(message: Any) -> VehicleCommand:
    """Return the command in a CarlaVehicleControl or CarlaEgoVehicleControl."""
    return VehicleCommand(
        message.throttle, message.steer, message.brake, message.hand_brake, message.reverse
    )


def ackermann_target(message: AckermannDrive) -> AckermannTarget:
    """Return the target in an AckermannDrive."""
    return AckermannTarget(
        message.steering_angle,
        message.steering_angle_velocity,
        message.speed,
        message.acceleration,
        message.jerk,
    )


def odometry_message(
    state: VehicleState, stamp: rospy.Time, vehicle_frame: str = VEHICLE_FRAME
) -> Odometry:
    """Return the pose of the vehicle in the map and its twist in the body frame."""
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id = MAP_FRAME
    message.child_frame_id = vehicle_frame
    pose = message.pose.pose
    pose.position.x = state.x_m
    pose.position.y = state.y_m
    pose.orientation = quaternion_from_yaw(state.yaw_rad)
    twist = message.twist.twist
    twist.linear.x = state.speed_mps
    twist.linear.y = state.lateral_speed_mps
    twist.angular.z = state.yaw_rate_radps
    return message


def vehicle_transform(odometry: Odometry) -> TransformStamped:
    """Return the transform map -> vehicle of an odometry message."""
    transform = TransformStamped()
    transform.header = odometry.header
    transform.child_frame_id = odometry.child_frame_id
    transform.transform.translation.x = odometry.pose.pose.position.x
    transform.transform.translation.y = odometry.pose.pose.position.y
    transform.transform.rotation = odometry.pose.pose.orientation
    return transform


def obstacles_message(
    obstacles: Iterable[ObstacleState], lights: Iterable[TrafficLightState], stamp: rospy.Time
) -> ObstacleArray:
    """Return the true states of obstacles and traffic lights."""
    return ObstacleArray(
        Header(stamp=stamp, frame_id=MAP_FRAME),
        [
            Obstacle(
                one.id,
                one.kind,
                Pose(Point(one.x_m, one.y_m, 0.0), quaternion_from_yaw(one.yaw_rad)),
                Vector3(one.length_m, one.width_m, one.height_m),
                one.speed_mps,
            )
            for one in obstacles
        ],
        [CarlaTrafficLightStatus(light.id, light.state) for light in lights],
    )


def light_status_message(lights: Iterable[TrafficLightState]) -> CarlaTrafficLightStatusList:
    """Return the colours of all traffic lights."""
    return CarlaTrafficLightStatusList(
        [CarlaTrafficLightStatus(light.id, light.state) for light in lights]
    )


def light_info_message(
    plans: Iterable[TrafficLightPlan], lights: Iterable[TrafficLightState]
) -> CarlaTrafficLightInfoList:
    """Return the positions of the traffic lights.

    The centre of a trigger volume is the middle of the stop line; its width is a lane.
    """
    infos = []
    for plan, light in zip(plans, lights):
        yaw = light.heading_rad + math.pi
        c, s = math.cos(yaw), math.sin(yaw)
        east, north = plan.x_m - light.x_m, plan.y_m - light.y_m
        centre = Vector3(c * east + s * north, c * north - s * east, 0.0)
        infos.append(
            CarlaTrafficLightInfo(
                light.id,
                Pose(Point(light.x_m, light.y_m, 0.0), quaternion_from_yaw(yaw)),
                CarlaBoundingBox(centre, Vector3(_LINE_DEPTH_M, LANE_WIDTH_M, _LINE_HEIGHT_M)),
            )
        )
    return CarlaTrafficLightInfoList(infos)
