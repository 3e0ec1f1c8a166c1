#!/usr/bin/env python3
"""Obstacle detector: find cars, pedestrians and boxes in each picture, and publish them."""

import math

from sdc_msgs.msg import Obstacle, ObstacleArray

from sdc_perception.detection_overlay import draw_obstacles
from sdc_perception.obstacle_tracker import ObstacleSettings, ObstacleTracker
from sdc_perception.picture_detector import PictureDetectorNode


class ObstacleDetectorNode(PictureDetectorNode):
    def __init__(self):
        topic = "/perception/obstacles"
        super().__init__("obstacle_detector", ObstacleSettings.read, topic, ObstacleArray)

    def start(self, intrinsic):
        return ObstacleTracker(self.settings, intrinsic)

    def find(self, image, pose, time_s):
        return self.detector.detect(image, pose, time_s)

    def message(self, bodies):
        return ObstacleArray(obstacles=list(map(obstacle_message, bodies)))

    def drawn(self, image, _pose, _bodies):
        return draw_obstacles(image, self.detector.seen)


def obstacle_message(body):
    message = Obstacle(id=body.id, kind=body.kind, speed=body.speed_mps)
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y = body.x_m, body.y_m
    orientation.z, orientation.w = math.sin(0.5 * body.yaw_rad), math.cos(0.5 * body.yaw_rad)
    message.size.x, message.size.y = body.length_m, body.width_m
    return message


if __name__ == "__main__":
    ObstacleDetectorNode().run()
