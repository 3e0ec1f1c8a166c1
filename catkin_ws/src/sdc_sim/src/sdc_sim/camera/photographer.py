"""The second of the two processes behind the front camera: paints what stands in the picture, and publishes it."""

from __future__ import annotations

import math
import signal
import sys

import cv2
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.camera import shared_pictures
from sdc_sim.camera.bodies import Box, SceneObjects
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import dim
from sdc_sim.camera.side_process import give_way, serve
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import (
    COLOURS,
    camera_info_message,
    camera_transform,
    image_message,
)

LIGHT_HEIGHT_M = 3.4
LIGHT_SIZE_M = 0.4
# The lamp that burns, blue, green, red; off: the red one's glass.
LIT_BGR = {RED: (40, 40, 255), YELLOW: (40, 200, 255), GREEN: (90, 255, 60), OFF: (20, 20, 62)}


class Photographer:
    """Finishes and publishes the pictures that BackdropPainter began."""

    def __init__(
        self,
        waypoints_path: str,
        image_topic: str,
        camera_info_topic: str,
        daylight: str,
        pictures_number: str,
    ):
        model = CameraModel()
        self.daylight = float(daylight)
        self.pictures = shared_pictures.pictures(int(pictures_number))
        self.bodies = SceneObjects(Road(load_waypoints(waypoints_path)).scenery(), model)
        self.camera_info = camera_info_message(model)
        self.image_publisher = LoopPublisher(image_topic, Image)
        self.camera_info_publisher = LoopPublisher(camera_info_topic, CameraInfo)
        self.static_tf = tf2_ros.StaticTransformBroadcaster()
        self.static_tf.sendTransform(camera_transform(model))

    def take(self, work) -> None:
        """Finish and publish one picture."""
        slot, stamp, x, y, yaw, bodies, lamps = work
        stamp = rospy.Time(*stamp)
        picture = self.pictures[slot]
        boxes = [box_of(ObstacleState(*body)) for body in bodies] + [
            light_of(TrafficLightState(*lamp)) for lamp in lamps
        ]
        self.bodies.draw(picture, x, y, yaw, boxes)
        dim(picture, self.daylight)
        self.camera_info.header.stamp = stamp
        self.camera_info_publisher.publish(self.camera_info)
        self.image_publisher.publish(image_message(picture, stamp))


def box_of(body: ObstacleState) -> Box:
    """An obstacle as the camera draws it."""
    return Box(
        body.x_m,
        body.y_m,
        body.yaw_rad,
        body.length_m,
        body.width_m,
        body.height_m,
        tuple(round(255 * share) for share in reversed(COLOURS[body.kind])),
        body.kind,
    )


def light_of(lamp: TrafficLightState) -> Box:
    """A traffic light as the camera draws it: it looks at those who drive along its heading."""
    return Box(
        lamp.x_m,
        lamp.y_m,
        lamp.heading_rad + math.pi,
        LIGHT_SIZE_M,
        LIGHT_SIZE_M,
        LIGHT_HEIGHT_M,
        LIT_BGR[lamp.state],
        "light",
    )


def main():
    """Serve until the painter closes or ends: an interrupt from the keyboard is the world's to hear."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    give_way()
    cv2.setNumThreads(1)
    *arguments, socket_number = rospy.myargv(sys.argv)[1:]
    rospy.init_node(
        "front_camera", disable_signals=True, disable_rostime=True
    )  # each picture brings its time along
    serve(int(socket_number), Photographer(*arguments).take)


if __name__ == "__main__":
    main()
