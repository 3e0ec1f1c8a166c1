#!/usr/bin/python3
"""The camera node's window: it shows the picture, F shows the lane mask, Q closes it."""

import contextlib
import os
import subprocess
import unittest

import numpy as np
import rospy
import rostest
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

from sdc_common.processes import wait_until
from sdc_testing import MessageListener, wait_for_subscriber
from sdc_testing.virtual_display import VirtualDisplay

TITLE = "camera: F"
LIMIT_S = 40.0


class CameraWindowTest(unittest.TestCase):
    def setUp(self):
        self.picture = rospy.Publisher(
            "/carla/ego_vehicle/camera/rgb/front/image_color", Image, queue_size=1
        )
        self.mask = MessageListener("/camera/lane_mask", Image)
        road = np.full((480, 640, 4), (60, 90, 30, 255), np.uint8)
        road[:, 300:310] = 255
        self.message = CvBridge().cv2_to_imgmsg(road, "bgra8")

    def launch(self, environment):
        process = subprocess.Popen(["roslaunch", "sdc_package", "camera.launch"], env=environment)
        self.addCleanup(process.wait, LIMIT_S)
        self.addCleanup(process.terminate)
        wait_for_subscriber(self.picture, LIMIT_S)
        self.mask.wait_for_publisher(LIMIT_S)

    def wait_for_mask(self):
        """Publish the picture until a mask arrives."""
        seen = len(self.mask.messages)

        def is_answered():
            self.picture.publish(self.message)
            return len(self.mask.messages) > seen

        wait_until(is_answered, LIMIT_S, "a mask")

    def wait_for_pixel(self, display, colour, what):
        """Publish the picture until a pixel of the window has a colour; return its contents."""

        def has_colour():
            self.picture.publish(self.message)
            with contextlib.suppress(LookupError):  # A window may be replaced while it opens.
                shown = display.picture(display.windows(TITLE)[0])
                return [shown] if np.abs(shown[400, 100].astype(int) - colour).max() < 8 else []

        return wait_until(has_colour, LIMIT_S, what)[0]

    def test_keys_switch_and_close_the_window(self):
        with VirtualDisplay(800, 600) as display:
            self.launch(display.environment)
            self.wait_for_pixel(display, (60, 90, 30), "the camera's picture")
            display.focus(TITLE)
            display.xdotool("key", "f")
            mask = self.wait_for_pixel(display, (0, 0, 0), "the lane mask")
            self.assertGreater(mask[400, 295:315].max(), 200, "the mask contains the line")
            display.xdotool("key", "f")
            self.wait_for_pixel(display, (60, 90, 30), "the camera's picture again")
            display.xdotool("key", "q")
            wait_until(lambda: not display.windows(TITLE), LIMIT_S, "the end of the window")
            self.wait_for_mask()

    def test_mask_is_published_without_a_display(self):
        self.launch({name: value for name, value in os.environ.items() if name != "DISPLAY"})
        self.wait_for_mask()


if __name__ == "__main__":
    rospy.init_node("camera_window_test")
    rostest.rosrun("sdc_package", "camera_window_test", CameraWindowTest)
