#!/usr/bin/python3
"""The car's nodes for a map start, plan and answer odometry where the world is not installed."""

import subprocess
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Path

from sdc_common.processes import wait_until
from sdc_common.ros.odometry import odometry_message
from sdc_testing import MessageListener
from sdc_testing.street_maps import is_installed

# Odometry of a drive through the town: time [s], x [m], y [m], yaw [rad], speed [m/s].
RECORDED = (
    (3.05, 99.6607, -302.7359, -0.04653, 4.9635),
    (3.10, 99.9110, -302.7477, -0.04657, 5.0589),
    (3.15, 100.1661, -302.7596, -0.04660, 5.1546),
    (3.20, 100.4259, -302.7717, -0.04663, 5.2507),
)
GOAL = (171.45, 206.75)
LAUNCH = ["roslaunch", "sdc_package", "map.launch", "camera:=false", "headless:=true"]
# The global planner, the local planner and the controller.
NODES_OF_ODOMETRY = 3


@unittest.skipUnless(is_installed, "docker/prepare maps has not been run")
class WithoutWorldTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.car = subprocess.Popen([*LAUNCH, "map:=town", f"goal:={[list(GOAL)]}"])

    @classmethod
    def tearDownClass(cls):
        cls.car.terminate()
        cls.car.wait()

    def test_world_is_not_installed(self):
        with self.assertRaises(ImportError):
            __import__("sdc_sim.road.network")

    def test_car_plans_and_answers_a_recorded_odometry(self):
        topic = "/carla/ego_vehicle/odometry"
        odometry = rospy.Publisher(topic, Odometry, queue_size=10)
        mission = MessageListener("/planner/mission_waypoints", Path)
        path = MessageListener("/planner/local_waypoints", LocalPath)
        command = MessageListener("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl)
        connected = f"{NODES_OF_ODOMETRY} subscribers of {topic}"
        wait_until(lambda: odometry.get_num_connections() >= NODES_OF_ODOMETRY, 60.0, connected)

        def publish(row):
            time_s, *pose, speed_mps = row
            message = odometry_message(rospy.Time.from_sec(time_s), pose, (speed_mps, 0.0, 0.0))
            odometry.publish(message)
            return message.header.stamp

        def has_path():
            publish(RECORDED[0])  # its first one makes the mission
            rospy.sleep(0.1)
            return path.messages

        wait_until(has_path, 60.0, "a path")
        last = mission.messages[0].waypoints[-1]
        self.assertLess(abs(last.x - GOAL[0]) + abs(last.y - GOAL[1]), 1.0)
        for row in RECORDED[1:]:
            stamp = publish(row)
            answer = command.wait_for(lambda found, stamp=stamp: found.header.stamp == stamp)
            self.assertLess(abs(answer.steer), 0.01)
        ahead = path.messages[-1].waypoints[-1]
        self.assertGreater(ahead.x, RECORDED[-1][1])
        self.assertAlmostEqual(ahead.y, RECORDED[-1][2], delta=2.0)
        self.assertGreater(ahead.v, RECORDED[-1][4])


if __name__ == "__main__":
    rospy.init_node("without_world_test")
    rostest.rosrun("sdc_package", "without_world", WithoutWorldTest)
