#!/usr/bin/env python3
"""Lane detector: find the lane in each picture of the front camera, and publish it."""

import rospy
from sdc_perception.msg import Lane

from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_perception.obstacle_detection import covered_boxes
from sdc_perception.obstacle_tracker import ObstacleSettings, body_finder
from sdc_perception.overlay import draw_lane
from sdc_perception.picture_detector import PictureDetectorNode


class LaneDetectorNode(PictureDetectorNode):
    def __init__(self):
        super().__init__("lane_detector", read_settings, "/perception/lane", Lane)

    def start(self, intrinsic):
        lane, bodies = self.settings
        self.finder = body_finder(bodies, intrinsic) if bodies else None
        return LaneDetector(lane, intrinsic)

    def find(self, image, pose, _time_s):
        covered = covered_boxes(self.finder.find(image)) if self.finder else ()
        return self.detector.detect(image, pose, covered)

    def message(self, lane):
        message = Lane()
        if lane is not None:
            message.offset_m = lane.offset_m
            message.heading_error_rad = lane.heading_error_rad
            message.curvature_1pm = lane.curvature_1pm
            message.confidence = lane.confidence
            message.visible_m = lane.visible_m
            message.first_m = lane.first_m
            message.x_m, message.y_m = lane.points_m.T
            message.curvatures_1pm = lane.curvatures_1pm
        return message

    def drawn(self, image, pose, lane):
        return draw_lane(image, self.detector.ground, pose, lane, self.detector.found)


def read_settings(parameter):
    """Return the settings of lane and bodies; without `bodies`, the detector knows none."""
    bodies = rospy.get_param("~bodies", None)
    lane = DetectorSettings.read(parameter)
    try:
        return lane, bodies and ObstacleSettings.read(bodies.__getitem__)
    except (TypeError, ValueError) as error:
        raise ValueError(f"bodies, from config/obstacle_detector.yaml: {error}") from error


if __name__ == "__main__":
    LaneDetectorNode().run()
