#!/usr/bin/env python3
"""Publish the mission, the local path and the car in the form that RViz displays."""

import time
from collections import deque

import numpy as np
import rospy
from nav_msgs.msg import Path as DisplayedPath
from sensor_msgs.msg import NavSatFix
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.geometry.geodesy import map_from_geodetic
from sdc_common.ros.node import parameter, refuse, watch_connections
from sdc_common.ros.refusal import refusing
from sdc_sim.road.network_markings import world_markings
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.rviz_markers import (
    car_markers,
    fixes_marker,
    path_marker,
    road_markers,
    route_path,
)
from sdc_sim.ros.waypoint_messages import waypoint_rows

SHOWN_FIXES = 200


class Show:
    def __init__(self):
        rospy.init_node("show")
        self.full_speed_mps = parameter("full_speed_mps")
        path_rate_hz = parameter("path_rate_hz")
        if not (self.full_speed_mps > 0.0 and path_rate_hz > 0.0):
            refuse("config/show.yaml: full_speed_mps and path_rate_hz must be positive")
        self.path_period_s = 1.0 / path_rate_hz
        self.next_path_time = 0.0

        latched = {"queue_size": 1, "latch": True}
        self.route_publisher = rospy.Publisher("/show/route", DisplayedPath, **latched)
        self.road_publisher = rospy.Publisher("/show/road", MarkerArray, **latched)
        self.car_publisher = rospy.Publisher("/show/car", MarkerArray, **latched)
        self.path_publisher = rospy.Publisher("/show/local_path", Marker, queue_size=1)

        self.fixes = deque(maxlen=SHOWN_FIXES)
        self.fixes_publisher = rospy.Publisher("/show/gnss", Marker, queue_size=1, latch=True)
        for name in {bridge.sensors["gnss"].topic for bridge in BRIDGE_VERSIONS.values()}:
            topic = "/carla/ego_vehicle" + name
            rospy.Subscriber(topic, NavSatFix, self.on_fix, queue_size=10)

        rospy.Subscriber("/planner/mission_waypoints", rospy.AnyMsg, self.on_mission, queue_size=1)
        rospy.Subscriber("/planner/local_waypoints", rospy.AnyMsg, self.on_path, queue_size=1)

    def on_mission(self, path):
        with refusing("/planner/mission_waypoints"):
            route = np.array(waypoint_rows(path, "x", "y")).reshape(-1, 2)
            markers = road_markers(world_markings(route, rospy.get_param("/sim/map_path", "")))
            self.route_publisher.publish(route_path(route))
            self.road_publisher.publish(markers)

    def on_path(self, path):
        # A lockstep drive plans thousands of paths per second, more than RViz can draw.
        time_s = time.monotonic()
        if time_s < self.next_path_time:
            return
        self.next_path_time = time_s + self.path_period_s
        with refusing("/planner/local_waypoints"):
            rows = waypoint_rows(path, "x", "y", "v")
            self.path_publisher.publish(path_marker(rows, self.full_speed_mps))

    def on_fix(self, fix):
        if fix.status.status >= fix.status.STATUS_FIX:
            self.fixes.append(map_from_geodetic(fix.latitude, fix.longitude))
            self.fixes_publisher.publish(fixes_marker(self.fixes))

    def run(self):
        self.car_publisher.publish(car_markers())
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    Show().run()
