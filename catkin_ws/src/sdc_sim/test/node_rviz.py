#!/usr/bin/python3
"""Test of RViz with the packaged configuration on a virtual display."""

import signal
import subprocess
import unittest

import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, TransformStamped
from sdc_msgs.msg import BaseWaypoint, Path
from tf2_msgs.msg import TFMessage

from sdc_common.processes import matching, processes_with, wait_until
from sdc_testing import MessageListener
from sdc_testing.virtual_display import VirtualDisplay

# Pixel of the window on the road ahead of the car.
ON_THE_ROAD = (815, 560)
LIMIT_S = 120.0


class RvizTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)
        cls.mission.publish(Path([BaseWaypoint(x, 0.0) for x in range(-20, 200)]))
        cls.transform = rospy.Publisher("/tf", TFMessage, queue_size=1)
        rospy.Timer(rospy.Duration(0.1), cls.publish_transform)
        cls.display = VirtualDisplay()
        cls.display.__enter__()
        cls.addClassCleanup(cls.display.__exit__)
        cls.launch = subprocess.Popen(
            ["roslaunch", "sdc_sim", "rviz.launch"], env=cls.display.environment
        )
        cls.addClassCleanup(cls.stop)
        wait_until(lambda: cls.display.windows("drive.rviz"), LIMIT_S, "RViz's window")
        # The tests look at the RViz that is started after a crash.
        found = processes_with("DISPLAY", cls.display.environment["DISPLAY"])
        [rviz] = matching(found, lambda process: process.name() == "rviz")
        rviz.send_signal(signal.SIGABRT)
        rviz.wait()
        wait_until(lambda: cls.display.windows("drive.rviz"), LIMIT_S, "RViz's window again")

    @classmethod
    def publish_transform(cls, _event):
        transform = TransformStamped()
        transform.header.stamp = rospy.Time.now()
        transform.header.frame_id, transform.child_frame_id = "map", "ego_vehicle"
        transform.transform.rotation.w = 1.0
        cls.transform.publish([transform])

    @classmethod
    def stop(cls):
        cls.launch.send_signal(signal.SIGINT)
        cls.launch.communicate(timeout=LIMIT_S)

    def test_1_rviz_shows_road_and_car(self):
        def seen():
            picture = self.display.picture()
            blue, green, red = picture[:, 370:].reshape(-1, 3).astype(int).T
            asphalt = (abs(red - green) < 12) & (abs(green - blue) < 12) & (red > 50) & (red < 120)
            grass = (green > red + 8) & (green > blue + 20)
            car = (blue > 80) & (red < 0.5 * blue)
            return asphalt.mean() > 0.05 and grass.mean() > 0.2 and car.mean() > 0.002

        wait_until(seen, LIMIT_S, "asphalt, grass and a blue car")

    def test_2_point_and_pose_are_on_the_road(self):
        x, y = ON_THE_ROAD
        clicked = self.use("c", lambda: self.display.click(x, y), "/clicked_point", PointStamped)
        drag = "mousemove", x, y, "mousedown", 1, "mousemove", x, y - 30, "mousemove", x, y - 60
        draw = lambda: self.display.xdotool(*drag, "mouseup", 1)  # noqa: E731
        estimate = self.use("p", draw, "/initialpose", PoseWithCovarianceStamped)
        for one, point in ((clicked, clicked.point), (estimate, estimate.pose.pose.position)):
            self.assertEqual(one.header.frame_id, "map")
            on_the_road = 0.0 < point.x < 60.0 and abs(point.y) < 5.0 and abs(point.z) < 1.0
            self.assertTrue(on_the_road, point)

    def use(self, tool, act, topic, message_class):
        """Select a tool by its key and use it until RViz publishes a message; return that."""
        listener = MessageListener(topic, message_class)

        def is_published():
            self.display.xdotool("mousemove", *ON_THE_ROAD)
            self.display.xdotool("key", tool)
            act()
            return listener.messages

        return wait_until(is_published, LIMIT_S, f"a message on {topic}")[-1]

    def test_3_closing_rviz_keeps_the_show_node(self):
        master = rosgraph.Master("/rviz_test")
        subprocess.run(["rosnode", "kill", "/rviz"], check=True, stdout=subprocess.DEVNULL)
        wait_until(lambda: "'/rviz'" not in str(master.getSystemState()), LIMIT_S, "RViz's end")
        self.assertIsNone(self.launch.poll())
        self.assertIn("'/show'", str(master.getSystemState()))


if __name__ == "__main__":
    rospy.init_node("rviz_test")
    rostest.rosrun("sdc_sim", "rviz_test", RvizTest)
