#!/usr/bin/env python3
# TODO 1 (line 1): the interpreter that shall run this file
# --------------------------------------------------------------------------------
"""Camera: shows the road and its lane markings, and publishes the filtered picture."""

import threading

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image

from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_common.ros.node import LoopPublisher, parameter, refuse
from sdc_common.ros.image_check import check_image
from sdc_common.ros.connection_watchdog import watch_connections


class Camera:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "camera"
        rospy.init_node("camera")
        # ------------------------------------------------------------------------
        cv2.setNumThreads(1)
        self.show_window = parameter("show_window")
        self.filter_shown = parameter("show_filter")
        try:
            self.lane_filter = LaneFilter(LaneFilterThresholds(**parameter("lane_filter")))
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/camera.yaml")

        self.bridge = CvBridge()
        self.lock = threading.Lock()
        self.picture = None

        self.publisher = LoopPublisher("/camera/lane_mask", Image)
        # TODO 3: listen to the front camera: every picture shall come to on_image
        rospy.Subscriber(
            "/carla/ego_vehicle/camera/rgb/front/image_color",
            Image,
            self.on_image,
            queue_size=1,
            buff_size=4 * 1024 * 1024,
            tcp_nodelay=True,
        )
        # ------------------------------------------------------------------------

    def on_image(self, message):
        try:
            check_image(message)
            # TODO 4: turn the message into a picture for OpenCV, and find the lane markings in it (until then: return)
            image = self.bridge.imgmsg_to_cv2(message, "bgra8")
            mask = self.lane_filter.mask(image)
            # --------------------------------------------------------------------
        except (CvBridgeError, TypeError, ValueError) as error:
            rospy.logwarn_throttle(
                1.0, f"camera: refused a picture on {message._connection_header['topic']}: {error}"
            )
            return
        self.publish(mask, message.header)
        if self.show_window:
            with self.lock:
                self.picture = np.dstack([mask] * 3) if self.filter_shown else image[:, :, :3]

    def publish(self, mask, header):
        if not self.publisher.get_num_connections():
            return
        picture = self.bridge.cv2_to_imgmsg(mask, "mono8")
        picture.header = header
        self.publisher.publish(picture)

    def run(self):
        watch_connections()
        if not self.show_window:
            rospy.spin()
            return
        from sdc_common.window import ImageWindow, NoDisplay  # only where there is a display

        try:
            window = ImageWindow("camera: F shows or hides the lane filter, Q closes")
        except NoDisplay as error:
            rospy.logwarn("camera: %s; going on without a window", error)
            rospy.spin()
            return
        while not rospy.is_shutdown() and not window.closed:
            with self.lock:
                picture = self.picture
            for key in window.show(picture):
                if key == "f":
                    self.filter_shown = not self.filter_shown
                elif key == "q":
                    window.close()
        window.close()
        rospy.spin()


if __name__ == "__main__":
    Camera().run()
