#!/usr/bin/env python3
"""Traffic follower: answer each lane with a path along it that obeys lights and obstacles."""

import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import ObstacleArray
from sdc_package.msg import LocalPath, Waypoint
from sdc_perception.msg import DetectedLights, Lane

from sdc_common.ros.conversion import detected_obstacles
from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.refusal import refusing
from sdc_perception.lane_following import FollowingSettings, lane_path, stopping_path
from sdc_perception.lane_tracker import TrackedLane
from sdc_perception.paired_topics import EGO, answer_together
from sdc_perception.traffic_following import TrafficFollower, TrafficSettings


class TrafficFollowerNode:
    def __init__(self):
        rospy.init_node("traffic_follower")
        try:
            self.settings = FollowingSettings.read(parameter)
            self.traffic = TrafficFollower(TrafficSettings.read(parameter))
        except (TypeError, ValueError) as error:
            refuse(f"config/traffic_follower.yaml: {error}")

        topic = "/planner/local_waypoints"
        self.publisher = LoopPublisher(topic, LocalPath, latch=True)
        topics = (
            ("/perception/lane", Lane),
            ("/perception/obstacles", ObstacleArray),
            ("/perception/traffic_lights", DetectedLights),
            (f"{EGO}/odometry", Odometry),
        )
        answer_together(topics, self.answer)

    def answer(self, lane, obstacles, lights, odometry):
        with refusing("the topics of lane, obstacles and traffic lights"):
            x, y, yaw, speed = pose_and_speed(odometry)
            if lane.confidence > 0.0:
                rows = lane_path(TrackedLane.of(lane), self.settings)
                bodies = detected_obstacles(obstacles)
                rows = self.traffic.limited(rows, (x, y, yaw), speed, bodies, lights.lights)
            else:
                rospy.logwarn_throttle(5.0, "traffic_follower: no lane in the picture, braking")
                rows = stopping_path(x, y, yaw)
            self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    TrafficFollowerNode().run()
