#!/usr/bin/env python3
"""Local planner: answers every odometry with the road ahead of the car and a target speed on each of its points."""
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import LocalPath, Path, Waypoint

from sdc_package.node import loop_publisher, parameter, refuse
from sdc_package.odometry import pose_and_speed
from sdc_package.planning import LocalPlanner, SpeedLimits


class LocalPlannerNode:
    def __init__(self):
        rospy.init_node("local_planner")
        try:
            self.limits = SpeedLimits(
                cruise_mps=parameter("planned_speed_mps"),
                lateral_mps2=parameter("lateral_acceleration_mps2"),
                acceleration_mps2=parameter("acceleration_mps2"),
                braking_mps2=parameter("braking_mps2"),
                lateral_jerk_mps3=parameter("lateral_jerk_mps3"))
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/local_planner.yaml")
        self.lookahead_m = parameter("lookahead_m")
        self.join_within_m = parameter("join_within_m")

        self.planner = None
        self.answered_stamp = None

        self.publisher = loop_publisher("/planner/local_waypoints", LocalPath, latch=True)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True)

    def on_mission(self, path):
        waypoints = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
        try:
            self.planner = LocalPlanner(waypoints, self.limits, self.lookahead_m, self.join_within_m)
        except ValueError as error:
            rospy.logerr("local_planner: refused the mission on /planner/mission_waypoints: %s", error)

    def on_odometry(self, odometry):
        # A simulator that waits for its first answer repeats its first odometry: one answer is enough.
        if self.planner is None or odometry.header.stamp == self.answered_stamp:
            return
        try:
            x, y, yaw, _ = pose_and_speed(odometry)
            rows = self.planner.plan(x, y, yaw)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"local_planner: no path for this /carla/ego_vehicle/odometry: {error}")
            return
        self.publish(rows)
        self.answered_stamp = odometry.header.stamp

    def publish(self, rows):
        self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))

    def run(self):
        rospy.spin()


if __name__ == "__main__":
    LocalPlannerNode().run()
