#!/usr/bin/env python3
"""Global planner: publish the mission on a map from where the car is to its goals."""

import threading

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sdc_common.ros.node import parameter, refuse, watch_connections
from sdc_common.ros.refusal import refusing
from sdc_map.lane_graph import NoRouteError
from sdc_map.network_file import MapError, load_network
from sdc_msgs.srv import CloseLane, CloseLaneResponse
from sdc_map.global_planner import GlobalPlanner
from sdc_package.msg import BaseWaypoint, LocalPath, Path, Waypoint
from sdc_package.odometry import pose_and_speed


class GlobalPlannerNode:
    def __init__(self):
        rospy.init_node("global_planner")
        try:
            self.planner = GlobalPlanner(load_network(parameter("map")), parameter("goals"))
        except (MapError, TypeError, ValueError) as error:
            refuse(error)
        self.lock = threading.Lock()
        topic = "/planner/mission_speed_limits"
        self.limits = rospy.Publisher(topic, LocalPath, queue_size=1, latch=True)
        topic = "/planner/mission_waypoints"
        self.mission = rospy.Publisher(topic, Path, queue_size=1, latch=True)
        rospy.Service("/planner/close_lane", CloseLane, self.on_close)
        rospy.Subscriber("/move_base_simple/goal", PoseStamped, self.on_goal, queue_size=1)
        topic = "/carla/ego_vehicle/odometry"
        rospy.Subscriber(topic, Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True)

    def on_goal(self, pose):
        goal = pose.pose.position.x, pose.pose.position.y
        with self.lock, refusing("/move_base_simple/goal"):
            self.planner.drive_to([goal])

    def on_close(self, request):
        with self.lock:
            try:
                self.planner.close(request.lane)
            except ValueError as error:
                return CloseLaneResponse(False, str(error))
        return CloseLaneResponse(True, f"lane {request.lane} is closed")

    def on_odometry(self, odometry):
        with self.lock, refusing("/carla/ego_vehicle/odometry"):
            x, y, yaw, _ = pose_and_speed(odometry)
            try:
                mission = self.planner.update(x, y, yaw, odometry.pose.pose.position.z)
            except NoRouteError as error:
                refuse(error)
            if self.planner.problem:
                text = f"global_planner: {self.planner.problem}; the last mission stays"
                rospy.logerr_throttle(1.0, text)
            if mission is not None:
                self.publish(mission)

    def publish(self, mission):
        points, limits = mission.points_m.tolist(), mission.limits_mps.tolist()
        self.limits.publish(LocalPath([Waypoint(x, y, v) for (x, y), v in zip(points, limits)]))
        self.mission.publish(Path([BaseWaypoint(x, y) for x, y in points]))
        rospy.loginfo(
            "global_planner: published a mission of %.0f m over %d lanes",
            *(mission.ends_m[-1], len(mission.lanes)),
        )

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    GlobalPlannerNode().run()
