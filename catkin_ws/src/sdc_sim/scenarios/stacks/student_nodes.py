#!/usr/bin/env python3
"""The first nodes of a student, whose messages have no stamp: student_nodes.py plan or control.

They answer each message, or with the parameter `rate_hz` they run a loop in simulated time.
"""

import math
import sys
import time

import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, LocalPath, Path, Waypoint

PATH_POINTS = 15
SPEED_MPS = 6.0
BRAKING_MPS2 = 1.5
LOOK_AHEAD_POINTS = 5  # waypoints are 1 m apart
WHEELBASE_M = 2.87
FULL_STEER_RAD = 0.8
MIN_THROTTLE = 0.32  # less throttle hardly moves the car


class StudentPlanner:
    """The next waypoints at a constant speed, slower near the end."""

    def __init__(self):
        self.waypoints = []
        self.next = 0
        self.publisher = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=1)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission)

    def on_mission(self, path):
        self.waypoints = path.waypoints

    def answer(self, odometry):
        car = odometry.pose.pose.position
        ahead = self.waypoints[self.next : self.next + 2 * PATH_POINTS]
        if not ahead:
            return
        distances = [math.hypot(point.x - car.x, point.y - car.y) for point in ahead]
        self.next += distances.index(min(distances))
        path = LocalPath()
        for number in range(self.next, min(self.next + PATH_POINTS, len(self.waypoints))):
            # Waypoints are 1 m apart; the car stops at the last but one.
            remaining_m = max(len(self.waypoints) - 2 - number, 0)
            speed = min(SPEED_MPS, math.sqrt(2.0 * BRAKING_MPS2 * remaining_m))
            point = self.waypoints[number]
            path.waypoints.append(Waypoint(point.x, point.y, speed))
        self.publisher.publish(path)


class StudentController:
    """Pure pursuit and a proportional speed control."""

    def __init__(self):
        self.publisher = rospy.Publisher(
            "/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl, queue_size=1
        )

    def answer(self, odometry, path):
        pose = odometry.pose.pose
        yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        speed = math.hypot(odometry.twist.twist.linear.x, odometry.twist.twist.linear.y)

        target = path.waypoints[min(LOOK_AHEAD_POINTS, len(path.waypoints) - 1)]
        x, y = target.x - pose.position.x, target.y - pose.position.y
        left = -math.sin(yaw) * x + math.cos(yaw) * y
        wheel = math.atan2(2.0 * WHEELBASE_M * left, max(x * x + y * y, 1.0))

        error = path.waypoints[0].v - speed
        command = CarlaVehicleControl()
        command.steer = min(max(-wheel / FULL_STEER_RAD, -1.0), 1.0)
        if error > 0.0:
            command.throttle = min(MIN_THROTTLE + 0.2 * error, 1.0)
        else:
            command.brake = min(-0.3 * error, 1.0)
        self.publisher.publish(command)


def main():
    rospy.init_node("student_nodes")
    rate_hz = rospy.get_param("~rate_hz", 0.0)
    while rate_hz and rospy.Time.now().is_zero():
        time.sleep(0.01)
    plans = sys.argv[1] == "plan"
    node = StudentPlanner() if plans else StudentController()
    last = {}

    def answer(_event=None):
        if "odometry" in last and (plans or "path" in last):
            node.answer(**last)

    def on_message(message, name):
        last[name] = message
        # The last input of a tick is the odometry for the planner, the path for the controller.
        if not rate_hz and (plans or name == "path"):
            answer()

    if not plans:
        rospy.Subscriber("/planner/local_waypoints", LocalPath, on_message, "path", queue_size=1)
    rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, on_message, "odometry", queue_size=1)
    if rate_hz:
        rospy.Timer(rospy.Duration(1.0 / rate_hz), answer)
    rospy.spin()


if __name__ == "__main__":
    main()
