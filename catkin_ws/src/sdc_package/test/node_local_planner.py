#!/usr/bin/python3
"""The local planner answers each odometry once, refuses bad messages, and ends a route properly."""

import math
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import ObstacleArray
from sdc_package.msg import BaseWaypoint, LocalPath, Path

from sdc_testing import MessageListener, wait_for_subscriber

LENGTH = 60


def odometry(number, x, y=0.0, yaw=0.0):
    message = Odometry()
    message.header.stamp = rospy.Time(number)
    message.header.frame_id = "map"
    message.pose.pose.position.x = x
    message.pose.pose.position.y = y
    message.pose.pose.orientation.z = math.sin(yaw / 2)
    message.pose.pose.orientation.w = math.cos(yaw / 2)
    return message


class LocalPlannerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)
        cls.odometry = rospy.Publisher("/carla/ego_vehicle/odometry", Odometry, queue_size=10)
        cls.obstacles = rospy.Publisher(
            "/carla/ego_vehicle/obstacles", ObstacleArray, queue_size=10
        )
        cls.path = MessageListener("/planner/local_waypoints", LocalPath)
        wait_for_subscriber(cls.odometry)
        wait_for_subscriber(cls.obstacles)
        cls.path.wait_for_publisher()
        cls.number = 100
        # As in a lockstep start, one odometry arrives before the mission and is not repeated.
        cls.odometry.publish(odometry(cls.number, 0.0))
        cls.mission.publish([BaseWaypoint(x, 0.0) for x in range(LENGTH + 1)])
        cls.path.wait_for()

    def answer(self, x, y=0.0, yaw=0.0, obstacles=None):
        before = len(self.path.messages)
        type(self).number += 1
        if obstacles is not None:
            message = ObstacleArray(obstacles=obstacles)
            message.header.stamp = rospy.Time(self.number)
            self.obstacles.publish(message)
        self.odometry.publish(odometry(self.number, x, y, yaw))
        return self.path.wait_for(after=before)

    def test_late_subscriber_receives_the_last_path(self):
        self.answer(20.0)
        late = MessageListener("/planner/local_waypoints", LocalPath)
        self.assertEqual(late.wait_for(), self.path.messages[-1])

    def test_bad_odometry_is_not_answered(self):
        before = len(self.path.messages)
        for x, y, yaw in (
            (math.nan, 0.0, 0.0),
            (0.0, math.inf, 0.0),
            (5.0, 0.0, math.nan),
            (5.0, 200.0, 0.0),
        ):
            type(self).number += 1
            self.odometry.publish(odometry(self.number, x, y, yaw))
        path = self.answer(30.0)
        self.assertEqual(len(self.path.messages), before + 1)
        self.assertEqual(path.waypoints[0].x, 30.0)

    def test_bad_mission_is_refused_and_the_last_one_is_kept(self):
        self.mission.publish([BaseWaypoint(0.0, 0.0)])
        self.mission.publish([BaseWaypoint(math.nan, 0.0), BaseWaypoint(1.0, 0.0)])
        self.assertEqual(self.answer(40.0).waypoints[0].x, 40.0)


if __name__ == "__main__":
    rospy.init_node("local_planner_test")
    rostest.rosrun("sdc_package", "local_planner", LocalPlannerTest)
