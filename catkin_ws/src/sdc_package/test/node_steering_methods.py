#!/usr/bin/python3
"""The controller runs with every steering method, and refuses one that cannot be built."""

import contextlib
import os
import subprocess
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_common.processes import wait_until
from sdc_package.steering.loader import METHODS
from sdc_testing import MessageListener, wait_for_subscriber

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
                "a subscription of all controllers",
            )

    def steer(self, x, y):
        """Return each controller's answer to a pair; publish the pair again if one misses it."""
        for _ in range(TRIES - 1):
            with contextlib.suppress(TimeoutError):
                return self.answers(x, y, LIMIT_S / TRIES)
        return self.answers(x, y, LIMIT_S / TRIES)

    def answers(self, x, y, seconds):
        odometry = Odometry()
        odometry.header.stamp = rospy.Time.now()
        odometry.pose.pose.position.x = x
        odometry.pose.pose.position.y = y
        odometry.pose.pose.orientation.w = 1.0
        odometry.twist.twist.linear.x = 5.0
        self.odometry.publish(odometry)
        self.path.publish(LocalPath([Waypoint(float(s), 0.0, 5.0) for s in range(30)]))

        def is_answer(command):
            is_stop = command.brake == 0.5 and command.steer == 0.0
            return command.header.stamp == odometry.header.stamp and not is_stop

        return {
            name: commands.wait_for(is_answer, seconds) for name, commands in self.commands.items()
        }

    def test_each_method_steers_back_to_the_path(self):
        self.steer(4.0, 0.3)
        left = self.steer(4.5, 0.3)
        for name, command in left.items():
            self.assertGreater(command.steer, 0.01, name)
        self.steer(4.0, -0.3)
        for name, command in self.steer(4.5, -0.3).items():
            self.assertLess(command.steer, -0.01, name)
        # Parallel to a straight path, the compensated law equals the textbook law.
        different = {round(command.steer, 5) for command in left.values()}
        self.assertEqual(len(different), len(CONTROLLERS) - 1)
        self.assertAlmostEqual(left["stanley"].steer, left["stanley_compensated"].steer, places=5)

    def test_method_that_cannot_be_built_ends_the_node_with_one_line(self):
        parameters = rospy.get_param("/stanley/simple_controller")
        cases = {
            "misspelt_name": (
                {"steering_method": "stanly"},
                "there is no steering_method 'stanly': did you mean 'stanley'?",
            ),
            "no_module": (
                {"steering_method": "nowhere:MySteering"},
                "No module named 'nowhere'",
            ),
            "no_section": (
                {"steering_method": "my_module:MySteering"},
                "section 'MySteering' does not fit",
            ),
            "out_of_range": (
                {"stanley": {"k": -1.0, "softening_mps": 1.0}},
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
        for name, (changes, part) in cases.items():
            with self.subTest(name):
                rospy.set_param("/" + name, {**parameters, **changes})
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
                lines = [line for line in done.stdout.splitlines() if part in line]
                self.assertEqual(len(lines), 1, done.stdout)
                self.assertIn("config/simple_controller.yaml", lines[0])
                self.assertNotIn("Traceback", done.stdout)


if __name__ == "__main__":
    rospy.init_node("steering_methods_test")
    rostest.rosrun("sdc_package", "steering_methods", SteeringMethodsTest)
