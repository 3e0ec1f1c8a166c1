#!/usr/bin/env python3
"""Steering network: answer each picture of the front camera with an arc as the local path."""

import os

import cv2
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import LocalPath, Waypoint
from sensor_msgs.msg import Image

from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.pictures import pixels_of
from sdc_common.ros.refusal import refusing
from sdc_perception.imitation_samples import arc_path, road_view
from sdc_perception.paired_topics import CAMERA, EGO, answer_together


class SteeringNetworkNode:
    def __init__(self):
        rospy.init_node("steering_network")
        cv2.setNumThreads(1)
        self.network = self.read_network(os.path.expanduser(parameter("network")))

        topic = "/planner/local_waypoints"
        self.publisher = LoopPublisher(topic, LocalPath, latch=True)
        topics = ((f"{CAMERA}/image_color", Image), (f"{EGO}/odometry", Odometry))
        answer_together(topics, self.answer)

    def read_network(self, path):
        if not os.path.isabs(path):
            refuse(
                f"config/steering_network.yaml: network must be an absolute path, got '{path}'; "
                'add perception_options:="{network: $PWD/network.npz}"'
            )
        try:
            # PyTorch is optional: only this node needs it.
            from sdc_perception.imitation_network import SteeringNetwork

            return SteeringNetwork.load(path)
        except (ImportError, ValueError) as error:
            refuse(error)

    def answer(self, image_message, odometry):
        with refusing("the topics of camera and odometry"):
            view = road_view(pixels_of(image_message, "bgra8"))
            pose = pose_and_speed(odometry)[:3]
            rows = arc_path(pose, self.network.answer(view)).astype(np.float32)
            self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    SteeringNetworkNode().run()
