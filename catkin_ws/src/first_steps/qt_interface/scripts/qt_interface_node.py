#!/usr/bin/env python3
"""Show the field in a window, and publish what the user requests with mouse and keys."""

import os
import sys

import rospy
from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QApplication
from std_msgs.msg import Bool, Empty, UInt32
from um_msgs.msg import CarPosition, Waypoint, Waypoints

from qt_interface.field import Point
from qt_interface.settings import read_settings, read_world_sizes
from qt_interface.window import Window


class QtInterface(QObject):
    # ROS runs callbacks in its own threads, but only Qt's thread may use widgets: callbacks emit
    # this signal, and Qt makes the call (function, arguments) in its thread.
    call_requested = pyqtSignal(object, tuple)

    def __init__(self):
        super().__init__()
        # Parameters
        settings = read_settings(rospy.get_param("~", {}))

        # State
        self.window = Window(settings)
        self.field = self.window.field
        self.call_requested.connect(self.call)

        # Publishers
        newest = {"queue_size": 1, "tcp_nodelay": True}
        fast = {"queue_size": 10, "tcp_nodelay": True}
        self.place_pub = rospy.Publisher("world/place_car", CarPosition, **newest)
        self.add_pub = rospy.Publisher("world/add_waypoint", Waypoint, queue_size=10)
        self.pause_pub = rospy.Publisher("world/pause", Bool, queue_size=10)
        self.reset_pub = rospy.Publisher("world/reset", Empty, queue_size=10)
        self.field.car_dragged.connect(self.publish_place)
        self.field.waypoint_requested.connect(lambda x, y: self.add_pub.publish(x=x, y=y))
        self.window.pause_requested.connect(self.pause_pub.publish)
        self.window.reset_requested.connect(self.reset_pub.publish)

        # Subscribers
        rospy.Subscriber("/world_waypoints", Waypoints, self.on_world_waypoints, queue_size=1)
        rospy.Subscriber("/sensed_waypoints", Waypoints, self.on_sensed_waypoints, **newest)
        rospy.Subscriber("/target_waypoint", Waypoint, self.on_target_waypoint, queue_size=1)
        rospy.Subscriber("/car_position", CarPosition, self.on_car_position, **fast)
        rospy.Subscriber("/lap_count", UInt32, self.on_lap_count, queue_size=1)
        rospy.Subscriber("/paused", Bool, self.on_paused, queue_size=1)
        rospy.Subscriber("world/reset", Empty, self.on_reset, queue_size=1)
        rospy.on_shutdown(self.on_shutdown)

    @staticmethod
    def call(function, arguments):
        function(*arguments)

    # Callbacks
    def on_world_waypoints(self, msg):
        sizes = read_world_sizes(rospy.get_param("world", {}))
        self.call_requested.emit(self.field.set_world, (sizes, to_points(msg.waypoints)))

    def on_sensed_waypoints(self, msg):
        self.call_requested.emit(self.field.set_sensed, (to_points(msg.waypoints),))

    def on_target_waypoint(self, msg):
        self.call_requested.emit(self.field.set_target, tuple(to_points([msg])))

    def on_car_position(self, msg):
        self.call_requested.emit(self.window.set_car, (msg.x, msg.y, msg.direction))

    def on_lap_count(self, msg):
        self.call_requested.emit(self.window.legend.set_laps, (msg.data,))

    def on_paused(self, msg):
        self.call_requested.emit(self.window.set_paused, (msg.data,))

    def on_reset(self, _msg):
        self.call_requested.emit(self.field.trail.clear, ())

    def on_shutdown(self):
        self.call_requested.emit(self.window.close, ())

    # Publishing
    def publish_place(self, x, y):
        self.place_pub.publish(x=x, y=y, direction=self.field.pose[2])

    # Run
    def run(self):
        self.window.show()
        status = QApplication.exec_()
        # Stop the callbacks before Qt deletes the window.
        rospy.signal_shutdown("the window was closed")
        return status


def to_points(waypoints):
    return [Point(waypoint.idx, waypoint.x, waypoint.y) for waypoint in waypoints]


if __name__ == "__main__":
    rospy.init_node("qt_interface")
    if not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")):
        rospy.logfatal("there is no screen: set DISPLAY, or launch with headless:=true")
        sys.exit(1)
    application = QApplication(sys.argv[:1])
    try:
        node = QtInterface()
        status = node.run()
    except ValueError as error:
        rospy.logfatal(str(error))
        status = 1
    sys.exit(status)
