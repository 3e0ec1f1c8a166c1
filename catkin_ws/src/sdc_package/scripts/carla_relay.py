#!/usr/bin/env python3
"""CARLA relay: convert commands to the message of CARLA bridges from version 0.9.5 on."""

import rospy
from carla_msgs.msg import CarlaEgoVehicleControl
from sdc_common.ros.node import LoopPublisher, watch_connections
from sdc_package.msg import CarlaVehicleControl


class CarlaRelay:
    def __init__(self):
        rospy.init_node("carla_relay")
        self.publisher = LoopPublisher("~vehicle_control_cmd", CarlaEgoVehicleControl)
        rospy.Subscriber(
            "~stack_control_cmd",
            CarlaVehicleControl,
            self.on_command,
            queue_size=1,
            tcp_nodelay=True,
        )

    def on_command(self, command):
        # In lockstep the stamp of the header identifies the odometry that this command answers.
        self.publisher.publish(
            CarlaEgoVehicleControl(
                header=command.header,
                throttle=command.throttle,
                steer=command.steer,
                brake=command.brake,
                hand_brake=command.hand_brake,
                reverse=command.reverse,
                gear=-1 if command.reverse else 1,
                manual_gear_shift=False,
            )
        )

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    CarlaRelay().run()
