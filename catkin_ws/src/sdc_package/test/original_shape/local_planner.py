#!/usr/bin/env python3
"""A local planner of the original's shape: ten waypoints at 10 m/s, ten times a second."""

import rospy
from nav_msgs.msg import Odometry
from scipy.spatial import KDTree
from sdc_package.msg import LocalPath, Path, Waypoint

newest = {}


def store(name):
    return lambda message: newest.__setitem__(name, message)


rospy.init_node("local_planner")
rospy.Subscriber("/planner/mission_waypoints", Path, store("mission"))
rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, store("odometry"))
publisher = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=1)
rate = rospy.Rate(10)
tree = None
while not rospy.is_shutdown():
    if len(newest) == 2:
        points = newest["mission"].waypoints
        tree = tree or KDTree([(point.x, point.y) for point in points])
        place = newest["odometry"].pose.pose.position
        nearest = tree.query((place.x, place.y))[1]
        before = points[max(nearest - 1, 0)]
        here = points[nearest]
        along = (here.x - before.x) * (place.x - here.x) + (here.y - before.y) * (place.y - here.y)
        first = nearest + (along > 0.0)
        ahead = points[first : first + 10]
        publisher.publish(LocalPath([Waypoint(x=one.x, y=one.y, v=10.0) for one in ahead]))
    rate.sleep()
