#!/usr/bin/env python3
"""A first local planner: the next waypoints at a constant speed, slower near the end.

It answers each odometry, or with the parameter `rate_hz` it runs a loop in simulated time.
"""

import math
import time

import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import LocalPath, Path, Waypoint

PATH_POINTS = 15
SPEED_MPS = 6.0
BRAKING_MPS2 = 1.5


class StudentPlanner:
    def __init__(self):
        rospy.init_node("student_planner")
        self.rate_hz = rospy.get_param("~rate_hz", 0.0)
        while self.rate_hz and rospy.Time.now().is_zero():
            time.sleep(0.01)
        self.car = None
        self.waypoints = []
        self.next = 0
        self.publisher = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=1)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission)
        rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, self.on_odometry, queue_size=1)

    def on_mission(self, path):
        self.waypoints = path.waypoints

    def on_odometry(self, odometry):
        self.car = odometry.pose.pose.position
        if not self.rate_hz:
            self.plan()

    def plan(self):
        car = self.car
        ahead = self.waypoints[self.next : self.next + 2 * PATH_POINTS]
        if not ahead or car is None:
            return
        distances = [math.hypot(point.x - car.x, point.y - car.y) for point in ahead]
        self.next += distances.index(min(distances))
        self.publish()

    def publish(self):
        path = LocalPath()
        for number in range(self.next, min(self.next + PATH_POINTS, len(self.waypoints))):
            # Waypoints are 1 m apart; the car stops at the last but one.
            remaining_m = max(len(self.waypoints) - 2 - number, 0)
            speed = min(SPEED_MPS, math.sqrt(2.0 * BRAKING_MPS2 * remaining_m))
            point = self.waypoints[number]
            path.waypoints.append(Waypoint(point.x, point.y, speed))
        self.publisher.publish(path)

    def run(self):
        if self.rate_hz:
            rospy.Timer(rospy.Duration(1.0 / self.rate_hz), lambda _event: self.plan())
        rospy.spin()


if __name__ == "__main__":
    StudentPlanner().run()
