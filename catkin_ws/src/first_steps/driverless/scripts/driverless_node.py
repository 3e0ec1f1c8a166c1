#!/usr/bin/env python3
"""Drive: answer each position of the car with a steering command towards the next waypoint."""

import math
import sys
import threading

import rospy
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from driverless.driver import Driver
from world import waypoints
from world.rules import checked


class Driverless:
    def __init__(self):
        # Parameters
        self.settings = checked("driverless", rospy.get_param("~", {}))

        # State. ROS runs callbacks in several threads: the lock protects the driver.
        self.driver = Driver(self.settings)
        self.lock = threading.Lock()
        self.target = None

        # Publishers
        self.cmd_pub = rospy.Publisher("/cmd", SteeringCommand, queue_size=1, tcp_nodelay=True)
        self.target_pub = rospy.Publisher("/target_waypoint", Waypoint, queue_size=10, latch=True)

        # Subscribers
        newest = {"queue_size": 1, "tcp_nodelay": True}
        if self.settings.use_map:
            rospy.Subscriber("/world_waypoints", Waypoints, self.on_world_waypoints, **newest)
        rospy.Subscriber("/sensed_waypoints", Waypoints, self.on_sensed_waypoints, **newest)
        rospy.Subscriber("/car_position", CarPosition, self.on_car_position, **newest)

    # Callbacks
    def on_world_waypoints(self, msg):
        self.set_points("/world_waypoints", self.driver.set_map, msg)

    def on_sensed_waypoints(self, msg):
        self.set_points("/sensed_waypoints", self.driver.set_sensed, msg)

    def set_points(self, topic, action, msg):
        points = [waypoints.Waypoint(point.idx, point.x, point.y) for point in msg.waypoints]
        if is_finite(topic, *(number for _, x, y in points for number in (x, y))):
            with self.lock:
                action(points)

    def on_car_position(self, msg):
        if not is_finite("/car_position", msg.x, msg.y, msg.direction):
            return
        try:
            with self.lock:
                turn, target = self.driver.step(msg.x, msg.y, msg.direction)
            self.publish(turn, target)
        except rospy.ROSException:
            # ROS closes the topics at shutdown, possibly before this callback publishes.
            if not rospy.core.is_shutdown_requested():
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


def is_finite(topic, *numbers):
    if all(map(math.isfinite, numbers)):
        return True
    rospy.logwarn_throttle(1.0, f"refused a message on {topic}: a number is not finite")
    return False


if __name__ == "__main__":
    rospy.init_node("driverless")
    try:
        Driverless().run()
    except ValueError as error:
        rospy.logfatal(str(error))
        sys.exit(1)
