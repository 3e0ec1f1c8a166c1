#!/usr/bin/env python3
"""Hand control: a window with the camera picture and the keys of the CARLA client. H in the window shows them."""
import sys
import threading
import time

import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Path
from sdc_sim.msg import CarlaCollisionEvent, CarlaEgoVehicleStatus, CarlaLaneInvasionEvent, CarlaWorldInfo
from sensor_msgs.msg import Image
from std_msgs.msg import Bool
from std_srvs.srv import Empty

from sdc_package.node import parameter, refuse
from sdc_package.odometry import pose_and_speed
from sdc_package.window import NoDisplay, Window
from sdc_sim import hand_control as keys
from sdc_sim import hud
from sdc_sim.hud_drawing import HudDrawing
from sdc_sim.map_view import MapView
from sdc_sim.vehicle import VehicleCommand

EGO = "/carla/ego_vehicle"
CAMERA, LANE_MASK, MAP = EGO + "/camera/rgb/front/image_color", "/camera/lane_mask", "map"
VIEWS = (CAMERA, LANE_MASK, MAP)
LAST_MESSAGE_S = 0.2


class ManualControl:
    def __init__(self):
        rospy.init_node("manual_control")
        self.manual = parameter("manual_at_start")
        try:
            self.control = keys.HandControl(keys.HandControlRates(**parameter("rates")))
            self.map_view = MapView(**parameter("map"))
            self.notices = hud.Notices(parameter("notice_s"))
            self.window = Window("hand control", frames_per_second=parameter("frames_per_second"))
        except (TypeError, ValueError) as error:
            refuse(f"{error}; mend it in config/manual_control.yaml")
        except NoDisplay as error:
            refuse(error)

        self.lock = threading.Lock()
        self.bridge = CvBridge()
        self.drawing = HudDrawing()
        self.show_figures, self.show_help = True, False
        self.view = CAMERA
        self.pictures = {}
        self.frame_rate = hud.FrameRate()
        self.map_name = self.stamp = self.pose = self.path = None
        self.applied = VehicleCommand()

        self.command_publisher = rospy.Publisher(EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl, queue_size=1)
        self.override_publisher = rospy.Publisher(EGO + "/vehicle_control_manual_override", Bool, queue_size=1, latch=True)
        self.reset_service = rospy.ServiceProxy("/sim/reset", Empty)

        for topic in (CAMERA, LANE_MASK):
            rospy.Subscriber(topic, Image, self.on_picture, topic, queue_size=1, buff_size=4 * 1024 * 1024, tcp_nodelay=True)
        rospy.Subscriber(EGO + "/odometry", Odometry, self.on_odometry, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber(EGO + "/vehicle_status", CarlaEgoVehicleStatus, self.on_status, queue_size=1)
        rospy.Subscriber(EGO + "/collision", CarlaCollisionEvent, self.on_collision)
        rospy.Subscriber(EGO + "/lane_invasion", CarlaLaneInvasionEvent, self.on_lane_invasion)
        rospy.Subscriber("/carla/world_info", CarlaWorldInfo, self.on_world_info)
        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission)
        rospy.Subscriber("/planner/local_waypoints", LocalPath, self.on_path, queue_size=1)
        rospy.on_shutdown(self.hand_back)

    def on_picture(self, message, topic):
        self.pictures[topic] = message

    def on_odometry(self, odometry):
        try:
            pose = pose_and_speed(odometry)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: refused {EGO}/odometry: {error}")
            return
        with self.lock:
            self.pose, self.stamp = pose, odometry.header.stamp
            self.frame_rate.count(time.monotonic())

    def on_status(self, status):
        control = status.control
        self.applied = VehicleCommand(control.throttle, control.steer, control.brake, control.hand_brake, control.reverse)

    def on_collision(self, event):
        self.say(hud.collision_text(event.other_actor_id))

    def on_lane_invasion(self, event):
        self.say(hud.crossed_line_text(event.crossed_lane_markings))

    def on_world_info(self, info):
        self.map_name = info.map_name

    def on_mission(self, path):
        try:
            self.map_view.set_route([(point.x, point.y) for point in path.waypoints])
        except ValueError as error:
            rospy.logwarn("manual_control: no map of the mission on /planner/mission_waypoints: %s", error)

    def on_path(self, path):
        self.path = [(point.x, point.y, point.v) for point in path.waypoints]

    def say(self, text):
        with self.lock:
            self.notices.say(text, time.monotonic())

    def press(self, key):
        if key == keys.QUIT_KEY:
            self.window.close()
        elif key == keys.REVERSE_KEY:
            self.control.toggle_reverse()
        elif key == keys.AUTOPILOT_KEY:
            self.manual = not self.manual
            self.control.reset()
            self.override_publisher.publish(self.manual)
            self.say("You drive" if self.manual else "The stack drives")
        elif key == keys.VIEW_KEY:
            self.view = VIEWS[(VIEWS.index(self.view) + 1) % len(VIEWS)]
        elif key == keys.RESET_KEY:
            self.control.reset()
            threading.Thread(target=self.reset_world, daemon=True).start()
        elif key == keys.HUD_KEY:
            self.show_figures = not self.show_figures
        elif key == keys.HELP_KEY:
            self.show_help = not self.show_help

    def reset_world(self):
        try:
            self.reset_service()
            self.say("Back at the start")
        except rospy.ServiceException as error:
            rospy.logwarn("manual_control: the world was not reset: %s", error)
            self.say("This world cannot be reset")

    def drive(self, held):
        command = self.control.step(held, self.window.step_s)
        if self.manual:
            message = CarlaVehicleControl(None, command.throttle, command.steer, command.brake, command.hand_brake, command.reverse)
            message.header.stamp = self.stamp or rospy.Time(0)
            self.command_publisher.publish(message)

    def hand_back(self):
        self.override_publisher.publish(False)
        time.sleep(LAST_MESSAGE_S)  # the publisher's own thread sends it

    def picture(self):
        """The picture of the chosen view as BGR, or None where there is none yet."""
        if self.view == MAP:
            return self.map_view.picture(*self.pose[:3], self.path) if self.pose else None
        message = self.pictures.get(self.view)
        try:
            return message and self.bridge.imgmsg_to_cv2(message, "bgr8")
        except CvBridgeError as error:
            rospy.logwarn_throttle(1.0, f"manual_control: refused a picture on {self.view}: {error}")
            return None

    def draw(self, screen):
        now = time.monotonic()
        x, y, yaw, speed = self.pose or (None, None, None, None)
        readings = hud.Readings(
            server_fps=self.frame_rate.per_second(now), client_fps=self.window.frame_rate, map_name=self.map_name,
            time_s=self.stamp and self.stamp.to_sec(), x_m=x, y_m=y, yaw_rad=yaw, speed_mps=speed,
            command=self.control.command if self.manual else self.applied, manual=self.manual)
        self.drawing.draw(screen, readings, self.notices.visible(now), self.show_figures, self.show_help)

    def run(self):
        self.override_publisher.publish(self.manual)
        while not (rospy.is_shutdown() or self.window.closed):
            picture = self.picture()
            pressed = self.window.show(picture if picture is not None else np.zeros((480, 640, 3), np.uint8), self.draw)
            for key in pressed:
                self.press(key)
            self.drive(self.window.held.union(pressed))
        self.window.close()
        rospy.signal_shutdown("the window was closed")


if __name__ == "__main__":
    sys.exit(ManualControl().run())
