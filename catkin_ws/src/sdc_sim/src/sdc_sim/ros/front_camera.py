"""The node of the cameras: paints the observations that the simulator sends, and publishes them."""

from __future__ import annotations

import contextlib
import math
import queue
import threading
from multiprocessing.connection import Connection
from typing import Callable, Sequence

import cv2
import numpy as np
import rospy
import tf2_ros
from carla_msgs.msg import CarlaWeatherParameters
from geometry_msgs.msg import Pose, PoseStamped, Quaternion, Transform, TransformStamped, Vector3
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from sdc_common.ros.node import LoopPublisher
from sdc_common.ros.refusal import refusing
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_map.network import Network
from sdc_sim.camera.boxes import Box, ego_box, obstacle_box, traffic_light_box
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS, Names
from sdc_sim.ros.picture_feed import MAX_MESSAGE, PictureSettings, unpacked
from sdc_sim.ros.picture_messages import (
    CameraMount,
    camera_info_message,
    camera_mount,
    compressed_message,
    daylight,
    image_message,
    spectator_mount,
)
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.simulation.weather import Weather

# As in the sensor file of the bridge 0.9.11, and in carla_spectator_camera.
_OTHER_SIZE_PX = (800, 600)
_VIEW_FOV_RAD = math.radians(90.0)
_SPECTATOR_FOV_RAD = math.radians(50.0)
# Behind the vehicle, as in the sensor files of the bridge.
_VIEW_MOUNT = CameraMount(-4.5, 0.0, 2.8, 0.0, math.radians(20.0))
# A pose on the vehicle moves it.
_SET_VIEW = "/rgb_view/control/set_transform"


class CameraTopics:
    """The topics and the frame of one camera of the vehicle."""

    def __init__(self, role_name: str, names: Names):
        self._vehicle_frame, self._frame = role_name, role_name + names.frame
        ego = "/carla/" + role_name
        self._image = LoopPublisher(ego + names.image, Image)
        self._compressed = LoopPublisher(ego + names.image + "/compressed", CompressedImage)
        self._camera_info = LoopPublisher(ego + names.camera_info, CameraInfo)
        self._static_tf = tf2_ros.StaticTransformBroadcaster()

    @property
    def wanted(self) -> bool:
        """Whether the camera has subscribers."""
        topics = self._image, self._compressed, self._camera_info
        return any(topic.get_num_connections() for topic in topics)

    def mount(self, camera: CameraModel, mount: CameraMount) -> None:
        """Publish where the camera is on the vehicle: its optical frame is that of REP 103."""
        self._info = camera_info_message(camera, self._frame)
        rotation = Rotation.from_matrix(camera.map_from_optical(mount.yaw_rad))
        place = Vector3(mount.x_m, mount.y_m, mount.z_m), Quaternion(*rotation.as_quat())
        header = Header(frame_id=self._vehicle_frame)
        self._static_tf.sendTransform(TransformStamped(header, self._frame, Transform(*place)))

    def publish(self, picture: np.ndarray, stamp_ns: int) -> None:
        """Publish a picture and the description of its camera."""
        self._info.header.stamp = stamp = rospy.Time(0, stamp_ns)
        self._camera_info.publish(self._info)
        self._image.publish(image_message(picture, stamp, self._frame))
        if self._compressed.get_num_connections():
            self._compressed.publish(compressed_message(picture, stamp, self._frame))


class OtherCamera:
    """A camera besides the front camera: it renders only while its picture has subscribers."""

    def __init__(
        self, road: Road | Network, weather: Weather, topics: CameraTopics, fov_rad: float
    ):
        self._road, self._weather = road, weather
        self._topics, self._fov_rad = topics, fov_rad
        self.mount: CameraMount | None = None
        self._last_mount: CameraMount | None = None
        self._renderer: Renderer | None = None

    def publish(self, observation: Snapshot, boxes: Sequence[Box], light: float) -> None:
        """Render and publish the picture of an observation if the camera is mounted and wanted."""
        mount, state = self.mount, observation.state
        if mount is None or not self._topics.wanted:
            return
        if mount != self._last_mount or self._renderer is None:
            # The renderer gets the position of the camera instead of that of the vehicle.
            camera = CameraModel(*_OTHER_SIZE_PX, self._fov_rad, 0.0, mount.z_m, mount.pitch_rad)
            if self._renderer is None or camera != self._renderer.camera:
                self._renderer = Renderer(self._road, camera, weather=self._weather)
            self._topics.mount(camera, mount)
            self._last_mount = mount
        c, s = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        x = state.x_m + c * mount.x_m - s * mount.y_m
        y = state.y_m + s * mount.x_m + c * mount.y_m
        place, seen = (x, y, state.yaw_rad + mount.yaw_rad), [*boxes, ego_box(state)]
        picture = self._renderer.render(*place, seen, light, time_s=observation.time_s)
        self._topics.publish(picture, observation.stamp_ns)


