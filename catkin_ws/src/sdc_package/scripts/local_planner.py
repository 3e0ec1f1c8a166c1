#!/usr/bin/env python3
"""Local planner: answer each odometry with the path ahead and a target speed on each point."""

import numpy as np
import rospy
from carla_msgs.msg import CarlaTrafficLightInfoList, CarlaTrafficLightStatusList
from nav_msgs.msg import Odometry
from sdc_common.ros.node import LoopPublisher, every, parameter, refuse, watch_connections
from sdc_common.ros.refusal import refusing
from sdc_common.ros.speed_reason_publisher import SpeedReasonPublisher
from sdc_msgs.msg import LaneOffset, ObstacleArray
from sdc_package.lane_offset import LaneHold
from sdc_package.local_planner import LocalPlanner
from sdc_package.odometry import pose_and_speed
from sdc_package.planner_inputs import PlannerInputs
from sdc_package.planner_settings import PlannerSettings
from sdc_package.waypoint_search import WaypointSearch

# TODO 1: the messages that this node receives (Path) and publishes (LocalPath, Waypoint)
from sdc_package.msg import LocalPath, Path, Waypoint
# --------------------------------------------------------------------------------


class LocalPlannerNode:
    def __init__(self):
        # TODO 2 (given): register this program with ROS as the node "local_planner"
        rospy.init_node("local_planner")
        # ------------------------------------------------------------------------
        try:
            self.settings = PlannerSettings.read(parameter)
        except (TypeError, ValueError) as error:
            refuse(f"config/local_planner.yaml: {error}")
        self.lane = LaneHold() if parameter("hold_lane") else None
        self.speed = 0.0
        self.planner = None
        self.search = None
        self.inputs = inputs = PlannerInputs(self.answer, self.settings.traffic_lights)

        self.reasons = SpeedReasonPublisher()
        topic = "/planner/local_waypoints"
        self.publisher = LoopPublisher(topic, LocalPath, latch=True)
        # TODO 3: subscribe to the mission: on_mission receives it
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        # ------------------------------------------------------------------------
        if self.lane is not None:
            rospy.Subscriber("/camera/lane_offset", LaneOffset, self.on_lane_offset, queue_size=1)
        for topic, message_class, callback in (
            ("/carla/traffic_lights/info", CarlaTrafficLightInfoList, inputs.add_light_info),
            ("/carla/traffic_lights/status", CarlaTrafficLightStatusList, inputs.add_light_status),
            ("/carla/ego_vehicle/obstacles", ObstacleArray, inputs.add_obstacles),
            ("/carla/ego_vehicle/odometry", Odometry, inputs.add_odometry),
        ):
            rospy.Subscriber(topic, message_class, callback, queue_size=1, tcp_nodelay=True)

    def on_mission(self, path):
        with refusing("/planner/mission_waypoints"):
            # TODO 4: the mission as rows x, y of an array (until then: return)
            waypoints = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
            # --------------------------------------------------------------------
            with self.inputs.lock:
                self.follow_mission(waypoints)

    def on_lane_offset(self, message):
        with self.inputs.lock:
            self.lane.see(message.header.stamp, message.offset_m)

    def follow_mission(self, waypoints):
        """Plan along this mission, unless it is the present one."""
        if self.planner is not None and self.planner.is_for(waypoints):
            return
        planner = LocalPlanner(waypoints, self.settings, start_mps=self.speed)
        if self.planner is None:
            planner.resume(rospy.get_param("~route_s_m", -1.0))
        self.planner, self.search = planner, WaypointSearch(planner.route.points)
        self.inputs.start()

    def answer(self, odometry):
        """Plan the path ahead of the car that this odometry describes, and publish it."""
        with refusing("/carla/ego_vehicle/odometry"):
            # TODO 7: the car's pose, the next waypoint, the path from there (until then: return)
            x, y, yaw, speed = pose_and_speed(odometry)
            first = self.search.first_ahead(x, y)
            rows = self.planner.plan(first, x, y, yaw, self.inputs.obstacles)
            # --------------------------------------------------------------------
            self.speed = speed
            if self.lane is not None:
                rows = self.lane.moved(rows, odometry.header.stamp, self.planner.place)
            self.publish(self.planner.stop_for(self.inputs.traffic_lights, rows, speed))
            self.reasons.update(odometry.header.stamp, self.planner.reason)

    def publish(self, rows):
        # TODO 8: publish a LocalPath with one Waypoint for each row x, y, v (until then: pass)
        self.publisher.publish(LocalPath([Waypoint(x, y, v) for x, y, v in rows.tolist()]))
        # ------------------------------------------------------------------------

    def leave_place(self):
        """Leave the car's distance along the route to the next process, which roslaunch starts."""
        if self.planner is not None:
            rospy.set_param("~route_s_m", self.planner.s_m)

    def run(self):
        watch_connections()
        every(0.2, self.leave_place)
        rospy.spin()


if __name__ == "__main__":
    LocalPlannerNode().run()
