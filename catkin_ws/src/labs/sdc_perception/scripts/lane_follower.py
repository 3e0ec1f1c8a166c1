#!/usr/bin/env python3
"""Lane follower: answer each lane with a local path along it, with target speeds."""

import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import LocalPath, Waypoint
from sdc_perception.msg import Lane

from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.refusal import refusing
from sdc_perception.lane_following import FollowingSettings, lane_path, stopping_path
from sdc_perception.lane_tracker import TrackedLane
from sdc_perception.paired_topics import EGO, answer_together


class LaneFollowerNode:
    def __init__(self):
        rospy.init_node("lane_follower")
        try:
            self.settings = FollowingSettings.read(parameter)
        except (TypeError, ValueError) as error:
            refuse(f"config/lane_follower.yaml: {error}")

        topic = "/planner/local_waypoints"
        self.publisher = LoopPublisher(topic, LocalPath, latch=True)
        topics = (("/perception/lane", Lane), (f"{EGO}/odometry", Odometry))
        answer_together(topics, self.answer)

    def answer(self, message, odometry):
        with refusing("/perception/lane"):
            if message.confidence > 0.0:
                rows = lane_path(TrackedLane.of(message), self.settings)
            else:
                rospy.logwarn_throttle(5.0, "lane_follower: no lane in the picture, braking")
                rows = stopping_path(*pose_and_speed(odometry)[:3])
            self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    LaneFollowerNode().run()
