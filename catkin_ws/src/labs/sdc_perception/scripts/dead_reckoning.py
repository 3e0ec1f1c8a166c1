#!/usr/bin/env python3
"""Dead reckoning: publish the odometry that wheel speeds and yaw rate give."""

import math

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState

from sdc_common.ros.conversion import rear_axle_speed
from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import odometry_message
from sdc_common.ros.refusal import refusing
from sdc_common.validation import check_positive
from sdc_perception.dead_reckoning import DeadReckoning
from sdc_perception.paired_topics import EGO, answer_together


class DeadReckoningNode:
    def __init__(self):
        rospy.init_node("dead_reckoning")
        self.wheel_radius_m = parameter("wheel_radius_m")
        try:
            check_positive(wheel_radius_m=self.wheel_radius_m)
            self.motion = DeadReckoning(parameter("rear_m"), parameter("rear_compliance"))
        except (TypeError, ValueError) as error:
            refuse(f"config/dead_reckoning.yaml: {error}")
        self.last_stamp = None

        self.publisher = LoopPublisher(f"{EGO}/odometry", Odometry, latch=True)
        topics = ((f"{EGO}/imu", Imu), (f"{EGO}/wheel_speeds", JointState))
        answer_together(topics, self.answer)

    def answer(self, imu, wheels):
        with refusing("the topics of IMU and wheel speeds"):
            speed = rear_axle_speed(wheels.name, wheels.velocity, self.wheel_radius_m)
            if not math.isfinite(imu.angular_velocity.z):
                raise ValueError("the yaw rate is not finite")
            stamp = wheels.header.stamp
            step_s = (stamp - self.last_stamp).to_sec() if self.last_stamp else 0.0
            self.last_stamp = stamp
            self.motion.update(speed, imu.angular_velocity.z, step_s)
            pose = (self.motion.x_m, self.motion.y_m, self.motion.yaw_rad)
            twist = (self.motion.speed_mps, self.motion.lateral_mps, self.motion.yaw_rate_radps)
            self.publisher.publish(odometry_message(stamp, pose, twist))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    DeadReckoningNode().run()
