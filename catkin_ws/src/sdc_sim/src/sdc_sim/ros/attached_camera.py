"""Cameras besides the front camera: they render only while their picture has subscribers."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_sim.camera.boxes import Box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.road import Road
from sdc_sim.ros.bridge_versions import CameraNames
from sdc_sim.ros.picture_messages import camera_info_message, camera_transform, image_message
from sdc_sim.simulation.weather import CLEAR, Weather

WIDTH_PX, HEIGHT_PX = 800, 600


class CameraMount(NamedTuple):
    """Pose of a camera on the vehicle; positive pitch looks down."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    pitch_rad: float


# As in the sensor file of the bridge 0.9.11, and in carla_spectator_camera.
VIEW_FOV_RAD = math.radians(90.0)
SPECTATOR_FOV_RAD = math.radians(50.0)
# Behind the vehicle, as in the sensor files of the bridge.
VIEW_MOUNT = CameraMount(-4.5, 0.0, 2.8, 0.0, math.radians(20.0))


class AttachedCamera:
    """A camera that is attached to the vehicle and may be moved.

    Args:
        road: the road
        role_name: name of the vehicle in topics and frames
        names: topics and frame of the camera
        fov_rad: horizontal field of view
        weather: weather of the pictures
    """

    def __init__(
        self,
        road: Road,
        role_name: str,
        names: CameraNames,
        fov_rad: float,
        weather: Weather = CLEAR,
    ):
        self._road = road
        self._fov_rad = fov_rad
        self._weather = weather
        self._vehicle_frame = role_name
        self._frame = role_name + names.frame
        ego = "/carla/" + role_name
        self._image = rospy.Publisher(ego + names.image, Image, queue_size=1)
        self._camera_info = rospy.Publisher(ego + names.camera_info, CameraInfo, queue_size=1)
        self._mount: CameraMount | None = None
        self._renderer: Renderer | None = None

    @property
    def wanted(self) -> bool:
        """Whether the camera has subscribers."""
        return bool(self._image.get_num_connections() or self._camera_info.get_num_connections())

    def publish(
        self,
        state: VehicleState,
        mount: CameraMount,
        boxes: Sequence[Box],
        daylight: float,
        stamp: rospy.Time,
        transforms: tf2_ros.StaticTransformBroadcaster,
    ) -> None:
        """Render and publish the picture of this moment.

        Args:
            state: state of the vehicle
            mount: pose of the camera on the vehicle
            boxes: what to draw besides the road
            daylight: brightness, 0..1
            stamp: time of the picture
            transforms: publishes the camera's frame when the mount changes
        """
        if mount != self._mount or self._renderer is None:
            self._mount_at(mount, transforms)
        assert self._renderer is not None
        c, s = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        picture = self._renderer.render(
            state.x_m + c * mount.x_m - s * mount.y_m,
            state.y_m + s * mount.x_m + c * mount.y_m,
            state.yaw_rad + mount.yaw_rad,
            boxes,
            daylight,
            time_s=stamp.to_sec(),
        )
        info = camera_info_message(self._renderer.camera, self._frame)
        info.header.stamp = stamp
        self._camera_info.publish(info)
        self._image.publish(image_message(np.ascontiguousarray(picture), stamp, self._frame))

    def _mount_at(self, mount: CameraMount, transforms: tf2_ros.StaticTransformBroadcaster) -> None:
        # The renderer gets the position of the camera instead of that of the vehicle.
        model = CameraModel(WIDTH_PX, HEIGHT_PX, self._fov_rad, 0.0, mount.z_m, mount.pitch_rad)
        old = self._renderer
        if old is None or old.camera != model:
            self._renderer = Renderer(self._road, model, weather=self._weather)
        self._mount = mount
        transform = camera_transform(model, self._vehicle_frame, self._frame, mount.yaw_rad)
        transform.transform.translation.x = mount.x_m
        transform.transform.translation.y = mount.y_m
        transforms.sendTransform(transform)
