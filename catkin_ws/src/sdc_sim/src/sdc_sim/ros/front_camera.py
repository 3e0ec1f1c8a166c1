"""The node of the cameras: paints the observations that the simulator sends, and publishes them."""

from __future__ import annotations

import queue
import threading
from multiprocessing.connection import Connection

import cv2
import numpy as np
import rospy
import tf2_ros
from carla_msgs.msg import CarlaWeatherParameters
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera.boxes import ego_box, obstacle_box, traffic_light_box
from sdc_sim.camera.painting import dim
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_sim.ros.attached_camera import (
    SPECTATOR_FOV_RAD,
    VIEW_FOV_RAD,
    VIEW_MOUNT,
    AttachedCamera,
    CameraMount,
)
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.picture_feed import PictureSettings
from sdc_sim.ros.picture_messages import (
    camera_info_message,
    camera_transform,
    daylight,
    image_message,
    spectator_mount,
)
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.simulation.weather import Weather

# One is painted, one waits, and one gets its objects.
_PICTURES = 3


class FrontCamera:
    """The front camera of the simulated car, and the cameras behind it and of a spectator.

    One thread paints sky and ground, and one draws the objects and publishes: OpenCV does most of
    the work and does not hold Python's lock meanwhile.

    Args:
        connection: sends observations until the simulator ends
        settings: what the pictures have in common
    """

    def __init__(self, connection: Connection, settings: PictureSettings):
        cv2.setNumThreads(1)
        self._connection = connection
        self._daylight = settings.daylight
        road = Road(load_waypoints(settings.waypoints_path))
        weather = Weather.read(settings.weather)
        self._renderer = Renderer(road, weather=weather)
        camera = self._renderer.camera
        self._free: queue.Queue[np.ndarray] = queue.Queue()
        for _ in range(_PICTURES):
            self._free.put(np.empty((camera.height, camera.width, 4), np.uint8))
        self._painted: queue.Queue[tuple[Snapshot, np.ndarray] | None] = queue.Queue()

        bridge, self._role_name = BRIDGE_VERSIONS[settings.bridge], settings.role_name
        names, ego = bridge.front, "/carla/" + self._role_name
        self._frame = self._role_name + names.frame
        self._camera_info = camera_info_message(camera, self._frame)
        self._image_publisher = LoopPublisher(ego + names.image, Image)
        self._camera_info_publisher = LoopPublisher(ego + names.camera_info, CameraInfo)
        self._static_tf = tf2_ros.StaticTransformBroadcaster()
        self._static_tf.sendTransform(camera_transform(camera, self._role_name, self._frame))
        self._view = self._spectator = None
        self._spectator_mount: CameraMount | None = None
        if bridge.view:
            self._view = AttachedCamera(road, self._role_name, bridge.view, VIEW_FOV_RAD, weather)
        if bridge.spectator:
            self._spectator = AttachedCamera(
                road, self._role_name, bridge.spectator, SPECTATOR_FOV_RAD, weather
            )
            rospy.Subscriber(ego + "/spectator_pose", PoseStamped, self._on_spectator, queue_size=1)
        if "/carla/weather_control" in bridge.topics:
            rospy.Subscriber(
                "/carla/weather_control", CarlaWeatherParameters, self._on_weather, queue_size=1
            )

    def loop(self) -> None:
        """Publish a picture of each observation until the simulator ends."""
        threading.Thread(target=self._paint_backgrounds, daemon=True).start()
        self._acknowledge()  # the start
        while (item := self._painted.get()) is not None:
            try:
                self._publish(*item)
            except rospy.ROSException:
                # At shutdown rospy closes the topics while this thread still publishes.
                if rospy.core.is_shutdown_requested():
                    return
                raise
            self._free.put(item[1])
            self._acknowledge()

    def _acknowledge(self) -> None:
        try:
            self._connection.send_bytes(b"")
        except OSError:
            # The simulator has ended; its last observations are published all the same.
            rospy.loginfo_once("front_camera: the simulator has ended")

    def _paint_backgrounds(self) -> None:
        try:
            while True:
                observation: Snapshot = self._connection.recv()
                picture, state = self._free.get(), observation.state
                self._renderer.background.draw(picture, state.x_m, state.y_m, state.yaw_rad)
                self._painted.put((observation, picture))
        except (EOFError, OSError):
            pass
        finally:
            self._painted.put(None)

    def _publish(self, observation: Snapshot, picture: np.ndarray) -> None:
        """Draw the objects on a background, and publish this picture and those of other cameras."""
        stamp, state = rospy.Time(*observation.stamp), observation.state
        boxes = [obstacle_box(obstacle) for obstacle in observation.obstacles]
        boxes += [traffic_light_box(light) for light in observation.traffic_lights]
        light = self._daylight
        self._renderer.objects.draw(
            picture, state.x_m, state.y_m, state.yaw_rad, boxes, observation.time_s
        )
        dim(picture, light)
        self._camera_info.header.stamp = stamp
        self._camera_info_publisher.publish(self._camera_info)
        self._image_publisher.publish(image_message(picture, stamp, self._frame))
        for camera, mount in ((self._view, VIEW_MOUNT), (self._spectator, self._spectator_mount)):
            if camera is not None and mount is not None and camera.wanted:
                own = [*boxes, ego_box(state)]
                camera.publish(state, mount, own, light, stamp, self._static_tf)

    def _on_weather(self, message: CarlaWeatherParameters) -> None:
        try:
            self._daylight = daylight(message.sun_altitude_angle)
        except ValueError as error:
            rospy.logwarn_throttle(
                1.0, f"front_camera: refused a message on weather_control: {error}"
            )

    def _on_spectator(self, message: PoseStamped) -> None:
        try:
            self._spectator_mount = CameraMount(*spectator_mount(message, self._role_name))
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"front_camera: refused a pose on spectator_pose: {error}")
