"""The topics of the sensors: a table, and the conversion of readings to messages."""

from __future__ import annotations

import math
from typing import Any, Callable, Mapping, NamedTuple, Sequence

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, Vector3
from sensor_msgs.msg import (
    Imu,
    JointState,
    NavSatFix,
    NavSatStatus,
    PointCloud2,
    PointField,
)
from std_msgs.msg import Float32, Header

from sdc_common.geometry.geodesy import geodetic_from_map
from sdc_common.ros.node import LoopPublisher
from sdc_sim.ros.bridge_versions import BridgeVersion
from sdc_sim.sensors.readings import (
    GNSS_MOUNT_M,
    IMU_MOUNT_M,
    LIDAR_MOUNT_M,
    PLANAR_LIDAR_MOUNT_M,
    WHEELS,
    GnssReading,
    ImuReading,
    SensorReadings,
)
from sdc_sim.sensors.settings import (
    GnssSettings,
    ImuSettings,
    LidarSettings,
    SensorSettings,
    WheelSpeedSettings,
)

_WHEEL_NAMES = [wheel + "_wheel" for wheel in WHEELS]
_POINT_FIELDS = [
    PointField(name, 4 * number, PointField.FLOAT32, 1)
    for number, name in enumerate(("x", "y", "z", "intensity"))
]


def imu_message(reading: ImuReading, settings: ImuSettings, stamp: rospy.Time, frame: str) -> Imu:
    """Return acceleration and rotation; there is no orientation (REP 145)."""
    return Imu(
        header=Header(stamp=stamp, frame_id=frame),
        orientation_covariance=[-1.0] + [0.0] * 8,
        angular_velocity=Vector3(*reading.rate_radps),
        angular_velocity_covariance=_diagonal(settings.rate_noise_radps),
        linear_acceleration=Vector3(*reading.acceleration_mps2),
        linear_acceleration_covariance=_diagonal(settings.acceleration_noise_mps2),
    )


def gnss_message(
    reading: GnssReading, settings: GnssSettings, stamp: rospy.Time, frame: str
) -> NavSatFix:
    """Return latitude and longitude [deg]; NaN without a fix.

    The covariance is what a receiver knows: it contains no reflections.
    """
    message = NavSatFix(header=Header(stamp=stamp, frame_id=frame))
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


def wheel_speeds_message(
    reading: Sequence[float], _settings: WheelSpeedSettings, stamp: rospy.Time, frame: str
) -> JointState:
    """Return the angular velocities of the wheels [rad/s]."""
    return JointState(
        header=Header(stamp=stamp, frame_id=frame), name=_WHEEL_NAMES, velocity=reading
    )


def point_cloud_message(
    reading: np.ndarray, _settings: LidarSettings, stamp: rospy.Time, frame: str
) -> PointCloud2:
    """Return the points (N, 4) of a scan: x, y, z [m] and intensity."""
    points = np.ascontiguousarray(reading, np.float32)
    return PointCloud2(
        header=Header(stamp=stamp, frame_id=frame),
        height=1,
        width=len(points),
        fields=_POINT_FIELDS,
        point_step=16,
        row_step=16 * len(points),
        data=points.tobytes(),
        is_dense=True,
    )


def _diagonal(deviation: float) -> list[float]:
    variance = deviation * deviation
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]


class _Form(NamedTuple):
    """How a sensor is published: field of the readings, message, position on the vehicle [m]."""

    field: str
    message_class: type
    position_m: tuple[float, float, float] | None
    convert: Callable[[Any, Any, rospy.Time, str], Any]


_FORMS = {
    "imu": _Form("imu", Imu, IMU_MOUNT_M, imu_message),
    "gnss": _Form("gnss", NavSatFix, GNSS_MOUNT_M, gnss_message),
    "speedometer": _Form("speed_mps", Float32, None, lambda speed, *_: Float32(speed)),
    "lidar": _Form("lidar", PointCloud2, LIDAR_MOUNT_M, point_cloud_message),
    "planar_lidar": _Form("planar_lidar", PointCloud2, PLANAR_LIDAR_MOUNT_M, point_cloud_message),
    "wheel_speeds": _Form("wheel_speeds_radps", JointState, None, wheel_speeds_message),
}


class SensorTopics:
    """Publishes the readings of a tick, the wheel speeds last.

    All topics are published in the caller's thread, and latched for nodes that connect later.

    Args:
        settings: settings of the sensors that are on, by name
        bridge: names of topics and frames
        role_name: name of the vehicle in topics and frames
    """

    def __init__(
        self, settings: Mapping[str, SensorSettings], bridge: BridgeVersion, role_name: str
    ):
        self._publishers = []
        self.vehicle_topics = []
        transforms = []
        for name, form in _FORMS.items():
            if name not in settings:
                continue
            names = bridge.sensors[name]
            frame = role_name + names.frame
            publisher = LoopPublisher(
                f"/carla/{role_name}{names.topic}", form.message_class, latch=True
            )
            self._publishers.append((publisher, form, settings[name], frame))
            self.vehicle_topics.append(names.topic)
            if form.position_m is not None:
                transforms.append(_mount(role_name, frame, form.position_m))
        if transforms:
            self._static_tf = tf2_ros.StaticTransformBroadcaster()
            self._static_tf.sendTransform(transforms)

    @property
    def tick_topics(self) -> list[str]:
        """Full names of the topics."""
        return [publisher.resolved_name for publisher, *_ in self._publishers]

    def publish(self, readings: SensorReadings, stamp: rospy.Time) -> None:
        """Publish the readings of a tick.

        Args:
            readings: the readings
            stamp: time of the tick
        """
        for publisher, form, settings, frame in self._publishers:
            reading = getattr(readings, form.field)
            if reading is not None:
                publisher.publish(form.convert(reading, settings, stamp, frame))


def _mount(role_name: str, frame: str, position_m: tuple[float, float, float]) -> TransformStamped:
    transform = TransformStamped()
    transform.header.frame_id, transform.child_frame_id = role_name, frame
    translation = transform.transform.translation
    translation.x, translation.y, translation.z = position_m
    transform.transform.rotation.w = 1.0
    return transform
