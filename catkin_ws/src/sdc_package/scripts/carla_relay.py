#!/usr/bin/env python3
"""Relay: gives the controller's commands to a CARLA bridge from 0.9.5 on, which takes another message."""

import rospy
from carla_msgs.msg import CarlaEgoVehicleControl
from sdc_package.msg import CarlaVehicleControl

from sdc_common.ros.connection_watchdog import watch_connections


class CarlaRelay:
    def __init__(self):
        rospy.init_node("carla_relay")
        self.publisher = rospy.Publisher(
            "~vehicle_control_cmd", CarlaEgoVehicleControl, queue_size=1
        )
        rospy.Subscriber(
            "~stack_control_cmd",
            CarlaVehicleControl,
            self.on_command,
            queue_size=1,
            tcp_nodelay=True,
        )

    def on_command(self, command):
        # The header goes on as it is: in lockstep its stamp says which tick the command answers.
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
