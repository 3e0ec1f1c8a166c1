#!/usr/bin/env python3
"""Every steering method steers the node, a student's own as well; what cannot be built ends the node before the car moves."""

import os
import subprocess
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_common.testing.message_listener import MessageListener, wait_for_subscriber, wait_until
from sdc_package.steering.method import METHODS

CONTROLLERS = [*METHODS, "own"]
LIMIT_S = 30.0
TRIES = 6


class SteeringMethodsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.path = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=10)
        cls.odometry = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=10)
        cls.commands = {
            name: MessageListener(f"/{name}/command", CarlaVehicleControl) for name in CONTROLLERS
        }
        for name in CONTROLLERS:
            cls.commands[name].wait_for_publisher(LIMIT_S)
        for publisher in (cls.path, cls.odometry):
            wait_for_subscriber(publisher)
            wait_until(
                lambda wanted=publisher: wanted.get_num_connections() >= len(CONTROLLERS),
                LIMIT_S,
                "all controllers listening",
            )

    def steer(self, x, y):
        """What each controller answers to one pair for a car beside a straight road; asked again where a pair came too late for one."""
        for _ in range(TRIES - 1):
            try:
                return self.ask(x, y, LIMIT_S / TRIES)
            except TimeoutError:
                pass
        return self.ask(x, y, LIMIT_S / TRIES)

    def ask(self, x, y, seconds):
        odometry = Odometry()
        odometry.header.stamp = rospy.Time.now()
        odometry.pose.pose.position.x = x
        odometry.pose.pose.position.y = y
        odometry.pose.pose.orientation.w = 1.0
        odometry.twist.twist.linear.x = 5.0
        self.odometry.publish(odometry)
        self.path.publish(LocalPath([Waypoint(float(s), 0.0, 5.0) for s in range(30)]))

        def answers(command):
            stops_for_silence = command.brake == 0.5 and command.steer == 0.0
            return command.header.stamp == odometry.header.stamp and not stops_for_silence

        return {
            name: commands.wait_for(answers, seconds) for name, commands in self.commands.items()
        }

    def test_each_steers_back_to_the_road(self):
        self.steer(4.0, 0.3)
        left = self.steer(4.5, 0.3)
        for name, command in left.items():
            self.assertGreater(command.steer, 0.01, name)
        self.steer(4.0, -0.3)
        for name, command in self.steer(4.5, -0.3).items():
            self.assertLess(command.steer, -0.01, name)
        self.assertEqual(
            len({round(command.steer, 5) for command in left.values()}),
            len(CONTROLLERS),
            "each is a method of its own",
        )

    def test_what_cannot_be_built_ends_the_node_in_one_line(self):
        figures = rospy.get_param("/stanley/simple_controller")
        cases = {
            "misspelt_name": (
                {"steering_method": "stanly"},
                "there is no steering_method 'stanly': did you mean 'stanley'?",
            ),
            "no_module": (
                {"steering_method": "nowhere:MySteering"},
                "there is no module 'nowhere'",
            ),
            "no_section": (
                {"steering_method": "my_module:MySteering"},
                "section 'MySteering' lacks 'gain'",
            ),
            "without_sense": (
                {"stanley": {"k": -1.0, "softening_mps": 1.0, "preview_s": 0.0}},
                "k must be a positive number, got -1.0",
            ),
        }
        environment = dict(os.environ)
        environment["PYTHONPATH"] = os.pathsep.join(
            [
                os.path.join(os.path.dirname(os.path.abspath(__file__)), "own_steering"),
                environment.get("PYTHONPATH", ""),
            ]
        )
        for name, (changes, says) in cases.items():
            with self.subTest(name):
                rospy.set_param("/" + name, {**figures, **changes})
                done = subprocess.run(
                    ["rosrun", "sdc_package", "simple_controller.py", "__name:=" + name],
                    env=environment,
                    text=True,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    timeout=LIMIT_S,
                    check=False,
                )
                self.assertEqual(done.returncode, 1, done.stdout)
                told = [line for line in done.stdout.splitlines() if says in line]
                self.assertEqual(len(told), 1, done.stdout)
                self.assertIn("config/simple_controller.yaml", told[0])
                self.assertNotIn("Traceback", done.stdout)


if __name__ == "__main__":
    rospy.init_node("steering_methods_test")
    rostest.rosrun("sdc_package", "steering_methods", SteeringMethodsTest)
