#!/usr/bin/env python3
"""Local planner: answers every odometry with the road ahead of the car and a target speed on each of its points."""

import threading

import numpy as np
import rospy
from nav_msgs.msg import Odometry

# TODO 1: the messages that come in (Path, ObstacleArray) and go out (LocalPath, Waypoint)
from sdc_package.msg import LocalPath, Path, Waypoint
from sdc_msgs.msg import ObstacleArray

# --------------------------------------------------------------------------------
from carla_msgs.msg import CarlaTrafficLightInfoList, CarlaTrafficLightStatusList

from sdc_common.validation import check_positive
from sdc_common.ros.checkpoint import Checkpoint
from sdc_common.ros.node import LoopPublisher, parameter, refuse
from sdc_package.obstacles import DetectedObstacle, ObstacleMargins
from sdc_package.odometry import pose_and_speed, yaw_from_quaternion
from sdc_package.local_planner import LocalPlanner
from sdc_common.planning.speed_profile import SpeedLimits
from sdc_common.ros.connection_watchdog import watch_connections
from sdc_package.traffic_lights import TrafficLightMargins, TrafficLightMonitor
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
                lateral_jerk_mps3=parameter("lateral_jerk_mps3"),
            )
            self.caution = ObstacleMargins(**parameter("caution"))
            self.lookahead_m = parameter("lookahead_m")
            self.join_within_m = parameter("join_within_m")
            check_positive(lookahead_m=self.lookahead_m, join_within_m=self.join_within_m)
            self.lights = TrafficLightMonitor(TrafficLightMargins(**parameter("traffic_lights")))
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/local_planner.yaml")

        self.lock = threading.Lock()
        self.planner = None
        self.kept = Checkpoint()
        self.search = None
        self.odometry = None
        self.answered_stamp = None
        self.obstacles = ()
        self.obstacles_stamp = rospy.Time(0)

        self.publisher = LoopPublisher("/planner/local_waypoints", LocalPath, latch=True)
        # TODO 3: listen to the mission: it shall come to on_mission
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        # ------------------------------------------------------------------------
        rospy.Subscriber(
            "/carla/ego_vehicle/obstacles",
            ObstacleArray,
            self.on_obstacles,
            queue_size=1,
            tcp_nodelay=True,
        )
        rospy.Subscriber(
            "/carla/traffic_lights/info",
            CarlaTrafficLightInfoList,
            self.on_light_places,
            queue_size=1,
        )
        rospy.Subscriber(
            "/carla/traffic_lights/status",
            CarlaTrafficLightStatusList,
            self.on_light_states,
            queue_size=1,
        )
        # The last: the world takes an answer for a sign that all the rest is listened to.
        rospy.Subscriber(
            "/carla/ego_vehicle/odometry",
            Odometry,
            self.on_odometry,
            queue_size=1,
            tcp_nodelay=True,
        )

    def on_mission(self, path):
        # TODO 4: the mission as rows x, y of an array (until then: return)
        waypoints = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
        # ------------------------------------------------------------------------
        try:
            planner = LocalPlanner(
                waypoints, self.limits, self.lookahead_m, self.join_within_m, self.caution
            )
        except ValueError as error:
            rospy.logerr(
                "local_planner: refused the mission on /planner/mission_waypoints: %s", error
            )
            return
        with self.lock:
            if self.planner is not None and self.planner.is_for(waypoints):
                return  # a mission planner that was started again repeats its mission
            if planner.recall(self.kept.load()):
                rospy.logwarn(
                    "local_planner: was killed; looks for the car where it was, %.0f m along its route",
                    planner.place.s_m,
                )
            self.planner = planner
            self.search = WaypointSearch(planner.route.points)

    def on_odometry(self, odometry):
        with self.lock:
            # A simulator that waits for its first answer repeats its first odometry: one answer is enough.
            if self.planner is None or odometry.header.stamp == self.answered_stamp:
                return
            one_waits_already = self.odometry is not None
            self.odometry = odometry
            if one_waits_already or self.all_heard():
                self.answer()

    def on_obstacles(self, message):
        with self.lock:
            try:
                self.obstacles = [
                    DetectedObstacle(
                        body.pose.position.x,
                        body.pose.position.y,
                        yaw_from_quaternion(body.pose.orientation),
                        body.size.x,
                        body.size.y,
                        body.speed,
                    )
                    for body in message.obstacles
                ]
            except ValueError as error:
                rospy.logwarn_throttle(
                    1.0,
                    f"local_planner: refused obstacles on /carla/ego_vehicle/obstacles: {error}",
                )
            self.lights.show(message.traffic_lights, stamped=True)
            self.obstacles_stamp = message.header.stamp
            if self.odometry is not None and self.all_heard():
                self.answer()

    def on_light_places(self, message):
        with self.lock:
            try:
                self.lights.place(message)
            except ValueError as error:
                rospy.logwarn_throttle(
                    1.0,
                    f"local_planner: refused traffic lights on /carla/traffic_lights/info: {error}",
                )

    def on_light_states(self, message):
        with self.lock:
            self.lights.show(message.traffic_lights, stamped=False)

    def all_heard(self):
        """While there are obstacles or traffic lights, each odometry comes with those of its stamp, in whichever order."""
        return (
            not (self.obstacles or self.lights.stamped)
            or self.obstacles_stamp >= self.odometry.header.stamp
        )

    def answer(self):
        odometry, self.odometry = self.odometry, None
        try:
            # TODO 7: where is the car, which waypoint is the first ahead of it, and what is the plan from there? (until then: return)
            x, y, yaw, _ = pose_and_speed(odometry)
            first = self.search.first_ahead(x, y)
            rows = self.planner.plan(first, x, y, yaw, self.obstacles)
            # --------------------------------------------------------------------
            rows = self.planner.stop_for(self.lights, rows, pose_and_speed(odometry)[3])
        except ValueError as error:
            rospy.logwarn_throttle(
                1.0, f"local_planner: no path for this /carla/ego_vehicle/odometry: {error}"
            )
            return
        self.publish(rows)
        self.answered_stamp = odometry.header.stamp
        self.kept.save(self.planner.memory())

    def publish(self, rows):
        # TODO 8: a LocalPath with one Waypoint for each row x, y, v: publish it (until then: pass)
        self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))
        # ------------------------------------------------------------------------

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    LocalPlannerNode().run()
