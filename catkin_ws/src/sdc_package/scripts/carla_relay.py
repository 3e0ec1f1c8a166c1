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
        asked = "~stack_control_cmd", CarlaVehicleControl, self.on_command
        rospy.Subscriber(*asked, queue_size=1, tcp_nodelay=True)

    def on_command(self, command):
        # In lockstep the stamp of the header identifies the odometry that this command answers.
        values = {name: getattr(command, name) for name in command.__slots__}
        gear = -1 if command.reverse else 1
        self.publisher.publish(CarlaEgoVehicleControl(**values, gear=gear))

    def run(self):
        watch_connections()
        rospy.spin()


if __name__ == "__main__":
    CarlaRelay().run()
