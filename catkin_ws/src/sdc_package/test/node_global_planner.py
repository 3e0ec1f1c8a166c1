#!/usr/bin/python3
"""The global planner publishes the mission with its limits, and another one when it is needed."""

import contextlib
import subprocess
import tempfile
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sdc_msgs.srv import CloseLane
from sdc_package.msg import LocalPath, Path

from sdc_testing import MessageListener, wait_for_subscriber
from sdc_testing.street_maps import is_installed, town

TOPIC = "/planner/mission_waypoints"


def start_node(name, **parameters):
    for key, value in parameters.items():
        rospy.set_param(f"/{name}/{key}", value)
    command = ["rosrun", "sdc_package", "global_planner.py", f"__name:={name}"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


@unittest.skipUnless(is_installed, "docker/prepare maps has not been run")
class GlobalPlannerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.map = town(cls.folder.name)
        cls.node = start_node("global_planner", map=cls.map, goals=[[250.0, -2.0]])
        cls.odometry = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=10)
        cls.goal = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=1)
        wait_for_subscriber(cls.odometry)
        wait_for_subscriber(cls.goal)

    @classmethod
    def tearDownClass(cls):
        cls.node.terminate()
        cls.node.communicate()
        cls.folder.cleanup()

    def mission_that_ends_near(self, x, y):
        """Publish the odometry of a car in the west until a mission ends there; return it."""
        odometry = Odometry()
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = -140.0, -1.6
        odometry.pose.pose.orientation.w = 1.0
        listener = MessageListener(TOPIC, Path)

        def ends_there(path):
            last = path.waypoints[-1]
            return abs(last.x - x) < 3.0 and abs(last.y - y) < 3.0

        for number in range(1, 40):
            odometry.header.stamp = rospy.Time(number)
            self.odometry.publish(odometry)  # a goal may arrive after it
            with contextlib.suppress(TimeoutError):
                return listener.wait_for(ends_there, 0.5).waypoints
        raise AssertionError(f"no mission ends near ({x}, {y})")

    def test_missions_of_a_drive(self):
        first = self.mission_that_ends_near(250.0, -1.6)
        limits = MessageListener("/planner/mission_speed_limits", LocalPath).wait_for().waypoints
        self.assertEqual([(one.x, one.y) for one in first], [(one.x, one.y) for one in limits])
        self.assertEqual({one.v for one in limits}, {14.0})
        goal = PoseStamped()
        goal.pose.position.x, goal.pose.position.y = -2.0, -110.0
        self.goal.publish(goal)
        self.mission_that_ends_near(-1.6, -110.0)
        close = rospy.ServiceProxy("/planner/close_lane", CloseLane)
        answer = close("nowhere")
        self.assertEqual(
            (answer.success, answer.message), (False, "the map town has no lane 'nowhere'")
        )
        self.assertTrue(close("c_1").success)

    def test_bad_map_and_goal_end_the_node_with_one_line(self):
        for parameters, words in (
            ({"map": "/none.xodr", "goals": []}, "/none.xodr: cannot be read"),
            ({"map": self.map, "goals": [[1.0]]}, "not enough values to unpack"),
        ):
            node = start_node("bad", **parameters)
            output, _ = node.communicate(timeout=60)
            self.assertEqual(node.returncode, 1, output)
            self.assertIn(words, output)
            self.assertNotIn("Traceback", output)
        rospy.delete_param("/bad")


if __name__ == "__main__":
    rospy.init_node("global_planner_test")
    rostest.rosrun("sdc_package", "global_planner", GlobalPlannerTest)
