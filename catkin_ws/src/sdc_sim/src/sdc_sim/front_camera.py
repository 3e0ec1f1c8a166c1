"""Publishes the picture of the front camera, beside the loop that drives."""
from __future__ import annotations

import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from sdc_sim.background import Background
from sdc_sim.camera import Box, CameraModel, Renderer
from sdc_sim.messages import COLOURS, camera_info_message, camera_transform, image_message
from sdc_sim.road import Road
from sdc_sim.world import Snapshot


class FrontCamera:
    """Renders the Snapshots that it is shown; in lockstep every one of them, else those that it has time for."""

    def __init__(self, route_m, image_topic: str, camera_info_topic: str, every_frame: bool):
        model = CameraModel()
        self.renderer = Renderer(Road(route_m), model)
        self.camera_info = camera_info_message(model)
        self.image_publisher = rospy.Publisher(image_topic, Image, queue_size=2)
        self.camera_info_publisher = rospy.Publisher(camera_info_topic, CameraInfo, queue_size=2)
        self.static_tf = tf2_ros.StaticTransformBroadcaster()
        self.static_tf.sendTransform(camera_transform(model))
        work = Background(self.publish)
        self.show = work.put if every_frame else work.offer

    def publish(self, sensed: Snapshot) -> None:
        """Render and publish one Snapshot."""
        state = sensed.state
        stamp = rospy.Time(*sensed.stamp)
        picture = self.renderer.render(state.x_m, state.y_m, state.yaw_rad, boxes=boxes_of(sensed.bodies))
        self.image_publisher.publish(image_message(picture, stamp))
        self.camera_info.header.stamp = stamp
        self.camera_info_publisher.publish(self.camera_info)


def boxes_of(bodies) -> list:
    """The obstacles as the camera draws them."""
    return [Box(body.x_m, body.y_m, body.yaw_rad, body.length_m, body.width_m, body.height_m,
                tuple(round(255 * share) for share in reversed(COLOURS[body.kind])), body.kind) for body in bodies]
