#!/usr/bin/env python3
"""Shows the drive in RViz: turns the mission, the local path and the car into what RViz displays."""

import time

import numpy as np
import rospy
from nav_msgs.msg import Path as DisplayedPath
from sdc_msgs.msg import LocalPath, Path
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.node import parameter, refuse
from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import road_markings
from sdc_sim.ros.rviz_markers import car_markers, path_marker, road_markers, route_path


class Show:
    def __init__(self):
        rospy.init_node("show")
        self.full_speed_mps = parameter("full_speed_mps")
        rate_hz = parameter("path_rate_hz")
        if not (self.full_speed_mps > 0.0 and rate_hz > 0.0):
            refuse("full_speed_mps and path_rate_hz must be positive; mend it in config/show.yaml")
        self.period_s = 1.0 / rate_hz

        self.path_due_at = 0.0

        self.route_publisher = rospy.Publisher(
            "/show/route", DisplayedPath, queue_size=1, latch=True
        )
        self.road_publisher = rospy.Publisher("/show/road", MarkerArray, queue_size=1, latch=True)
        self.car_publisher = rospy.Publisher("/show/car", MarkerArray, queue_size=1, latch=True)
        self.path_publisher = rospy.Publisher("/show/local_path", Marker, queue_size=1)

        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        rospy.Subscriber("/planner/local_waypoints", LocalPath, self.on_path, queue_size=1)

    def on_mission(self, path):
        route = np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2)
        try:
            road = Road(route)
        except ValueError as error:
            rospy.logwarn("show: refused the mission on /planner/mission_waypoints: %s", error)
            return
        self.route_publisher.publish(route_path(route))
        self.road_publisher.publish(road_markers(road_markings(road)))

    def on_path(self, path):
        now = time.monotonic()
        if now < self.path_due_at:
            return  # a lockstep drive plans thousands of paths a second: nobody could see them all
        self.path_due_at = now + self.period_s
        try:
            self.path_publisher.publish(
                path_marker(
                    [(point.x, point.y, point.v) for point in path.waypoints], self.full_speed_mps
                )
            )
        except ValueError as error:
            rospy.logwarn_throttle(
                1.0, f"show: refused a path on /planner/local_waypoints: {error}"
            )

    def run(self):
        self.car_publisher.publish(car_markers())
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    Show().run()
