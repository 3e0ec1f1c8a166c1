#!/usr/bin/env python3
"""Simulate the world: move the car, publish waypoints, car and sensor, apply steering commands."""

import math
import sys
import threading

import rospy
from std_msgs.msg import Bool, Empty, UInt32
from um_msgs.msg import CarPosition, SteeringCommand, Waypoint, Waypoints

from world.rules import read_settings
from world.simulation import Simulation


class World:
    def __init__(self):
        # Parameters
        self.settings = read_settings(rospy.get_param("~", {}))

        # State. ROS runs callbacks in several threads: the lock protects the simulation.
        self.simulation = Simulation(self.settings)
        self.lock = threading.Lock()

        # Publishers
        latched = {"queue_size": 1, "latch": True, "tcp_nodelay": True}
        fast = {"queue_size": 10, "tcp_nodelay": True}
        self.waypoints_pub = rospy.Publisher("/world_waypoints", Waypoints, **latched)
        self.car_pub = rospy.Publisher("/car_position", CarPosition, **fast)
        self.sensed_pub = rospy.Publisher("/sensed_waypoints", Waypoints, **fast)
        self.laps_pub = rospy.Publisher("/lap_count", UInt32, **latched)
        self.paused_pub = rospy.Publisher("/paused", Bool, **latched)
        self.publish_waypoints()
        self.publish_state()

        # Subscribers
        rospy.Subscriber("/cmd", SteeringCommand, self.on_cmd, **fast)
        rospy.Subscriber("~place_car", CarPosition, self.on_place_car, queue_size=10)
        rospy.Subscriber("~add_waypoint", Waypoint, self.on_add_waypoint, queue_size=10)
        rospy.Subscriber("~pause", Bool, self.on_pause, queue_size=10)
        rospy.Subscriber("~reset", Empty, self.on_reset, queue_size=10)

    # Callbacks
    def on_cmd(self, msg):
        self.apply("/cmd", self.simulation.steer, msg.delta_direction)

    def on_place_car(self, msg):
        self.apply("~place_car", self.simulation.place_car, msg.x, msg.y, msg.direction)

    def on_add_waypoint(self, msg):
        if self.apply("~add_waypoint", self.simulation.add_waypoint, msg.x, msg.y):
            self.publish_waypoints()

    def on_pause(self, msg):
        with self.lock:
            self.simulation.is_paused = msg.data
            self.publish_state()

    def on_reset(self, _msg):
        with self.lock:
            self.simulation.reset()
            self.publish_state()
        self.publish_waypoints()

    def apply(self, topic, action, *values):
        try:
            if not all(map(math.isfinite, values)):
                raise ValueError(f"{values} is not finite; send numbers")
            with self.lock:
                action(*values)
            return True
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"refused a message on {topic}: {error}")
            return False

    # Publishing
    def publish_waypoints(self, _event=None):
        with self.lock:
            self.waypoints_pub.publish(to_message(self.simulation.waypoints))

    def publish_state(self):
        self.laps_pub.publish(self.simulation.lap_counter.laps)
        self.paused_pub.publish(self.simulation.is_paused)

    def publish_car(self):
        # Sensor before position: a driver that answers a position then has its sensor data.
        self.sensed_pub.publish(to_message(self.simulation.sensed()))
        self.car_pub.publish(*self.simulation.car)

    # Run
    def tick(self, _event):
        try:
            with self.lock:
                if self.simulation.tick(1.0 / self.settings.rate):
                    self.publish_state()
                    rospy.loginfo(f"lap {self.simulation.lap_counter.laps} completed")
                self.publish_car()
        except rospy.ROSException:
            # ROS closes the topics at shutdown, possibly in the middle of a tick.
            if not rospy.core.is_shutdown_requested():
                raise

    def run(self):
        # Publish only in timer threads: Ctrl-C interrupts the main thread, maybe inside a lock.
        rospy.Timer(rospy.Duration.from_sec(self.settings.waypoints_period), self.publish_waypoints)
        rospy.Timer(rospy.Duration.from_sec(1.0 / self.settings.rate), self.tick)
        rospy.spin()


def to_message(waypoints):
    return Waypoints([Waypoint(x=point.x, y=point.y, idx=point.idx) for point in waypoints])


if __name__ == "__main__":
    rospy.init_node("world")
    try:
        World().run()
    except ValueError as error:
        rospy.logfatal(str(error))
        sys.exit(1)
