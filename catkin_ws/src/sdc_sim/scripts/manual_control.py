#!/usr/bin/env python3
"""Manual control: a window with the camera picture and the keys of CARLA's client."""

import threading
import time
from dataclasses import replace
from functools import partial

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

from sdc_common.ros.conversion import command_message
from sdc_common.ros.node import LoopPublisher, parameter, refuse, watch_connections
from sdc_common.ros.odometry import true_odometry_topic
from sdc_common.ros.pictures import pixels_of
from sdc_common.ros.refusal import refusing
from sdc_common.window import ImageWindow, NoDisplay
from sdc_sim.manual_control import keyboard
from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.hud import Hud
from sdc_sim.manual_control.map_view import MapView
from sdc_sim.ros.waypoint_messages import waypoint_rows

EGO = "/carla/ego_vehicle"
PICTURE_TOPICS = (EGO + "/camera/rgb/front/image_color", "/camera/lane_mask")
BUFFER_BYTES = 4 * 1024 * 1024
MAP = "map"
LAST_MESSAGE_S = 0.2


class ManualControl:
    def __init__(self):
        rospy.init_node("manual_control")
        self.is_manual = parameter("manual_at_start")
        try:
            rates = keyboard.KeyboardControlRates(**parameter("rates"))
            self.control = keyboard.KeyboardControl(rates)
            self.map_view = MapView(**parameter("map"))
            self.state = DriveState(parameter("notice_s"))
            rate = {"frames_per_second": parameter("frames_per_second")}
            self.window = ImageWindow("hand control", **rate)
        except (TypeError, ValueError) as error:
            refuse(f"{error}; correct it in config/manual_control.yaml")
        except NoDisplay as error:
            refuse(error)
        self.hud = Hud()
        self.show_panel, self.show_help = True, False
        self.views, self.pictures = [*PICTURE_TOPICS, MAP], {}

        self.commands = LoopPublisher(EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl)
        self.overrides = LoopPublisher(EGO + "/vehicle_control_manual_override", Bool, latch=True)
        self.reset_service = rospy.ServiceProxy("/sim/reset", Trigger)

        for topic, message_class, handle, queue_size in (
            *((key, Image, partial(self.pictures.__setitem__, key), 1) for key in PICTURE_TOPICS),
            (true_odometry_topic(EGO), Odometry, self.state.on_odometry, 1),
            (EGO + "/vehicle_status", CarlaEgoVehicleStatus, self.state.on_status, 1),
            (EGO + "/obstacles", ObstacleArray, self.state.on_obstacles, 1),
            (EGO + "/collision", CarlaCollisionEvent, self.state.on_collision, None),
            (EGO + "/lane_invasion", CarlaLaneInvasionEvent, self.state.on_lane_invasion, None),
            ("/carla/world_info", CarlaWorldInfo, self.state.on_world_info, None),
            ("/planner/mission_waypoints", rospy.AnyMsg, self.on_mission, None),
            ("/planner/local_waypoints", rospy.AnyMsg, self.state.on_path, 1),
        ):
            rospy.Subscriber(
                *(topic, message_class, self.on_message, (topic, handle)),
                queue_size=queue_size,
                buff_size=BUFFER_BYTES,
                tcp_nodelay=True,
            )

    def on_message(self, message, topic_and_handle):
        topic, handle = topic_and_handle
        with refusing(topic):
            handle(message)

    def on_mission(self, path):
        map_path = rospy.get_param("/sim/map_path", "")
        self.map_view.set_route(waypoint_rows(path, "x", "y"), map_path)

    def on_key(self, key):
        action = keyboard.ACTIONS.get(key)
        if action == "quit":
            self.window.close()
        elif action == "reverse":
            self.control.toggle_reverse()
        elif action == "autopilot":
            self.set_manual(not self.is_manual)
            self.state.notify("You drive" if self.is_manual else "The stack drives")
        elif action == "view":
            self.views = [*self.views[1:], self.views[0]]
        elif action == "reset":
            self.control.reset()
            # The service call blocks while the world is paused.
            threading.Thread(target=self.reset_world, daemon=True).start()
        elif action == "hud":
            self.show_panel = not self.show_panel
        elif action == "help":
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
        self.overrides.publish(is_manual)

    def on_shutdown(self):
        self.set_manual(False)
        time.sleep(LAST_MESSAGE_S)  # rospy sends the message in another thread

    def publish_command(self, held):
        stamp_ns = self.state.stamp.to_nsec() if self.state.stamp else 0
        command = replace(
            self.control.step(held, self.window.clock.get_time() / 1e3), stamp_ns=stamp_ns
        )
        self.commands.publish(command_message(command, CarlaVehicleControl))

    def picture(self):
        """Return the picture of the selected view, or None if there is none."""
        view, state = self.views[0], self.state
        if view == MAP:
            return state.pose and self.map_view.picture(state.pose, state.path, state.obstacles)
        with refusing(view):
            return pixels_of(self.pictures[view]) if view in self.pictures else None
        return None

    def show_frame(self):
        """Show one frame; return the keys that were pressed meanwhile."""
        picture = self.picture()
        readings = self.state.readings(self.is_manual, self.window.clock.get_fps())

        def overlay(screen):
            if picture is None:
                self.hud.draw_centred(screen, f"no picture on {self.views[0]} yet")
            if self.show_panel:
                self.hud.draw_panel(screen, readings, self.state.command or self.control.command)
            if self.show_help:
                self.hud.draw_help(screen)
            self.hud.draw_notices(screen, self.state.notices())

        return self.window.show(picture, overlay)

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
