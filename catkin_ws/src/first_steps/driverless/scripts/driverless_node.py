#!/usr/bin/env python3
"""The driver: answers each position of the car with a steering command towards the next waypoint."""

import sys
import threading

import rospy
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from driverless.driver import Driver
from driverless.settings import SettingsError, read_settings


class Driverless:
    def __init__(self):
        # Parameters
        self.settings = read_settings(rospy.get_param("~", {}))

        # State; callbacks run in threads of their own, so each takes the lock before it touches the driver
        self.driver = Driver(self.settings)
        self.lock = threading.Lock()
        self.target = None

        # Publishers
        self.cmd_pub = rospy.Publisher("/cmd", SteeringCommand, queue_size=1, tcp_nodelay=True)
        self.target_pub = rospy.Publisher("/target_waypoint", Waypoint, queue_size=10, latch=True)

        # Subscribers
        if self.settings.use_map:
            rospy.Subscriber(
                "/world_waypoints",
                Waypoints,
                self.on_world_waypoints,
                queue_size=1,
                tcp_nodelay=True,
            )
        rospy.Subscriber(
            "/sensed_waypoints", Waypoints, self.on_sensed_waypoints, queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber(
            "/car_position", CarPosition, self.on_car_position, queue_size=1, tcp_nodelay=True
        )

    # Callbacks
    def on_world_waypoints(self, msg):
        self.take("/world_waypoints", self.driver.set_map, msg)

    def on_sensed_waypoints(self, msg):
        self.take("/sensed_waypoints", self.driver.set_sensed, msg)

    def take(self, topic, action, msg):
        try:
            with self.lock:
                action([(waypoint.idx, waypoint.x, waypoint.y) for waypoint in msg.waypoints])
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"refused a message on {topic}: {error}")

    def on_car_position(self, msg):
        try:
            with self.lock:
                turn, target = self.driver.step(msg.x, msg.y, msg.direction)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"refused a message on /car_position: {error}")
            return
        try:
            self.publish(turn, target)
        except rospy.ROSException:
            if (
                not rospy.core.is_shutdown_requested()
            ):  # on the way out the topics are closed already
                raise

    # Publishing
    def publish(self, turn, target):
        self.cmd_pub.publish(delta_direction=turn)
        if target is not None and target != self.target:
            self.target_pub.publish(x=target.x, y=target.y, idx=target.idx)
        self.target = target

    # Run
    def run(self):
        rospy.spin()


if __name__ == "__main__":
    rospy.init_node("driverless")
    try:
        Driverless().run()
    except SettingsError as error:
        rospy.logfatal(str(error))
        sys.exit(1)
