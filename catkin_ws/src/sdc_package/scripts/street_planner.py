#!/usr/bin/env python3
"""Street planner: answer each odometry with the path ahead on a map, by the rules of the road."""

import numpy as np
import rospy
from carla_msgs.msg import CarlaTrafficLightInfoList, CarlaTrafficLightStatusList
from nav_msgs.msg import Odometry
from sdc_common.driving import Observation
from sdc_common.ros.node import LoopPublisher, every, parameter, refuse, watch_connections
from sdc_common.ros.refusal import refusing
from sdc_common.ros.speed_reason_publisher import SpeedReasonPublisher
from sdc_msgs.msg import ObstacleArray
from sdc_package.street_settings import StreetSettings
from sdc_package.behaviour.street_planner import StreetPlanner
from sdc_package.msg import LocalPath, Path, Waypoint
from sdc_package.odometry import pose_and_speed
from sdc_package.planner_inputs import PlannerInputs
from sdc_map.network_file import load_network


class StreetPlannerNode:
    def __init__(self):
        # It takes the place of the node local_planner, with its parameters and those of streets.
        rospy.init_node("local_planner")
        if parameter("hold_lane"):
            refuse("config/local_planner.yaml: hold_lane is for a route; leave it out on a map")
        try:
            settings = StreetSettings.read(parameter)
            network = load_network(parameter("map"))
            self.inputs = PlannerInputs(self.answer, settings.planner.traffic_lights)
            self.planner = StreetPlanner(network, settings, self.inputs.traffic_lights)
        except (TypeError, ValueError) as error:
            refuse(f"config/local_planner.yaml, config/street_planner.yaml: {error}")
        self.waypoints = np.empty((0, 2))
        self.limits = np.empty((0, 3))  # rows x, y and limit of the road [m, m, m/s]
        self.speed = 0.0

        self.reasons = SpeedReasonPublisher()
        self.publisher = LoopPublisher("/planner/local_waypoints", LocalPath, latch=True)
        inputs = self.inputs
        for topic, message_class, callback in (
            ("/planner/mission_waypoints", Path, self.on_mission),
            ("/planner/mission_speed_limits", LocalPath, self.on_limits),
            ("/carla/traffic_lights/info", CarlaTrafficLightInfoList, inputs.add_light_info),
            ("/carla/traffic_lights/status", CarlaTrafficLightStatusList, inputs.add_light_status),
            ("/carla/ego_vehicle/obstacles", ObstacleArray, inputs.add_obstacles),
            ("/carla/ego_vehicle/odometry", Odometry, inputs.add_odometry),
        ):
            rospy.Subscriber(topic, message_class, callback, queue_size=1, tcp_nodelay=True)

    def on_mission(self, path):
        with self.inputs.lock, refusing("/planner/mission_waypoints"):
            rows = [(point.x, point.y) for point in path.waypoints]
            self.waypoints = np.array(rows).reshape(-1, 2)
            self.follow_mission()

    def on_limits(self, path):
        with self.inputs.lock, refusing("/planner/mission_speed_limits"):
            rows = [(point.x, point.y, point.v) for point in path.waypoints]
            self.limits = np.array(rows).reshape(-1, 3)
            self.follow_mission()

    def follow_mission(self):
        """Plan along the mission, after its speed limits have arrived."""
        if not (len(self.waypoints) and np.array_equal(self.limits[:, :2], self.waypoints)):
            return
        is_first = self.planner.s_m < 0.0
        self.planner.follow(self.waypoints, self.limits[:, 2], self.speed)
        if is_first:
            self.planner.resume(rospy.get_param("~route_s_m", -1.0))
        self.inputs.start()

    def answer(self, odometry):
        """Plan the path ahead of the car that this odometry describes, and publish it."""
        with refusing("/carla/ego_vehicle/odometry"):
            x, y, yaw, speed = pose_and_speed(odometry)
            self.speed = speed
            obstacles, lights = self.inputs.obstacles, self.inputs.traffic_lights.states
            stamp = odometry.header.stamp
            observation = Observation(stamp.to_nsec(), x, y, yaw, speed, obstacles, lights)
            observation.z_m = odometry.pose.pose.position.z
            path = self.planner.plan(observation)
            self.publisher.publish(LocalPath([Waypoint(*point) for point in path.points]))
            self.reasons.update(stamp, self.planner.reason, self.planner.detail)

    def leave_place(self):
        """Leave the car's distance along the route to the next process, which roslaunch starts."""
        if self.planner.s_m >= 0.0:
            rospy.set_param("~route_s_m", self.planner.s_m)

    def run(self):
        watch_connections()
        every(0.2, self.leave_place)
        rospy.spin()


if __name__ == "__main__":
    StreetPlannerNode().run()
