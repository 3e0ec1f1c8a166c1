#!/usr/bin/python3
"""The camera node publishes the lane mask of each picture, and refuses invalid pictures."""

import unittest

import numpy as np
import rospy
import rostest
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

from sdc_common.processes import wait_until
from sdc_testing import MessageListener, wait_for_subscriber


class CameraTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bridge = CvBridge()
        cls.picture = rospy.Publisher(
            "/carla/ego_vehicle/camera/rgb/front/image_color", Image, queue_size=10
        )
        cls.mask = MessageListener("/camera/lane_mask", Image)
        wait_for_subscriber(cls.picture)
        wait_until(cls.is_answered, what="the first mask")

    @classmethod
    def is_answered(cls):
        """Publish a picture; it may be lost, because connections open one after the other."""
        cls.picture.publish(cls.bridge.cv2_to_imgmsg(np.zeros((48, 64, 4), np.uint8), "bgra8"))
        return cls.mask.messages

    def mask_of(self, image, encoding):
        message = self.bridge.cv2_to_imgmsg(image, encoding)
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = "camera"
        self.picture.publish(message)
        answer = self.mask.wait_for(lambda mask: mask.header.stamp == message.header.stamp)
        self.assertEqual((answer.header.frame_id, answer.encoding), ("camera", "mono8"))
        return self.bridge.imgmsg_to_cv2(answer)

    def test_mask_contains_the_line(self):
        road = np.full((480, 640, 4), 90, np.uint8)
        road[:, 300:310] = 255
        mask = self.mask_of(road, "bgra8")
        self.assertEqual(mask.shape, (480, 640))
        self.assertTrue(mask[400, 290:320].any())
        self.assertFalse(mask[400, :280].any())

    def test_mask_of_a_uniform_picture_in_any_encoding_is_empty(self):
        self.assertFalse(self.mask_of(np.zeros((480, 640, 4), np.uint8), "bgra8").any())
        for encoding, channels in (("bgr8", 3), ("rgb8", 3), ("rgba8", 4)):
            self.assertFalse(
                self.mask_of(np.full((120, 160, channels), 90, np.uint8), encoding).any()
            )

    def test_invalid_pictures_are_refused(self):
        self.picture.publish(Image())
        self.picture.publish(
            Image(height=480, width=640, step=2560, encoding="bgra8", data=b"short")
        )
        self.picture.publish(Image(height=1, width=1, step=4, encoding="nonsense", data=b"1234"))
        self.assertFalse(self.mask_of(np.zeros((480, 640, 4), np.uint8), "bgra8").any())


if __name__ == "__main__":
    rospy.init_node("camera_test")
    rostest.rosrun("sdc_package", "camera", CameraTest)
