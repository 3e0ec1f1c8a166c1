"""Conversion between the simulation's data and ROS messages."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
import rospy
from ackermann_msgs.msg import AckermannDrive
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import (
    Imu,
    JointState,
    LaserScan,
    NavSatFix,
    NavSatStatus,
    PointCloud2,
    PointField,
)
from std_msgs.msg import Header

from sdc_common.driving import Command, quaternion
from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.ros import odometry
from sdc_common.ros.odometry import unit, yaw_from_quaternion
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.model import (
    PLANAR_BEAMS,
    PLANAR_STEP_RAD,
    WHEELS,
    GnssReading,
    ImuReading,
    SensorSettings,
)

MAP_FRAME = "map"
VEHICLE_FRAME = "ego_vehicle"

# Points of RViz that are farther from the origin are refused.
_MAX_DISTANCE_M = 1e5
_WHEEL_NAMES = [wheel + "_wheel" for wheel in WHEELS]
_POINT_FIELDS = [
    PointField(name, 4 * number, PointField.FLOAT32, 1)
    for number, name in enumerate(("x", "y", "z", "intensity"))
]


def map_vector(yaw_rad: float, forward: float, left: float) -> Vector3:
    """Return a vector of the body frame in the map frame."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return Vector3(c * forward - s * left, s * forward + c * left, 0.0)


def quaternion_from_yaw(yaw_rad: float, pitch_rad: float = 0.0) -> Quaternion:
    """Return the orientation of a body, see `quaternion`."""
    return Quaternion(*quaternion(yaw_rad, pitch_rad))


def map_point(frame_id: str, point: Point) -> tuple[float, float]:
    """Return (x, y) [m] of a point in the map.

    Raises:
        ValueError: the frame is not the map, or a value is not finite or too large
    """
    if frame_id.lstrip("/") not in (MAP_FRAME, ""):
        raise ValueError(f"it is in the frame '{frame_id}'; set RViz's Fixed Frame to map")
    if not (math.isfinite(point.x) and math.isfinite(point.y)):
        raise ValueError(f"({point.x}, {point.y}) is not finite")
    if max(abs(point.x), abs(point.y)) > _MAX_DISTANCE_M:
        raise ValueError(
            f"({point.x:g}, {point.y:g}) is farther than {_MAX_DISTANCE_M:g} m from the origin"
        )
    return point.x, point.y


def map_pose(frame_id: str, pose: Pose) -> tuple[float, float, float]:
    """Return (x [m], y [m], yaw [rad]) of a pose in the map.

    Raises:
        ValueError: as map_point, or the orientation is not a unit quaternion
    """
    return *map_point(frame_id, pose.position), yaw_from_quaternion(unit(pose.orientation))


def command_of(message: Any) -> Command:
    """Return the command in a CarlaVehicleControl or CarlaEgoVehicleControl, without its stamp."""
    return Command(
        message.throttle, message.steer, message.brake, message.hand_brake, message.reverse
    )


def ackermann_target(message: AckermannDrive) -> AckermannTarget:
    """Return the target in an AckermannDrive."""
    angle = message.steering_angle, message.steering_angle_velocity
    return AckermannTarget(*angle, message.speed, message.acceleration, message.jerk)


def odometry_message(
    state: VehicleState, stamp: rospy.Time, vehicle_frame: str = VEHICLE_FRAME, *slope: float
) -> Odometry:
    """Return pose, with height and pitch if given, in the map, and twist in the body frame."""
    pose = state.x_m, state.y_m, state.yaw_rad, *slope
    twist = state.speed_mps, state.lateral_speed_mps, state.yaw_rate_radps
    return odometry.odometry_message(stamp, pose, twist, vehicle_frame)


def imu_message(reading: ImuReading, settings: SensorSettings, header: Header) -> Imu:
    """Return acceleration and rotation; there is no orientation (REP 145)."""
    return Imu(
        header=header,
        orientation_covariance=[-1.0] + [0.0] * 8,
        angular_velocity=Vector3(*reading.rate_radps),
        angular_velocity_covariance=_diagonal(settings.rate_noise_radps),
        linear_acceleration=Vector3(*reading.acceleration_mps2),
        linear_acceleration_covariance=_diagonal(settings.acceleration_noise_mps2),
    )


def gnss_message(reading: GnssReading, settings: SensorSettings, header: Header) -> NavSatFix:
    """Return latitude and longitude [deg]; NaN without a fix.

    The covariance is what a receiver knows: it contains no reflections.
    """
    message = NavSatFix(header=header)
    message.status.service = NavSatStatus.SERVICE_GPS
    if not reading.has_fix:
        message.status.status = NavSatStatus.STATUS_NO_FIX
        message.latitude = message.longitude = message.altitude = math.nan
        return message
    message.latitude, message.longitude = geodetic_from_map(reading.x_m, reading.y_m)
    message.altitude = reading.z_m
    message.position_covariance = _diagonal(math.hypot(settings.noise_m, settings.bias_m))
    message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
    return message


def wheel_speeds_message(reading: Sequence[float], _settings: Any, header: Header) -> JointState:
    """Return the angular velocities of the wheels [rad/s]."""
    return JointState(header=header, name=_WHEEL_NAMES, velocity=reading)


def point_cloud_message(reading: np.ndarray, _settings: Any, header: Header) -> PointCloud2:
    """Return the points (N, 4) of a scan: x, y, z [m] and intensity."""
    points = np.ascontiguousarray(reading, np.float32)
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        fields=_POINT_FIELDS,
        point_step=16,
        row_step=16 * len(points),
        data=points.tobytes(),
        is_dense=True,
    )


def scan_message(reading: np.ndarray, settings: SensorSettings, header: Header) -> LaserScan:
    """Return the points (N, 4) of the planar lidar as ranges, infinite where no beam hit."""
    x, y, _, intensity = np.asarray(reading, float).T
    beams = np.rint(np.arctan2(y, x) / PLANAR_STEP_RAD).astype(int) + PLANAR_BEAMS // 2
    ranges, intensities = np.full(PLANAR_BEAMS, np.inf), np.zeros(PLANAR_BEAMS)
    ranges[beams], intensities[beams] = np.hypot(x, y), intensity
    first_rad = -(PLANAR_BEAMS // 2) * PLANAR_STEP_RAD
    return LaserScan(
        header=header,
        angle_min=first_rad,
        angle_max=first_rad + (PLANAR_BEAMS - 1) * PLANAR_STEP_RAD,
        angle_increment=PLANAR_STEP_RAD,
        scan_time=settings.period_s,
        range_max=settings.range_m,
        ranges=ranges.tolist(),
        intensities=intensities.tolist(),
    )


def _diagonal(deviation: float) -> list[float]:
    variance = deviation * deviation
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
