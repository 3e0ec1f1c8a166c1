"""ROS node front_camera: renders and publishes the pictures, in a process of its own."""

from __future__ import annotations

import math
import sys
from typing import Sequence

import cv2
import numpy as np
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera.boxes import Box
from sdc_sim.camera.renderer import Renderer
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import (
    COLOURS,
    camera_info_message,
    camera_transform,
    image_message,
)
from sdc_sim.simulation.simulation import Observation

_LIGHT_HEIGHT_M = 3.4
_LIGHT_SIZE_M = 0.4
# Blue, green, red of the lamp that is lit; of a light that is off, the glass of the red lamp.
_LIT_BGR = {RED: (40, 40, 255), YELLOW: (40, 200, 255), GREEN: (90, 255, 60), OFF: (20, 20, 62)}


class CameraNode:
    """Node that publishes the picture and the camera_info of each observation."""

    def __init__(
        self, waypoints_path: str, image_topic: str, camera_info_topic: str, daylight: float
    ):
        cv2.setNumThreads(1)
        rospy.init_node(
            "front_camera",
            argv=remappings_of(sys.argv),
            disable_signals=True,
            disable_rostime=True,  # each observation carries its time stamp
        )
        self._daylight = daylight
        self._renderer = Renderer(Road(load_waypoints(waypoints_path)))
        camera = self._renderer.camera
        self._picture = np.empty((camera.height, camera.width, 4), np.uint8)
        self._camera_info = camera_info_message(camera)
        self._image_publisher = LoopPublisher(image_topic, Image)
        self._camera_info_publisher = LoopPublisher(camera_info_topic, CameraInfo)
        self._static_tf = tf2_ros.StaticTransformBroadcaster()
        self._static_tf.sendTransform(camera_transform(camera))

    def publish(self, observation: Observation) -> None:
        """Render and publish the picture of one observation."""
        stamp, state = rospy.Time(*observation.stamp), observation.state
        boxes = [obstacle_box(obstacle) for obstacle in observation.obstacles]
        boxes += [traffic_light_box(light) for light in observation.traffic_lights]
        self._renderer.render(
            state.x_m, state.y_m, state.yaw_rad, boxes, self._daylight, out=self._picture
        )
        self._camera_info.header.stamp = stamp
        self._camera_info_publisher.publish(self._camera_info)
        self._image_publisher.publish(image_message(self._picture, stamp))


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
        _LIGHT_HEIGHT_M,
        _LIT_BGR[light.state],
        "light",
    )
