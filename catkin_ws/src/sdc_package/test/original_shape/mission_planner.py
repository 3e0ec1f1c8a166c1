#!/usr/bin/env python3
"""A mission planner of the original's shape: all rows of a CSV file, published once."""

import csv

import rospy
from sdc_package.msg import BaseWaypoint, Path

rospy.init_node("mission_planner")
with open(rospy.get_param("~waypoints_path")) as file:
    points = [BaseWaypoint(float(row[0]), -float(row[1])) for row in csv.reader(file)]
publisher = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)
publisher.publish(Path(points))
rospy.spin()
