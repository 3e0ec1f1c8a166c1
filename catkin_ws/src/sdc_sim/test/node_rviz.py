#!/usr/bin/python3
"""Test of RViz with the packaged configuration on a virtual display."""

import signal
import subprocess
import unittest

import psutil
import rosgraph
import rospy
import rostest
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped, TransformStamped
from sdc_msgs.msg import BaseWaypoint, Path
from tf2_msgs.msg import TFMessage

from sdc_common.processes import matching, wait_until
from sdc_common.virtual_display import VirtualDisplay
from sdc_testing import MessageListener

SUBSCRIBED = {
    "/show/route",
    "/show/road",
    "/show/car",
    "/show/local_path",
    "/show/gnss",
    "/carla/ego_vehicle/lidar/front/point_cloud",
    "/carla/ego_vehicle/lidar/planar/point_cloud",
    "/carla/markers",
    "/camera/lane_mask",
    "/tf",
    "/carla/ego_vehicle/camera/rgb/front/image_color",
}
PUBLISHED = {"/initialpose", "/clicked_point"}
# Pixel of the window on the road ahead of the car.
ON_THE_ROAD = (815, 560)
LIMIT_S = 120.0
STARTS = 3


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
        cls.starts = 0
        cls.start()

    @classmethod
    def start(cls):
        cls.starts += 1
        cls.launch = subprocess.Popen(
            ["roslaunch", "sdc_sim", "rviz.launch"], env=cls.display.environment
        )
        cls.addClassCleanup(cls.stop)
        wait_until(cls.window_or_end, LIMIT_S, "RViz's window")

    @classmethod
    def window_or_end(cls):
        return cls.display.windows("drive.rviz") or cls.has_died()

    @classmethod
    def has_died(cls):
        """Return whether RViz has been started and has ended."""
        nodes = psutil.Process(cls.launch.pid).children()
        started = matching(nodes, lambda node: node.name() == "show.py")
        return bool(started) and not matching(nodes, lambda node: node.name() == "rviz")

    @classmethod
    def wait_until(cls, condition, what):
        """Wait, and start RViz again if it dies, as its first second once did in its own code."""

        def checked():
            if cls.has_died() and cls.starts < STARTS:
                cls.stop()
                cls.start()
            return condition()

        return wait_until(checked, LIMIT_S, what)

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

    @staticmethod
    def topics_of_rviz():
        """Return the topics that the node /rviz publishes and those that it subscribes to."""
        publishers, subscribers, _ = rosgraph.Master("/rviz_test").getSystemState()
        return [
            {topic for topic, nodes in side if "/rviz" in nodes}
            for side in (publishers, subscribers)
        ]

    def test_1_rviz_subscribes_to_the_drive_and_publishes_clicks(self):
        def connected():
            publishes, subscribes = self.topics_of_rviz()
            return subscribes >= SUBSCRIBED and publishes >= PUBLISHED

        self.wait_until(connected, f"RViz's subscriptions {sorted(SUBSCRIBED)}")

    def test_2_rviz_shows_road_and_car(self):
        def seen():
            picture = self.display.picture()
            blue, green, red = picture[:, 370:].reshape(-1, 3).astype(int).T
            asphalt = (abs(red - green) < 12) & (abs(green - blue) < 12) & (red > 50) & (red < 120)
            grass = (green > red + 8) & (green > blue + 20)
            car = (blue > 80) & (red < 0.5 * blue)
            return asphalt.mean() > 0.05 and grass.mean() > 0.2 and car.mean() > 0.002

        self.wait_until(seen, "asphalt, grass and a blue car")

    def test_3_publish_point_hits_the_road(self):
        self.click(
            "c",
            "/clicked_point",
            PointStamped,
            lambda: self.display.click(*ON_THE_ROAD),
            lambda message: (message.header.frame_id, message.point),
        )

    def test_4_pose_estimate_is_on_the_road(self):
        x, y = ON_THE_ROAD
        self.click(
            "p",
            "/initialpose",
            PoseWithCovarianceStamped,
            lambda: self.display.drag(x, y, x, y - 60),
            lambda message: (message.header.frame_id, message.pose.pose.position),
        )

    def click(self, tool, topic, message_class, act, place):
        """Select a tool by its key, use it, and expect a point on the road ahead of the car."""
        listener = MessageListener(topic, message_class)
        before = len(listener.messages)

        def clicked():
            self.display.move(*ON_THE_ROAD)
            self.display.press(tool)
            act()
            return len(listener.messages) > before

        self.wait_until(clicked, f"a message on {topic}")
        frame, point = place(listener.messages[-1])
        self.assertEqual(frame, "map")
        self.assertTrue(0.0 < point.x < 60.0 and abs(point.y) < 5.0 and abs(point.z) < 1.0, point)

    def test_5_closing_rviz_keeps_the_show_node(self):
        subprocess.run(["rosnode", "kill", "/rviz"], check=True, stdout=subprocess.DEVNULL)
        wait_until(lambda: self.topics_of_rviz() == [set(), set()], LIMIT_S, "RViz's end")
        self.assertIsNone(self.launch.poll())
        subprocess.run(
            ["rosnode", "ping", "-c1", "/show"],
            check=True,
            stdout=subprocess.DEVNULL,
            timeout=LIMIT_S,
        )


if __name__ == "__main__":
    rospy.init_node("rviz_test")
    rostest.rosrun("sdc_sim", "rviz_test", RvizTest)
