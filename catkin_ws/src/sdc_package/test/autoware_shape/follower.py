#!/usr/bin/env python3
"""A follower of autoware_mini's shape: pure pursuit, a target without a stamp for each odometry."""

import math

import numpy as np
import rospy
import tf
from ackermann_msgs.msg import AckermannDrive
from nav_msgs.msg import Odometry
from sdc_package.msg import Path


def follow(odometry):
    pose, speed = odometry.pose.pose, odometry.twist.twist.linear.x
    turn = pose.orientation
    yaw = tf.transformations.euler_from_quaternion((turn.x, turn.y, turn.z, turn.w))[2]
    away = np.hypot(*(points - (pose.position.x, pose.position.y)).T)
    nearest = int(np.argmin(away))
    target = AckermannDrive()
    if nearest < len(points) - 2:
        reach = max(6.0, 1.2 * speed)
        ahead = next((i for i in range(nearest, len(points)) if away[i] >= reach), -1)
        x, y = points[ahead] - (pose.position.x, pose.position.y)
        curvature = 2.0 * math.sin(math.atan2(y, x) - yaw) / away[ahead]
        target.steering_angle = math.atan(2.789 * curvature)
        # Below 1 m/s it stops.
        braking = math.sqrt(2.0 * np.hypot(*np.diff(points[nearest:], axis=0).T).sum())
        target.speed = min(8.0, braking) if braking >= 1.0 else 0.0
    publisher.publish(target)


rospy.init_node("follower")
mission = rospy.wait_for_message("/planner/mission_waypoints", Path).waypoints
points = np.array([(point.x, point.y) for point in mission])
publisher = rospy.Publisher(
    "/carla/ego_vehicle/ackermann_cmd", AckermannDrive, queue_size=1, tcp_nodelay=True
)
rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, follow, queue_size=1, tcp_nodelay=True)
rospy.spin()
