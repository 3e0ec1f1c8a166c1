#!/usr/bin/env python3
"""Obstacle detector: find cars, pedestrians and boxes in each picture, and publish them."""

import math

from sdc_msgs.msg import Obstacle, ObstacleArray

from sdc_perception.obstacle_detection import ObstacleSettings
from sdc_perception.obstacle_tracker import ObstacleTracker
from sdc_perception.picture_detector import PictureDetectorNode


def obstacles_message(bodies):
    return ObstacleArray(obstacles=list(map(obstacle_message, bodies)))


def obstacle_message(body):
    message = Obstacle(id=body.id, kind=body.kind, speed=body.speed_mps)
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y = body.x_m, body.y_m
    orientation.z, orientation.w = math.sin(0.5 * body.yaw_rad), math.cos(0.5 * body.yaw_rad)
    message.size.x, message.size.y = body.length_m, body.width_m
    return message


if __name__ == "__main__":
    PictureDetectorNode(
        "obstacle_detector",
        ObstacleSettings.read,
        "/perception/obstacles",
        ObstacleArray,
        ObstacleTracker,
        obstacles_message,
    ).run()
