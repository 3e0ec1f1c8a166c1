#!/usr/bin/env python3
"""Hand control: a window with the camera picture and the keys of the CARLA client. H in the window shows them."""

import threading
import time

import numpy as np
import rospy
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaWorldInfo,
)
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, LocalPath, ObstacleArray, Path
from sensor_msgs.msg import Image
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.node import LoopPublisher, parameter, refuse
from sdc_common.window import ImageWindow, NoDisplay
from sdc_sim.manual_control import keyboard
from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.hud_renderer import HudRenderer
from sdc_sim.manual_control.map_view import MapView
from sdc_sim.manual_control.views import ViewSelector

EGO = "/carla/ego_vehicle"
PICTURES = (EGO + "/camera/rgb/front/image_color", "/camera/lane_mask")
BLACK = np.zeros((480, 640, 3), np.uint8)
LAST_MESSAGE_S = 0.2


class ManualControl:
    def __init__(self):
        rospy.init_node("manual_control")
        self.manual = parameter("manual_at_start")
        try:
            self.control = keyboard.HandControl(keyboard.HandControlRates(**parameter("rates")))
            self.views = ViewSelector(PICTURES, MapView(**parameter("map")))
            self.facts = DriveState(parameter("notice_s"), time.monotonic)
            self.window = ImageWindow(
                "hand control", frames_per_second=parameter("frames_per_second")
            )
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/manual_control.yaml")
        except NoDisplay as error:
            refuse(error)

        self.drawing = HudRenderer()
        self.show_figures, self.show_help = True, False

        self.command_publisher = LoopPublisher(
            EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl
        )
        self.override_publisher = LoopPublisher(
            EGO + "/vehicle_control_manual_override", Bool, latch=True
        )
        self.reset_service = rospy.ServiceProxy("/sim/reset", Trigger)

        for topic in PICTURES:
            rospy.Subscriber(
                topic,
                Image,
                self.views.take,
                topic,
                queue_size=1,
                buff_size=4 * 1024 * 1024,
                tcp_nodelay=True,
            )
        rospy.Subscriber(
            EGO + "/odometry", Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber(
            EGO + "/vehicle_status", CarlaEgoVehicleStatus, self.facts.on_status, queue_size=1
        )
        rospy.Subscriber(EGO + "/obstacles", ObstacleArray, self.facts.on_obstacles, queue_size=1)
        rospy.Subscriber(EGO + "/collision", CarlaCollisionEvent, self.facts.on_collision)
        rospy.Subscriber(
            EGO + "/lane_invasion", CarlaLaneInvasionEvent, self.facts.on_lane_invasion
        )
        rospy.Subscriber("/carla/world_info", CarlaWorldInfo, self.facts.on_world_info)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission)
        rospy.Subscriber("/planner/local_waypoints", LocalPath, self.facts.on_path, queue_size=1)

    def on_odometry(self, odometry):
        try:
            self.facts.on_odometry(odometry)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: refused {EGO}/odometry: {error}")

    def on_mission(self, path):
        try:
            self.views.map_view.set_route([(point.x, point.y) for point in path.waypoints])
        except ValueError as error:
            rospy.logwarn(
                "manual_control: no map of the mission on /planner/mission_waypoints: %s", error
            )

    def press(self, key):
        if key == keyboard.QUIT_KEY:
            self.window.close()
        elif key == keyboard.REVERSE_KEY:
            self.control.toggle_reverse()
        elif key == keyboard.AUTOPILOT_KEY:
            self.drive_by_hand(not self.manual)
            self.facts.say("You drive" if self.manual else "The stack drives")
        elif key == keyboard.VIEW_KEY:
            self.views.next()
        elif key == keyboard.RESET_KEY:
            self.control.reset()
            threading.Thread(
                target=self.reset_world, daemon=True
            ).start()  # a paused world may keep it waiting
        elif key == keyboard.HUD_KEY:
            self.show_figures = not self.show_figures
        elif key == keyboard.HELP_KEY:
            self.show_help = not self.show_help

    def reset_world(self):
        try:
            self.reset_service()
            self.facts.say("Back at the start")
        except rospy.ServiceException as error:
            rospy.logwarn("manual_control: the world was not reset: %s", error)
            self.facts.say("This world cannot be reset")

    def drive_by_hand(self, manual):
        self.manual = manual
        self.control.reset()
        self.override_publisher.publish(manual)

    def drive(self, held):
        if not self.manual:
            return
        command = self.control.step(held, self.window.step_s)
        message = CarlaVehicleControl(
            None,
            command.throttle,
            command.steer,
            command.brake,
            command.hand_brake,
            command.reverse,
        )
        message.header.stamp = self.facts.stamp or rospy.Time(0)
        self.command_publisher.publish(message)

    def hand_back(self):
        self.drive_by_hand(False)
        time.sleep(LAST_MESSAGE_S)  # the publisher's own thread sends it

    def show(self):
        """Show one frame; returns the keys that were pressed meanwhile."""
        readings = self.facts.readings(self.control.command, self.manual, self.window.frame_rate)
        try:
            picture = self.views.picture(self.facts)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: {error}")
            picture = None

        def overlay(screen):
            if picture is None:
                self.drawing.draw_centred(screen, f"nothing to see yet on {self.views.shown}")
            self.drawing.draw(
                screen, readings, self.facts.notices(), self.show_figures, self.show_help
            )

        return self.window.show(BLACK if picture is None else picture, overlay)

    def run(self):
        rospy.on_shutdown(self.hand_back)
        watch_connections()
        self.drive_by_hand(self.manual)
        while not (rospy.is_shutdown() or self.window.closed):
            pressed = self.show()
            for key in pressed:
                self.press(key)
            self.drive(self.window.held.union(pressed))
        self.window.close()
        rospy.signal_shutdown("the window was closed")


if __name__ == "__main__":
    ManualControl().run()
