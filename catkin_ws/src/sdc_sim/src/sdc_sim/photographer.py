"""The second of the two processes behind the front camera: paints what stands in the picture, and publishes it."""
from __future__ import annotations

import signal
import sys

import cv2
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_package.node import LoopPublisher
from sdc_package.waypoints import load_waypoints
from sdc_sim import shared_pictures
from sdc_sim.bodies import Bodies, Box
from sdc_sim.camera import CameraModel
from sdc_sim.messages import COLOURS, camera_info_message, camera_transform, image_message
from sdc_sim.obstacles import Body
from sdc_sim.road import Road
from sdc_sim.side_process import serve


class Photographer:
    """Finishes and publishes the pictures that BackdropPainter began."""

    def __init__(self, waypoints_path: str, image_topic: str, camera_info_topic: str, pictures_number: str):
        model = CameraModel()
        self.pictures = shared_pictures.pictures(int(pictures_number))
        self.bodies = Bodies(Road(load_waypoints(waypoints_path)).scenery(), model)
        self.camera_info = camera_info_message(model)
        self.image_publisher = LoopPublisher(image_topic, Image)
        self.camera_info_publisher = LoopPublisher(camera_info_topic, CameraInfo)
        self.static_tf = tf2_ros.StaticTransformBroadcaster()
        self.static_tf.sendTransform(camera_transform(model))

    def take(self, work) -> None:
        """Finish and publish one picture."""
        slot, stamp, x, y, yaw, bodies = work
        stamp = rospy.Time(*stamp)
        picture = self.pictures[slot]
        self.bodies.draw(picture, x, y, yaw, [box_of(Body(*body)) for body in bodies])
        self.camera_info.header.stamp = stamp
        self.camera_info_publisher.publish(self.camera_info)
        self.image_publisher.publish(image_message(picture, stamp))


def box_of(body: Body) -> Box:
    """An obstacle as the camera draws it."""
    return Box(body.x_m, body.y_m, body.yaw_rad, body.length_m, body.width_m, body.height_m,
               tuple(round(255 * share) for share in reversed(COLOURS[body.kind])), body.kind)


def main():
    """Serve until the painter closes or ends: an interrupt from the keyboard is the world's to hear."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    *arguments, socket_number = rospy.myargv(sys.argv)[1:]
    rospy.init_node("front_camera", disable_signals=True)
    serve(int(socket_number), Photographer(*arguments).take)


if __name__ == "__main__":
    main()
