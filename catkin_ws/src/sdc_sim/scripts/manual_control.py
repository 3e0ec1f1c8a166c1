#!/usr/bin/env python3
"""Manual control: a window with the camera picture and the keys of CARLA's client."""

import threading
import time
from dataclasses import replace

import numpy as np
import rospy
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaWorldInfo,
)
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, ObstacleArray
from sensor_msgs.msg import Image
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.conversion import command_message, true_odometry_topic
from sdc_common.ros.node import LoopPublisher, parameter, refuse
from sdc_common.window import ImageWindow, NoDisplay
from sdc_sim.manual_control import keyboard
from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.hud_renderer import HudRenderer
from sdc_sim.manual_control.map_view import MapView
from sdc_sim.manual_control.views import ViewSelector
from sdc_sim.ros.waypoint_messages import waypoint_rows

EGO = "/carla/ego_vehicle"
PICTURE_TOPICS = (EGO + "/camera/rgb/front/image_color", "/camera/lane_mask")
PICTURE_BUFFER_BYTES = 4 * 1024 * 1024
BLACK = np.zeros((480, 640, 3), np.uint8)
LAST_MESSAGE_S = 0.2


class ManualControl:
    def __init__(self):
        rospy.init_node("manual_control")
        self.is_manual = parameter("manual_at_start")
        try:
            self.control = keyboard.KeyboardControl(
                keyboard.KeyboardControlRates(**parameter("rates"))
            )
            self.views = ViewSelector(PICTURE_TOPICS, MapView(**parameter("map")))
            self.state = DriveState(parameter("notice_s"), time.monotonic)
            self.window = ImageWindow(
                "hand control", frames_per_second=parameter("frames_per_second")
            )
        except (TypeError, ValueError) as error:
            refuse(f"{error}; correct it in config/manual_control.yaml")
        except NoDisplay as error:
            refuse(error)
        self.hud = HudRenderer()
        self.show_panel, self.show_help = True, False

        self.command_publisher = LoopPublisher(
            EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl
        )
        self.override_publisher = LoopPublisher(
            EGO + "/vehicle_control_manual_override", Bool, latch=True
        )
        self.reset_service = rospy.ServiceProxy("/sim/reset", Trigger)

        latest = {"queue_size": 1, "tcp_nodelay": True}
        for topic in PICTURE_TOPICS:
            rospy.Subscriber(
                topic, Image, self.views.on_picture, topic, buff_size=PICTURE_BUFFER_BYTES, **latest
            )
        state = self.state
        self.odometry_topic = true_odometry_topic(EGO)
        rospy.Subscriber(self.odometry_topic, Odometry, self.on_odometry, **latest)
        rospy.Subscriber(
            EGO + "/vehicle_status", CarlaEgoVehicleStatus, state.on_status, queue_size=1
        )
        rospy.Subscriber(EGO + "/obstacles", ObstacleArray, state.on_obstacles, queue_size=1)
        rospy.Subscriber(EGO + "/collision", CarlaCollisionEvent, state.on_collision)
        rospy.Subscriber(EGO + "/lane_invasion", CarlaLaneInvasionEvent, state.on_lane_invasion)
        rospy.Subscriber("/carla/world_info", CarlaWorldInfo, state.on_world_info)
        rospy.Subscriber("/planner/mission_waypoints", rospy.AnyMsg, self.on_mission)
        rospy.Subscriber("/planner/local_waypoints", rospy.AnyMsg, self.on_path, queue_size=1)

    def on_odometry(self, odometry):
        try:
            self.state.on_odometry(odometry)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: refused {self.odometry_topic}: {error}")

    def on_mission(self, path):
        try:
            self.views.map_view.set_route(waypoint_rows(path, "x", "y"))
        except ValueError as error:
            rospy.logwarn("manual_control: refused /planner/mission_waypoints: %s", error)

    def on_path(self, path):
        try:
            self.state.on_path(path)
        except ValueError as error:
            rospy.logwarn_throttle(
                1.0, f"manual_control: refused /planner/local_waypoints: {error}"
            )

    def on_key(self, key):
        if key == keyboard.QUIT_KEY:
            self.window.close()
        elif key == keyboard.REVERSE_KEY:
            self.control.toggle_reverse()
        elif key == keyboard.AUTOPILOT_KEY:
            self.set_manual(not self.is_manual)
            self.state.notify("You drive" if self.is_manual else "The stack drives")
        elif key == keyboard.VIEW_KEY:
            self.views.select_next()
        elif key == keyboard.RESET_KEY:
            self.control.reset()
            # The service call blocks while the world is paused.
            threading.Thread(target=self.reset_world, daemon=True).start()
        elif key == keyboard.HUD_KEY:
            self.show_panel = not self.show_panel
        elif key == keyboard.HELP_KEY:
            self.show_help = not self.show_help

    def reset_world(self):
        try:
            self.reset_service()
            self.state.notify("Back at the start")
        except rospy.ServiceException as error:
            rospy.logwarn("manual_control: cannot reset the world: %s", error)
            self.state.notify("This world cannot be reset")

    def set_manual(self, is_manual):
        """Take control, or return it to the stack."""
        self.is_manual = is_manual
        self.control.reset()
        self.override_publisher.publish(is_manual)

    def on_shutdown(self):
        self.set_manual(False)
        time.sleep(LAST_MESSAGE_S)  # rospy sends the message in another thread

    def publish_command(self, held):
        stamp_ns = self.state.stamp.to_nsec() if self.state.stamp else 0
        command = replace(self.control.step(held, self.window.step_s), stamp_ns=stamp_ns)
        self.command_publisher.publish(command_message(command, CarlaVehicleControl))

    def show_frame(self):
        """Show one frame; return the keys that were pressed meanwhile."""
        try:
            picture = self.views.picture(self.state)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: {error}")
            picture = None
        readings = self.state.readings(self.control.command, self.is_manual, self.window.frame_rate)
        notices = self.state.notices()

        def overlay(screen):
            if picture is None:
                self.hud.draw_centred(screen, f"no picture on {self.views.selected} yet")
            self.hud.draw(screen, readings, notices, self.show_panel, self.show_help)

        return self.window.show(BLACK if picture is None else picture, overlay)

    def run(self):
        rospy.on_shutdown(self.on_shutdown)
        watch_connections()
        self.set_manual(self.is_manual)
        while not (rospy.is_shutdown() or self.window.closed):
            pressed = self.show_frame()
            for key in pressed:
                self.on_key(key)
            if self.is_manual:
                self.publish_command(self.window.held.union(pressed))
        self.window.close()
        rospy.signal_shutdown("the window was closed")


if __name__ == "__main__":
    ManualControl().run()
