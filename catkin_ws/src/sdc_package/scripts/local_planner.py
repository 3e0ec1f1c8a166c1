#!/usr/bin/env python3
"""Local planner: answers every odometry with the road ahead of the car and a target speed on each of its points."""
import threading

import numpy as np
import rospy
from nav_msgs.msg import Odometry
# TODO 1: the messages that come in (Path, ObstacleArray) and go out (LocalPath, Waypoint)
from sdc_package.msg import LocalPath, ObstacleArray, Path, Waypoint
# --------------------------------------------------------------------------------

from sdc_package.figures import check_positive
from sdc_package.kept_state import KeptState
from sdc_package.node import LoopPublisher, parameter, refuse
from sdc_package.obstacles import Caution, Obstacle
from sdc_package.odometry import pose_and_speed, yaw_from_quaternion
from sdc_package.planning import LocalPlanner, SpeedLimits
from sdc_package.surroundings import watch_surroundings
from sdc_package.waypoint_search import WaypointSearch


class LocalPlannerNode:
    def __init__(self):
        # TODO 2: register this program with ROS as the node "local_planner"
        rospy.init_node("local_planner")
        # ------------------------------------------------------------------------
        try:
            self.limits = SpeedLimits(
                cruise_mps=parameter("planned_speed_mps"),
                lateral_mps2=parameter("lateral_acceleration_mps2"),
                acceleration_mps2=parameter("acceleration_mps2"),
                braking_mps2=parameter("braking_mps2"),
                lateral_jerk_mps3=parameter("lateral_jerk_mps3"))
            self.caution = Caution(**parameter("caution"))
            self.lookahead_m = parameter("lookahead_m")
            self.join_within_m = parameter("join_within_m")
            check_positive(lookahead_m=self.lookahead_m, join_within_m=self.join_within_m)
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/local_planner.yaml")

        self.lock = threading.Lock()
        self.planner = None
        self.kept = KeptState()
        self.search = None
        self.odometry = None
        self.answered_stamp = None
        self.obstacles = ()
        self.obstacles_stamp = rospy.Time(0)

        self.publisher = LoopPublisher("/planner/local_waypoints", LocalPath, latch=True)
        # TODO 3: listen to the mission: it shall come to on_mission
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        # ------------------------------------------------------------------------
        rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber("/carla/ego_vehicle/obstacles", ObstacleArray, self.on_obstacles, queue_size=1, tcp_nodelay=True)

    def on_mission(self, path):
        # TODO 4: the mission as rows x, y of an array (until then: return)
        waypoints = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
        # ------------------------------------------------------------------------
        try:
            planner = LocalPlanner(waypoints, self.limits, self.lookahead_m, self.join_within_m, self.caution)
        except ValueError as error:
            rospy.logerr("local_planner: refused the mission on /planner/mission_waypoints: %s", error)
            return
        with self.lock:
            if self.planner is not None and self.planner.is_for(waypoints):
                return  # a mission planner that was started again repeats its mission
            if planner.recall(self.kept.load()):
                rospy.logwarn("local_planner: was killed; looks for the car where it was, %.0f m along its route", planner.place.s_m)
            self.planner = planner
            self.search = WaypointSearch(planner.route.points)

    def on_odometry(self, odometry):
        with self.lock:
            # A simulator that waits for its first answer repeats its first odometry: one answer is enough.
            if self.planner is None or odometry.header.stamp == self.answered_stamp:
                return
            expects_obstacles = self.obstacles and self.odometry is None and self.obstacles_stamp < odometry.header.stamp
            self.odometry = odometry
            if not expects_obstacles:
                self.answer()

    def on_obstacles(self, message):
        """While there are obstacles, each odometry comes with the obstacles of its stamp, in whichever order."""
        with self.lock:
            try:
                self.obstacles = [Obstacle(body.pose.position.x, body.pose.position.y, yaw_from_quaternion(body.pose.orientation),
                                           body.size.x, body.size.y, body.speed) for body in message.obstacles]
            except ValueError as error:
                rospy.logwarn_throttle(1.0, f"local_planner: refused obstacles on /carla/ego_vehicle/obstacles: {error}")
            self.obstacles_stamp = message.header.stamp
            if self.odometry is not None and self.odometry.header.stamp <= self.obstacles_stamp:
                self.answer()

    def answer(self):
        odometry, self.odometry = self.odometry, None
        try:
            # TODO 7: where is the car, which waypoint is the first ahead of it, and what is the plan from there? (until then: return)
            x, y, yaw, _ = pose_and_speed(odometry)
            first = self.search.first_ahead(x, y)
            rows = self.planner.plan(first, x, y, yaw, self.obstacles)
            # --------------------------------------------------------------------
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"local_planner: no path for this /carla/ego_vehicle/odometry: {error}")
            return
        self.publish(rows)
        self.answered_stamp = odometry.header.stamp
        self.kept.save(self.planner.memory())

    def publish(self, rows):
        # TODO 8: a LocalPath with one Waypoint for each row x, y, v: publish it (until then: pass)
        self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))
        # ------------------------------------------------------------------------

    def run(self):
        watch_surroundings()
        rospy.spin()


if __name__ == "__main__":
    LocalPlannerNode().run()
