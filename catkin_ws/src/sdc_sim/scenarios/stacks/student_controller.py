#!/usr/bin/env python3
"""A first controller: pure pursuit and a proportional speed control. Its commands have no stamp.

It answers each path, or with the parameter `rate_hz` it runs a loop in simulated time.
"""

import math
import time

import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, LocalPath

LOOK_AHEAD_POINTS = 5  # waypoints are 1 m apart
WHEELBASE_M = 2.87
FULL_STEER_RAD = 0.8
MIN_THROTTLE = 0.32  # less throttle hardly moves the car


class StudentController:
    def __init__(self):
        rospy.init_node("student_controller")
        self.rate_hz = rospy.get_param("~rate_hz", 0.0)
        while self.rate_hz and rospy.Time.now().is_zero():
            time.sleep(0.01)
        self.path = []
        self.odometry = None
        self.publisher = rospy.Publisher(
            "/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl, queue_size=1
        )
        rospy.Subscriber("/planner/local_waypoints", LocalPath, self.on_path, queue_size=1)
        rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, self.on_odometry, queue_size=1)

    def on_path(self, path):
        self.path = path.waypoints
        if not self.rate_hz:
            self.control()

    def on_odometry(self, odometry):
        self.odometry = odometry

    def control(self):
        odometry = self.odometry
        if not self.path or odometry is None:
            return
        pose = odometry.pose.pose
        yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        speed = math.hypot(odometry.twist.twist.linear.x, odometry.twist.twist.linear.y)

        target = self.path[min(LOOK_AHEAD_POINTS, len(self.path) - 1)]
        x, y = target.x - pose.position.x, target.y - pose.position.y
        left = -math.sin(yaw) * x + math.cos(yaw) * y
        wheel = math.atan2(2.0 * WHEELBASE_M * left, max(x * x + y * y, 1.0))

        error = self.path[0].v - speed
        command = CarlaVehicleControl()
        command.steer = min(max(-wheel / FULL_STEER_RAD, -1.0), 1.0)
        if error > 0.0:
            command.throttle = min(MIN_THROTTLE + 0.2 * error, 1.0)
        else:
            command.brake = min(-0.3 * error, 1.0)
        self.publisher.publish(command)

    def run(self):
        if self.rate_hz:
            rospy.Timer(rospy.Duration(1.0 / self.rate_hz), lambda _event: self.control())
        rospy.spin()


if __name__ == "__main__":
    StudentController().run()
