#!/usr/bin/env python3
"""Publish a waypoint file as the mission, for a world without a mission planner."""

import rospy
from sdc_msgs.msg import BaseWaypoint, Path

from sdc_common.ros.node import parameter, refuse, watch_connections
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints


def main():
    rospy.init_node("publish_route")
    try:
        waypoints = load_waypoints(parameter("waypoints_path"))
    except WaypointError as error:
        refuse(error)
    publisher = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)
    publisher.publish([BaseWaypoint(x, y) for x, y in waypoints.tolist()])
    watch_connections()
    rospy.spin()


if __name__ == "__main__":
    main()
