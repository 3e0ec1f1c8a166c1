#!/usr/bin/env python3
"""The window on the field: shows what the world publishes, publishes what mouse and keys wish."""

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
    # ROS calls back in threads of its own, and widgets belong to Qt's: only these signals go across.
    world_came = pyqtSignal(object, object)
    sensed_came = pyqtSignal(object)
    target_came = pyqtSignal(object)
    car_came = pyqtSignal(float, float, float)
    laps_came = pyqtSignal(int)
    pause_came = pyqtSignal(bool)
    reset_came = pyqtSignal()
    shutdown_came = pyqtSignal()

    def __init__(self):
        super().__init__()
        # Parameters
        self.settings = read_settings(rospy.get_param("~", {}))

        # State
        self.scene = Scene(self.settings)
        self.window = Window(self.scene)

        # Publishers
        self.place_pub = rospy.Publisher(
            "world/place_car", CarPosition, queue_size=1, tcp_nodelay=True
        )
        self.add_pub = rospy.Publisher("world/add_waypoint", Waypoint, queue_size=10)
        self.pause_pub = rospy.Publisher("world/pause", Bool, queue_size=10)
        self.reset_pub = rospy.Publisher("world/reset", Empty, queue_size=10)
        self.connect_window()

        # Subscribers
        rospy.Subscriber("/world_waypoints", Waypoints, self.on_world_waypoints, queue_size=1)
        rospy.Subscriber(
            "/sensed_waypoints", Waypoints, self.on_sensed_waypoints, queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber("/target_waypoint", Waypoint, self.on_target_waypoint, queue_size=1)
        rospy.Subscriber(
            "/car_position", CarPosition, self.on_car_position, queue_size=10, tcp_nodelay=True
        )
        rospy.Subscriber(
            "/lap_count", UInt32, lambda msg: self.laps_came.emit(msg.data), queue_size=1
        )
        rospy.Subscriber("/paused", Bool, lambda msg: self.pause_came.emit(msg.data), queue_size=1)
        rospy.Subscriber("world/reset", Empty, lambda _msg: self.reset_came.emit(), queue_size=1)
        rospy.on_shutdown(self.shutdown_came.emit)

    def connect_window(self):
        self.world_came.connect(self.scene.set_world)
        self.sensed_came.connect(self.scene.set_sensed)
        self.target_came.connect(self.scene.set_target)
        self.car_came.connect(self.window.set_car)
        self.laps_came.connect(self.window.set_laps)
        self.pause_came.connect(self.window.set_paused)
        self.reset_came.connect(self.window.clear_trail)
        self.shutdown_came.connect(self.window.close)
        self.window.car_dragged.connect(self.publish_place)
        self.window.waypoint_wished.connect(lambda x, y: self.add_pub.publish(x=x, y=y))
        self.window.pause_wished.connect(self.pause_pub.publish)
        self.window.reset_wished.connect(self.reset_pub.publish)

    # Callbacks
    def on_world_waypoints(self, msg):
        self.world_came.emit(read_world_sizes(rospy.get_param("world", {})), to_points(msg))

    def on_sensed_waypoints(self, msg):
        self.sensed_came.emit(to_points(msg))

    def on_target_waypoint(self, msg):
        self.target_came.emit((msg.idx, msg.x, msg.y))

    def on_car_position(self, msg):
        self.car_came.emit(msg.x, msg.y, msg.direction)

    # Publishing
    def publish_place(self, x, y):
        self.place_pub.publish(x=x, y=y, direction=self.scene.car.direction)

    # Run
    def run(self):
        self.window.show()
        status = QApplication.exec_()
        # No message may come in any more once Qt begins to take the window apart.
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
