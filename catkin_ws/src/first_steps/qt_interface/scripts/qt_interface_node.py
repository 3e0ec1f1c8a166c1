#!/usr/bin/env python3
"""Show the field in a window, and publish what the user requests with mouse and keys."""

import os
import sys

import rospy
from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QApplication
from std_msgs.msg import Bool, Empty, UInt32
from um_msgs.msg import CarPosition, Waypoint, Waypoints

from qt_interface.scene import Scene
from qt_interface.settings import SettingsError, read_settings, read_world_sizes
from qt_interface.window import Window


class QtInterface(QObject):
    # ROS runs callbacks in its own threads, but only Qt's thread may use widgets: callbacks emit
    # these signals, which Qt delivers in its thread.
    world_received = pyqtSignal(object, object)
    sensed_received = pyqtSignal(object)
    target_received = pyqtSignal(object)
    car_received = pyqtSignal(float, float, float)
    laps_received = pyqtSignal(int)
    pause_received = pyqtSignal(bool)
    reset_received = pyqtSignal()
    shutdown_received = pyqtSignal()

    def __init__(self):
        super().__init__()
        # Parameters
        self.settings = read_settings(rospy.get_param("~", {}))

        # State
        self.scene = Scene(self.settings)
        self.window = Window(self.scene)

        # Publishers
        newest = {"queue_size": 1, "tcp_nodelay": True}
        self.place_pub = rospy.Publisher("world/place_car", CarPosition, **newest)
        self.add_pub = rospy.Publisher("world/add_waypoint", Waypoint, queue_size=10)
        self.pause_pub = rospy.Publisher("world/pause", Bool, queue_size=10)
        self.reset_pub = rospy.Publisher("world/reset", Empty, queue_size=10)
        self.connect_window()

        # Subscribers
        rospy.Subscriber("/world_waypoints", Waypoints, self.on_world_waypoints, queue_size=1)
        rospy.Subscriber("/sensed_waypoints", Waypoints, self.on_sensed_waypoints, **newest)
        rospy.Subscriber("/target_waypoint", Waypoint, self.on_target_waypoint, queue_size=1)
        fast = {"queue_size": 10, "tcp_nodelay": True}
        rospy.Subscriber("/car_position", CarPosition, self.on_car_position, **fast)
        rospy.Subscriber("/lap_count", UInt32, self.on_lap_count, queue_size=1)
        rospy.Subscriber(
            "/paused", Bool, lambda msg: self.pause_received.emit(msg.data), queue_size=1
        )
        rospy.Subscriber("world/reset", Empty, lambda _: self.reset_received.emit(), queue_size=1)
        rospy.on_shutdown(self.shutdown_received.emit)

    def connect_window(self):
        self.world_received.connect(self.scene.set_world)
        self.sensed_received.connect(self.scene.set_sensed)
        self.target_received.connect(self.scene.set_target)
        self.car_received.connect(self.window.set_car)
        self.laps_received.connect(self.window.set_laps)
        self.pause_received.connect(self.window.set_paused)
        self.reset_received.connect(self.window.clear_trail)
        self.shutdown_received.connect(self.window.close)
        self.window.car_dragged.connect(self.publish_place)
        self.window.waypoint_requested.connect(lambda x, y: self.add_pub.publish(x=x, y=y))
        self.window.pause_requested.connect(self.pause_pub.publish)
        self.window.reset_requested.connect(self.reset_pub.publish)

    # Callbacks
    def on_world_waypoints(self, msg):
        self.world_received.emit(read_world_sizes(rospy.get_param("world", {})), to_points(msg))

    def on_sensed_waypoints(self, msg):
        self.sensed_received.emit(to_points(msg))

    def on_target_waypoint(self, msg):
        self.target_received.emit((msg.idx, msg.x, msg.y))

    def on_car_position(self, msg):
        self.car_received.emit(msg.x, msg.y, msg.direction)

    def on_lap_count(self, msg):
        self.laps_received.emit(msg.data)

    # Publishing
    def publish_place(self, x, y):
        self.place_pub.publish(x=x, y=y, direction=self.scene.car.direction)

    # Run
    def run(self):
        self.window.show()
        status = QApplication.exec_()
        # Stop the callbacks before Qt deletes the window.
        rospy.signal_shutdown("the window was closed")
        return status


def to_points(msg):
    return [(waypoint.idx, waypoint.x, waypoint.y) for waypoint in msg.waypoints]


if __name__ == "__main__":
    rospy.init_node("qt_interface")
    if not any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")):
        rospy.logfatal("there is no screen: set DISPLAY, or launch with headless:=true")
        sys.exit(1)
    application = QApplication(sys.argv[:1])
    try:
        node = QtInterface()
        status = node.run()
    except SettingsError as error:
        rospy.logfatal(str(error))
        status = 1
    sys.exit(status)
