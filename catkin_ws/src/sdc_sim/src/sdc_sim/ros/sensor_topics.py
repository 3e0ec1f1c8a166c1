"""The topics of the sensors."""

from __future__ import annotations

from typing import Any, Callable, Mapping, NamedTuple

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import Imu, JointState, NavSatFix, PointCloud2
from std_msgs.msg import Float32

from sdc_common.ros.node import LoopPublisher
from sdc_sim.ros.bridge_generations import BridgeGeneration
from sdc_sim.ros.sensor_messages import (
    gnss_message,
    imu_message,
    point_cloud_message,
    wheel_speeds_message,
)
from sdc_sim.sensors.mounts import (
    GNSS_MOUNT_M,
    IMU_MOUNT_M,
    LIDAR_MOUNT_M,
    PLANAR_LIDAR_MOUNT_M,
)
from sdc_sim.sensors.readings import SensorReadings
from sdc_sim.sensors.settings import SENSORS, SensorSettings


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
        generation: names of topics and frames
        role_name: name of the vehicle in topics and frames
    """

    def __init__(
        self, settings: Mapping[str, SensorSettings], generation: BridgeGeneration, role_name: str
    ):
        self._publishers = []
        self.vehicle_topics = []
        transforms = []
        for name in SENSORS:
            if name not in settings:
                continue
            names, form = generation.sensors[name], _FORMS[name]
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