class FrontCamera:
    """The front camera of the simulated car, and the cameras behind it and of a spectator.

    One thread renders the pictures of the front camera, and one sends them: a subscriber that still
    works on a picture delays the next one by less.
    """

    def __init__(self, connection: Connection, settings: PictureSettings):
        cv2.setNumThreads(1)
        self._connection = connection
        self._daylight = settings.daylight
        road: Road | Network
        if settings.map_path:
            from sdc_map.network_file import load_network  # sumolib takes 0.2 s.

            road = load_network(settings.map_path)
        else:
            road = Road(load_waypoints(settings.waypoints_path))
        weather = Weather(**settings.weather)
        self._renderer = Renderer(road, weather=weather)
        camera = self._renderer.camera
        self._rendered: queue.Queue[tuple[np.ndarray, int] | None] = queue.Queue(1)

        bridge, self._role_name = BRIDGE_VERSIONS[settings.bridge], settings.role_name
        self._topics = CameraTopics(self._role_name, bridge.front)
        mount = CameraMount(camera.mount_x_m, 0.0, camera.mount_z_m, 0.0, camera.pitch_rad)
        self._topics.mount(camera, mount)
        self._others = []
        if bridge.view:
            topics = CameraTopics(self._role_name, bridge.view)
            self._others.append(OtherCamera(road, weather, topics, _VIEW_FOV_RAD))
            self._others[0].mount = _VIEW_MOUNT
        if _SET_VIEW in bridge.topics:
            self._subscribe(f"/carla/{self._role_name}{_SET_VIEW}", Pose, self._on_view)
        if bridge.spectator:
            topics = CameraTopics(self._role_name, bridge.spectator)
            self._spectator = OtherCamera(road, weather, topics, _SPECTATOR_FOV_RAD)
            self._others.append(self._spectator)
            topic = f"/carla/{self._role_name}/spectator_pose"
            self._subscribe(topic, PoseStamped, self._on_spectator)
        if "/carla/weather_control" in bridge.topics:
            self._subscribe("/carla/weather_control", CarlaWeatherParameters, self._on_weather)

    def loop(self) -> None:
        """Publish a picture of each observation until the simulator ends."""
        threading.Thread(target=self._render, daemon=True).start()
        while (rendered := self._rendered.get()) is not None:
            self._topics.publish(*rendered)

    def _render(self) -> None:
        try:
            self._connection.send_bytes(b"")  # the request of an observation
            while True:
                observation = unpacked(self._connection.recv_bytes(MAX_MESSAGE))
                with contextlib.suppress(OSError):  # the next one comes while this one is painted
                    self._connection.send_bytes(b"")
                self._take_pictures(observation)
        except (EOFError, OSError):
            rospy.loginfo("front_camera: the simulator has ended")
        except ValueError as error:
            rospy.logerr(f"front_camera: no record of an observation: {error}")
        finally:
            self._rendered.put(None)

    def _take_pictures(self, observation: Snapshot) -> None:
        """Render the picture of an observation, and render and publish those of other cameras."""
        state, light = observation.state, self._daylight
        boxes = [obstacle_box(obstacle) for obstacle in observation.obstacles]
        boxes += [traffic_light_box(light) for light in observation.traffic_lights]
        place = state.x_m, state.y_m, state.yaw_rad
        picture = self._renderer.render(*place, boxes, light, time_s=observation.time_s)
        self._rendered.put((picture, observation.stamp_ns))
        for camera in self._others:
            camera.publish(observation, boxes, light)

    def _subscribe(self, topic: str, message_class: type, callback: Callable) -> None:
        """Subscribe with a callback that raises ValueError to refuse a message."""

        def on_message(message: object) -> None:
            with refusing(topic):
                callback(message)

        rospy.Subscriber(topic, message_class, on_message, queue_size=1)

    def _on_weather(self, message: CarlaWeatherParameters) -> None:
        self._daylight = daylight(message.sun_altitude_angle)
        # For this node after a crash.
        rospy.set_param("~daylight", self._daylight)

    def _on_view(self, pose: Pose) -> None:
        self._others[0].mount = camera_mount(pose)

    def _on_spectator(self, message: PoseStamped) -> None:
        self._spectator.mount = spectator_mount(message, self._role_name)
