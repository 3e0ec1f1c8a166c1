#!/usr/bin/env python3
"""Lane detector: find the lane in each picture of the front camera, and publish it."""

import rospy
from sdc_perception.msg import Lane

from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_perception.lane_tracker import NUMBERS
from sdc_perception.picture_detector import PictureDetectorNode


def read_settings(parameter):
    """Return the settings; without the parameter `bodies`, the detector knows none."""
    return DetectorSettings.read(parameter, rospy.get_param("~bodies", None))


def lane_message(lane):
    message = Lane()
    if lane is not None:
        for name in NUMBERS:
            setattr(message, name, getattr(lane, name))
        message.x_m, message.y_m = lane.points_m.T
        message.curvatures_1pm = lane.curvatures_1pm
    return message


if __name__ == "__main__":
    PictureDetectorNode(
        "lane_detector", read_settings, "/perception/lane", Lane, LaneDetector, lane_message
    ).run()
