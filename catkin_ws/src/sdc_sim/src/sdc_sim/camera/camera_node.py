"""The two processes of the front camera: background, then objects and publication.

In lockstep on two cores one process instead needs 1.26 times as long for the packaged route.
"""

from __future__ import annotations

import math
import sys
from typing import Any, Callable, Sequence

import cv2
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera.attached_camera import VIEW_MOUNT, AttachedCamera, CameraMount
from sdc_sim.camera.background import Background
from sdc_sim.camera.boxes import Box
from sdc_sim.camera.camera_input import CameraInput
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import dim
from sdc_sim.camera.scene_objects import SceneObjects
from sdc_sim.camera.shared_pictures import SLOTS, SharedPictures
from sdc_sim.camera.weather import Weather
from sdc_sim.camera.worker_process import WorkerProcess
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, HEIGHT_M, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.road.road import Road
from sdc_sim.ros.bridge_generations import BridgeGeneration
from sdc_sim.ros.message_conversion import (
    COLOURS,
    camera_info_message,
    camera_transform,
    image_message,
)

_TIMEOUT_S = 10.0
_LIGHT_SIZE_M = 0.4
_EGO_SIZE_M = (4.7, 2.0, 1.5)
_EGO_BGR = (120, 60, 25)
# As in the sensor file of the bridge 0.9.11, and in carla_spectator_camera.
_VIEW_FOV_RAD = math.radians(90.0)
_SPECTATOR_FOV_RAD = math.radians(50.0)
# Blue, green, red of the lamp that is lit; of a light that is off, the glass of the red lamp.
_LIT_BGR = {RED: (40, 40, 255), YELLOW: (40, 200, 255), GREEN: (90, 255, 60), OFF: (20, 20, 62)}


class BackgroundPainter:
    """The first process: paints the background of each observation to memory that both share.

    Args:
        waypoints_path: CSV file of the route
        pictures_name: name of the shared pictures
        role_name: name of the vehicle in topics and frames
        generation: names of the cameras
        weather: fields of Weather, None for clear weather
    """

    def __init__(
        self,
        waypoints_path: str,
        pictures_name: str,
        role_name: str,
        generation: BridgeGeneration,
        weather: dict[str, Any] | None = None,
    ):
        cv2.setNumThreads(1)
        self._objects_process = WorkerProcess(
            start_camera_node,
            (waypoints_path, pictures_name, role_name, generation, weather),
            SLOTS - 1,
            lambda problem: print(f"sim: the camera's process {problem}", file=sys.stderr),
        )
        camera = CameraModel()
        road = Road(load_waypoints(waypoints_path))
        air = Weather.read(weather or {})
        self._background = Background(road, road.scenery(), camera, weather=air)
        self._shared = SharedPictures(camera, pictures_name)
        self._slot = 0

    def paint(self, shot: CameraInput) -> None:
        """Paint the background of one observation and hand it to the second process."""
        state = shot.observation.state
        picture = self._shared.pictures[self._slot]
        self._background.draw(picture, state.x_m, state.y_m, state.yaw_rad)
        if self._objects_process.put((self._slot, shot), _TIMEOUT_S):
            self._slot = (self._slot + 1) % SLOTS


class CameraNode:
    """The second process, node front_camera: draws objects and publishes the pictures.

    Args:
        waypoints_path: CSV file of the route
        pictures_name: name of the shared pictures
        role_name: name of the vehicle in topics and frames
        generation: names of the cameras
        weather: fields of Weather, None for clear weather
    """

    def __init__(
        self,
        waypoints_path: str,
        pictures_name: str,
        role_name: str,
        generation: BridgeGeneration,
        weather: dict[str, Any] | None = None,
    ):
        cv2.setNumThreads(1)
        rospy.init_node(
            "front_camera",
            argv=remappings_of(sys.argv),
            disable_signals=True,
            disable_rostime=True,  # each observation carries its time stamp
        )
        road = Road(load_waypoints(waypoints_path))
        camera, names = CameraModel(), generation.front
        self._shared = SharedPictures(camera, pictures_name)
        air = Weather.read(weather or {})
        self._objects = SceneObjects(road.scenery(), camera, weather=air)
        self._frame = role_name + names.frame
        self._camera_info = camera_info_message(camera, self._frame)
        ego = "/carla/" + role_name
        self._image_publisher = LoopPublisher(ego + names.image, Image)
        self._camera_info_publisher = LoopPublisher(ego + names.camera_info, CameraInfo)
        self._static_tf = tf2_ros.StaticTransformBroadcaster()
        self._static_tf.sendTransform(camera_transform(camera, role_name, self._frame))
        self._view = self._spectator = None
        if generation.view:
            self._view = AttachedCamera(road, role_name, generation.view, _VIEW_FOV_RAD, air)
        if generation.spectator:
            self._spectator = AttachedCamera(
                road, role_name, generation.spectator, _SPECTATOR_FOV_RAD, air
            )

    def publish(self, item: tuple[int, CameraInput]) -> None:
        """Finish and publish the picture in a slot of the shared memory, and the other pictures."""
        slot, (observation, daylight, spectator) = item
        picture = self._shared.pictures[slot]
        stamp, state = rospy.Time(*observation.stamp), observation.state
        boxes = [obstacle_box(obstacle) for obstacle in observation.obstacles]
        boxes += [traffic_light_box(light) for light in observation.traffic_lights]
        pose = state.x_m, state.y_m, state.yaw_rad
        self._objects.draw(picture, *pose, boxes, observation.time_s)
        dim(picture, daylight)
        self._camera_info.header.stamp = stamp
        self._camera_info_publisher.publish(self._camera_info)
        self._image_publisher.publish(image_message(picture, stamp, self._frame))
        for camera, mount in (
            (self._view, VIEW_MOUNT),
            (self._spectator, CameraMount(*spectator) if spectator else None),
        ):
            if camera is not None and mount is not None and camera.wanted:
                own = [*boxes, ego_box(state)]
                camera.publish(state, mount, own, daylight, stamp, self._static_tf)


def start_camera_node(*arguments: Any) -> Callable[[tuple[int, CameraInput]], None]:
    """Start the node of the second process; return what handles its items."""
    return CameraNode(*arguments).publish


def ego_box(state: VehicleState) -> Box:
    """Return the own car as the cameras outside it draw it."""
    return Box(state.x_m, state.y_m, state.yaw_rad, *_EGO_SIZE_M, _EGO_BGR, "car")


def remappings_of(argv: Sequence[str]) -> list[str]:
    """Return the command line without its special keys such as __name, which belong to the sim.

    The process has the command line of the sim, with the remappings of its topics.
    """
    return [argument for argument in argv if not argument.startswith("__")]


def obstacle_box(obstacle: ObstacleState) -> Box:
    """Return an obstacle as the camera draws it."""
    return Box(
        obstacle.x_m,
        obstacle.y_m,
        obstacle.yaw_rad,
        obstacle.length_m,
        obstacle.width_m,
        obstacle.height_m,
        tuple(round(255 * share) for share in reversed(COLOURS[obstacle.kind])),
        obstacle.kind,
    )


def traffic_light_box(light: TrafficLightState) -> Box:
    """Return a traffic light as the camera draws it: it faces the cars that it applies to."""
    return Box(
        light.x_m,
        light.y_m,
        light.heading_rad + math.pi,
        _LIGHT_SIZE_M,
        _LIGHT_SIZE_M,
        HEIGHT_M,
        _LIT_BGR[light.state],
        "light",
    )
