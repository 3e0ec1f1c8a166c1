"""A node that finds something in the pictures of the front camera."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.pictures import pixels_of
from sdc_common.ros.refusal import refusing
from sdc_package.camera_window import CameraWindow
from sdc_perception.paired_topics import CAMERA, EGO, answer_together


class PictureDetectorNode:
    """A node that answers each picture of the front camera with what it finds, and draws it.

    Its detector is made at the first picture, which has the camera matrix. It has two methods:

    detect(image, pose, time_s) -> what is found
        in a picture (H, W, 4) BGRA uint8, with x [m], y [m] and yaw [rad] of the car in the frame
        of the odometry, and the time of the picture [s]
    drawn(image, pose, found) -> a BGR picture (H, W, 3) of it
    """

    def __init__(
        self,
        name: str,
        read: Callable[[Callable[[str], Any]], Any],
        topic: str,
        message_class: type,
        start: Callable[[Any, np.ndarray], Any],
        message: Callable[[Any], Any],
    ):
        """Start the node; it ends with one line if a parameter is not valid.

        Args:
            name: name of the node and of its file in config/
            read: returns the settings, given a function that returns a parameter
            topic: topic of what is found; that of the drawn picture has the ending _overlay
            message_class: class of its messages, which have a header
            start: returns the detector, given the settings and the camera matrix (3, 3) [px]
            message: returns the message of what is found, without its header
        """
        rospy.init_node(name)
        cv2.setNumThreads(1)
        try:
            self._settings = read(parameter)
        except (TypeError, ValueError) as error:
            refuse(f"config/{name}.yaml: {error}")
        self._start, self._message = start, message
        self._detector: Any = None
        self._bridge = CvBridge()
        self._show = parameter("show_window")
        self._window = CameraWindow(self._show, False)

        self._publisher = LoopPublisher(topic, message_class, latch=True)
        self._overlay_publisher = rospy.Publisher(f"{topic}_overlay", Image, queue_size=1)
        answer_together(
            (
                (f"{CAMERA}/image_color", Image),
                (f"{CAMERA}/camera_info", CameraInfo),
                (f"{EGO}/odometry", Odometry),
            ),
            self._answer,
        )

    def _answer(self, image_message: Image, camera_info: CameraInfo, odometry: Odometry) -> None:
        with refusing("the topics of camera and odometry"):
            image = pixels_of(image_message, "bgra8")
            if self._detector is None:
                self._detector = self._start(self._settings, np.array(camera_info.K).reshape(3, 3))
            header, pose = image_message.header, pose_and_speed(odometry)[:3]
            found = self._detector.detect(image, pose, header.stamp.to_sec())
            message = self._message(found)
            message.header.stamp = header.stamp
            message.header.frame_id = odometry.header.frame_id
            self._publisher.publish(message)
            if self._show or self._overlay_publisher.get_num_connections():
                self._draw(self._detector.drawn(image, pose, found), header)

    def _draw(self, picture: np.ndarray, header: Any) -> None:
        self._window.update(picture, np.zeros(picture.shape[:2], np.uint8))
        if self._overlay_publisher.get_num_connections():
            self._overlay_publisher.publish(self._bridge.cv2_to_imgmsg(picture, "bgr8", header))

    def run(self) -> None:
        """Answer pictures until the end of the node."""
        watch_connections()
        self._window.run()
        rospy.spin()
