#!/usr/bin/env python3
"""A controller of the original's shape: ten commands a second without stamps, steer in rad."""

import math

import rospy
import tf
from nav_msgs.msg import Odometry
from pid import PID
from sdc_package.msg import CarlaVehicleControl, LocalPath

newest = {}


def store(name):
    return lambda message: newest.__setitem__(name, message)


rospy.init_node("simple_controller")
publisher = rospy.Publisher(
    "/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl, queue_size=2
)
rospy.Subscriber("/planner/local_waypoints", LocalPath, store("path"))
rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, store("odometry"))
rate = rospy.Rate(10)
pid = PID(0.8, 0.3)
while not rospy.is_shutdown():
    if len(newest) == 2:
        pose, twist = newest["odometry"].pose.pose, newest["odometry"].twist.twist.linear
        turn = pose.orientation
        yaw = tf.transformations.euler_from_quaternion((turn.x, turn.y, turn.z, turn.w))[2]
        speed = math.hypot(twist.x, twist.y)
        first, second = newest["path"].waypoints[:2]
        step_x, step_y = second.x - first.x, second.y - first.y
        heading = math.remainder(math.atan2(step_y, step_x) - yaw, 2.0 * math.pi)
        left = step_x * (pose.position.y - first.y) - step_y * (pose.position.x - first.x)
        wheel = heading - math.atan2(1.5 * left / math.hypot(step_x, step_y), speed + 0.04)
        command = CarlaVehicleControl()
        command.throttle = pid.step(first.v - speed, 0.1)
        command.steer = -min(max(wheel, -1.22), 1.22)
        publisher.publish(command)
    rate.sleep()
