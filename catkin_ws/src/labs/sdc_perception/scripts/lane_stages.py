#!/usr/bin/env python3
"""Lane stages: show what a stage of the lane detector makes of each picture."""

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image

from sdc_common.ros.node import parameter, refuse
from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.pictures import pixels_of
from sdc_common.ros.refusal import refusing
from sdc_package.camera_window import CameraWindow
from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_perception.paired_topics import CAMERA, EGO
from sdc_perception.stage_pictures import STAGES


class LaneStagesNode:
    def __init__(self):
        rospy.init_node("lane_stages")
        cv2.setNumThreads(1)
        try:
            self.settings = DetectorSettings.read(parameter)
        except (TypeError, ValueError) as error:
            refuse(f"config/lane_detector.yaml: {error}")
        stage = parameter("stage")
        if stage not in STAGES:
            refuse(f"stage: '{stage}' is none; choose one of {', '.join(STAGES)}")
        self.draw = STAGES[stage]
        self.detector = None
        self.pose = (0.0, 0.0, 0.0)
        self.bridge = CvBridge()
        self.window = CameraWindow(parameter("show_window"), False)

        self.publisher = rospy.Publisher("/perception/lane_overlay", Image, queue_size=1)
        rospy.Subscriber(f"{CAMERA}/camera_info", CameraInfo, self.on_camera_info)
        rospy.Subscriber(f"{EGO}/odometry", Odometry, self.on_odometry)
        options = {"queue_size": 1, "buff_size": 4 * 1024 * 1024}
        rospy.Subscriber(f"{CAMERA}/image_color", Image, self.on_image, **options)

    def on_camera_info(self, message):
        if self.detector is None:
            self.detector = LaneDetector(self.settings, np.array(message.K).reshape(3, 3))

    def on_odometry(self, message):
        with refusing(f"{EGO}/odometry"):
            self.pose = pose_and_speed(message)[:3]

    def on_image(self, message):
        if self.detector is None:
            return
        with refusing(f"{CAMERA}/image_color"):
            picture = pixels_of(message, "bgra8").copy()
            self.draw(picture, self.detector, self.pose)
            self.window.update(picture, picture[..., 3])
            self.publisher.publish(self.bridge.cv2_to_imgmsg(picture, "bgra8", message.header))

    def run(self):
        self.window.run()
        rospy.spin()


if __name__ == "__main__":
    LaneStagesNode().run()
