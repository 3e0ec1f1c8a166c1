#!/usr/bin/python3
"""Test of the manual control window with key events, the simulator and the stack."""

import contextlib
import os
import signal
import subprocess
import unittest

import cv2
import numpy as np
import rospy
import rostest
from carla_msgs.msg import CarlaLaneInvasionEvent
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl
from std_msgs.msg import Bool

from sdc_common.processes import wait_until
from sdc_package.odometry import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber
from sdc_testing.program import run
from sdc_testing.virtual_display import VirtualDisplay

EGO = "/carla/ego_vehicle"
TITLE = "hand control"
PANEL = slice(0, 196)  # columns of the window with the panel of readings
GRASS = (70, 105, 80)  # BGR, in the map view
LIMIT_S = 40.0


class ManualControlTest(unittest.TestCase):
    client = None

    @classmethod
    def setUpClass(cls):
        cls.display = VirtualDisplay()
        cls.display.__enter__()
        cls.addClassCleanup(cls.display.__exit__)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        cls.command = MessageListener(EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl)
        cls.override = MessageListener(EGO + "/vehicle_control_manual_override", Bool)
        cls.lane_invasion = rospy.Publisher(
            EGO + "/lane_invasion", CarlaLaneInvasionEvent, queue_size=1
        )
        cls.odometry.wait_for(seconds=LIMIT_S)

    @classmethod
    def tearDownClass(cls):
        cls.close_client()

    @classmethod
    def close_client(cls):
        if cls.client and cls.client.poll() is None:
            cls.client.send_signal(signal.SIGINT)
            cls.client.communicate(timeout=LIMIT_S)
        ManualControlTest.client = None

    def setUp(self):
        """Start manual control of a car at standstill at the start, with the camera view."""
        first = len(self.override.messages)
        if self.client is None or self.client.poll() is not None:
            ManualControlTest.client = subprocess.Popen(
                ["roslaunch", "sdc_sim", "manual_control.launch"], env=self.display.environment
            )
            self.override.wait_for(lambda message: message.data, LIMIT_S, after=first)
        self.assertTrue(self.override.messages[-1].data)
        self.window = wait_until(lambda: self.display.windows(TITLE), LIMIT_S, "the window")[0]
        self.display.focus(TITLE)
        wait_until(self.command._subscriber.get_num_connections, LIMIT_S, "a manual control")
        self.display.xdotool("key", "BackSpace")
        self.wait_for_car(lambda car: self.is_at_start(car) and self.forward_speed(car) == 0.0)

    def wait_for_car(self, accepts):
        return self.odometry.wait_for(accepts, LIMIT_S, after=len(self.odometry.messages))

    def wait_for_command(self, accepts):
        return self.command.wait_for(accepts, LIMIT_S, after=len(self.command.messages))

    def wait_for_frames(self, count):
        """Wait until the window has shown new frames."""
        self.command.wait_for(seconds=LIMIT_S, after=len(self.command.messages) + count)

    def wait_for_picture(self, accepts, what):
        return wait_until(lambda: accepts(self.display.picture(self.window)), LIMIT_S, what)

    @contextlib.contextmanager
    def held(self, *keys):
        for key in keys:
            self.display.xdotool("keydown", key)
        try:
            yield
        finally:
            for key in keys:
                self.display.xdotool("keyup", key)

    @staticmethod
    def is_at_start(car):
        return np.hypot(*pose_and_speed(car)[:2]) < 1.0

    @staticmethod
    def forward_speed(car):
        return car.twist.twist.linear.x

    def test_w_drives_and_s_brakes(self):
        with self.held("w"):
            self.wait_for_car(lambda car: self.forward_speed(car) > 4.0)
        command = self.wait_for_command(lambda command: command.throttle == 0.0)
        self.assertGreater(command.header.stamp.to_sec(), 0.0)
        with self.held("s"):
            self.wait_for_command(lambda command: command.brake == 1.0)
            self.wait_for_car(lambda car: self.forward_speed(car) == 0.0)

    def test_p_switches_between_stack_and_person(self):
        before = len(self.override.messages)
        self.display.xdotool("key", "p")
        self.override.wait_for(lambda message: not message.data, LIMIT_S, after=before)
        self.wait_for_car(lambda car: self.forward_speed(car) > 3.0)  # the stack drives
        count = len(self.command.messages)
        self.wait_for_car(lambda car: self.forward_speed(car) > 5.0)
        self.assertEqual(len(self.command.messages), count)
        self.display.xdotool("key", "p")
        self.override.wait_for(lambda message: message.data, LIMIT_S, after=before)
        with self.held("s"):
            self.wait_for_car(lambda car: self.forward_speed(car) == 0.0)

    def test_tab_f1_and_h_switch_views_panel_and_help(self):
        self.wait_for_picture(lambda picture: picture[:100, 300:, 0].mean() > 120, "a blue sky")
        self.wait_for_frames(20)
        camera = self.display.picture(self.window)
        self.display.xdotool("key", "F1")
        self.wait_for_picture(
            lambda picture: picture[300:, PANEL].mean() > 1.3 * camera[300:, PANEL].mean(),
            "a window without the panel",
        )
        self.display.xdotool("key", "F1")
        self.display.xdotool("key", "h")
        self.wait_for_picture(
            lambda picture: picture[80:280, 250:600].mean() < 0.6 * camera[80:280, 250:600].mean(),
            "the help",
        )
        self.display.xdotool("key", "h")
        self.display.xdotool("key", "Tab")
        self.wait_for_picture(
            lambda picture: 0.0 < (picture[:, 250:] > 128).mean() < 0.1, "the lane mask"
        )
        self.display.xdotool("key", "Tab")
        self.wait_for_picture(
            lambda picture: tuple(picture[2, 620]) == GRASS, "the grass of the map"
        )
        self.check_notice()
        self.display.xdotool("key", "Tab")
        self.wait_for_picture(
            lambda picture: np.abs(picture[:, 250:].astype(int) - camera[:, 250:]).mean() < 10,
            "the camera again",
        )

    def check_notice(self):
        wait_for_subscriber(self.lane_invasion)

        def bottom_is_grass(picture):
            return (picture[430:, 360:] == GRASS).all()

        self.wait_for_picture(bottom_is_grass, "the end of the earlier notices")
        self.lane_invasion.publish(CarlaLaneInvasionEvent(crossed_lane_markings=[2]))
        self.wait_for_picture(lambda picture: not bottom_is_grass(picture), "the notice")
        if rospy.get_param("~screenshot"):
            cv2.imwrite(rospy.get_param("~screenshot"), self.display.picture(self.window))
        self.wait_for_picture(bottom_is_grass, "the end of the notice")

    def test_escape_quits_and_returns_control(self):
        self.check_quits(lambda: self.display.xdotool("key", "Escape"))

    def check_quits(self, quit_client):
        before = len(self.override.messages)
        quit_client()
        self.override.wait_for(lambda message: not message.data, LIMIT_S, after=before)
        self.client.communicate(timeout=LIMIT_S)
        ManualControlTest.client = None
        self.assertEqual(self.display.windows(TITLE), [])

    def test_missing_display_is_one_line_and_exit_code_1(self):
        self.close_client()
        for name in ("", ":63"):
            environment = {**os.environ, "DISPLAY": name}
            environment.pop("SDL_VIDEODRIVER", None)
            client = "rosrun", "sdc_sim", "manual_control.py", "__name:=manual_control"
            done = run(*client, environment=environment)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertRegex(done.stdout, "(?m)^.*manual_control: there is no display")
            self.assertEqual(len(done.stdout.strip().splitlines()), 1, done.stdout)


if __name__ == "__main__":
    rospy.init_node("manual_control_test")
    rostest.rosrun("sdc_package", "manual_control_test", ManualControlTest)
