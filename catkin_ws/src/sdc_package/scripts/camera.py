#!/usr/bin/env python3
# TODO 1 (line 1): the interpreter that runs this file
# --------------------------------------------------------------------------------
"""Camera: find the lane markings in the picture and the car's place in its lane; show both."""

import cv2
import rospy
from cv_bridge import CvBridge, CvBridgeError
from sdc_common.ros.conversion import check_image
from sdc_common.ros.node import parameter, refuse, watch_connections
from sdc_common.ros.refusal import refusing
from sdc_package.camera_window import CameraWindow
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_package.lane_offset import LaneFit
from sdc_msgs.msg import LaneOffset
from sensor_msgs.msg import Image


class Camera:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "camera"
        rospy.init_node("camera")
        # ------------------------------------------------------------------------
        cv2.setNumThreads(1)
        try:
            self.lane_filter = LaneFilter(LaneFilterThresholds(**parameter("lane_filter")))
            self.lane_offset = LaneFit(**parameter("lane_offset"))
        except (TypeError, ValueError) as error:
            refuse(f"config/camera.yaml: {error}")
        self.bridge = CvBridge()
        self.window = CameraWindow(parameter("show_window"), parameter("show_filter"))

        self.publisher = rospy.Publisher("/camera/lane_mask", Image, queue_size=1)
        self.offsets = rospy.Publisher("/camera/lane_offset", LaneOffset, queue_size=10)
        # TODO 3: subscribe to the front camera: on_image receives every picture
        topic = "/carla/ego_vehicle/camera/rgb/front/image_color"
        rospy.Subscriber(topic, Image, self.on_image, queue_size=1, buff_size=4 * 1024 * 1024)
        # ------------------------------------------------------------------------

    def on_image(self, message):
        with refusing(message._connection_header["topic"], CvBridgeError, TypeError):
            check_image(message)
            # TODO 4: convert the message to an image, and find the markings (until then: return)
            image = self.bridge.imgmsg_to_cv2(message, "bgra8")
            mask = self.lane_filter.mask(image)
            # --------------------------------------------------------------------
            self.window.update(image, mask)
            self.publish(mask, message.header)

    def publish(self, mask, header):
        if self.publisher.get_num_connections():
            self.publisher.publish(self.bridge.cv2_to_imgmsg(mask, "mono8", header))
        offset = self.lane_offset.measure(mask) if self.offsets.get_num_connections() else None
        if offset is not None:
            self.offsets.publish(header, offset)

    def run(self):
        watch_connections()
        self.window.run()
        rospy.spin()


if __name__ == "__main__":
    Camera().run()
