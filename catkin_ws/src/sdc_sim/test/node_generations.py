#!/usr/bin/python3
"""Each generation of the bridge has its topics, with their types, frames and latches."""

import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospkg
import rospy
import rostest
import yaml
from carla_msgs.msg import CarlaWeatherParameters
from geometry_msgs.msg import Pose, PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from sdc_common.processes import wait_until
from sdc_common.ros.odometry import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber

SIM = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts", "sim.py")
CAMERA = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts", "front_camera.py")
CAMERA_TOPICS = "weather_control", "hero/spectator_pose", "hero/rgb_view/control/set_transform"
OBSTACLES = """frame: route
obstacles:
  - {kind: car, at: [40.0, 0.0]}
  - {kind: obstacle, at: [60.0, 3.5]}
lights:
  - {stop_line_m: 80.0, phases: [{red: 600.0}]}
"""
EGO = "/carla/hero"
TABLE = Path(__file__).resolve().with_name("data") / "bridge_topics.yaml"
TOPICS = yaml.safe_load(TABLE.read_text(encoding="utf-8"))


def pixels(image):
    """Return the colours of a picture."""
    return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 4)[..., :3]


class GenerationsTest(unittest.TestCase):
    def start(self, generation):
        """Start a sim, and end it after the test."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        obstacles = os.path.join(folder.name, "obstacles.yaml")
        with open(obstacles, "w", encoding="utf-8") as file:
            file.write(OBSTACLES)
        name = "sim_" + generation.replace(".", "_")
        feed = os.path.join(folder.name, "pictures")
        rospy.set_param("/front_camera/picture_feed", feed)
        changes = {"bridge": generation, "obstacles_path": obstacles, "picture_feed": feed}
        rospy.set_param("/" + name, {**rospy.get_param("~good"), **changes})
        for command in ([SIM, "__name:=" + name], [CAMERA]):
            process = subprocess.Popen(["/usr/bin/env", "python3", *command])
            self.addCleanup(process.wait)
            self.addCleanup(process.terminate)
        wait_until(lambda: "/" + name in self.nodes(0, EGO + "/odometry"), what=name)
        return "/" + name

    @staticmethod
    def nodes(kind, topic):
        """Return the publishers (0) or the subscribers (1) of a topic."""
        return dict(rospy.get_master().getSystemState()[2][kind]).get(topic, ())

    def check_generation(self, generation):
        sim = self.start(generation)
        topics = TOPICS[generation]
        front = MessageListener(topics["pictures"]["front"], Image).wait_for(seconds=60.0)
        frame = topics["pictures"]["front"].rsplit("/", 1)[0]
        self.assertEqual(front.header.frame_id, frame[len("/carla/") :])
        for topic in topics["pictures"].values():
            self.assertIn("/front_camera", self.nodes(0, topic))
        types = dict(rospy.get_master().getTopicTypes()[2])
        published = {**TOPICS["common"], **topics["published"]}
        for topic, kind in published.items():
            self.assertEqual((topic, types.get(topic)), (topic, kind))
            rospy.wait_for_message(topic, rospy.AnyMsg, timeout=15.0)
        others = {topic for one in TOPICS.values() for topic in one.get("published", ())}
        others -= set(published)
        self.assertEqual([topic for topic in others if sim in self.nodes(0, topic)], [])
        for topic, kind in topics.get("subscribed", {}).items():
            self.assertEqual((topic, types.get(topic)), (topic, kind))
            node = "/front_camera" if topic[len("/carla/") :] in CAMERA_TOPICS else sim
            self.assertIn(node, self.nodes(1, topic))
        odometry = rospy.wait_for_message(EGO + "/odometry", Odometry, timeout=15.0)
        self.assertEqual((odometry.header.frame_id, odometry.child_frame_id), ("map", "hero"))

    def test_0_9_3(self):
        self.check_generation("0.9.3")

    def test_0_9_5(self):
        self.check_generation("0.9.5")
        self.check_velocity("/twist_cmd")

    def test_0_9_11(self):
        self.check_generation("0.9.11")
        self.check_velocity("/control/set_target_velocity")
        self.check_cameras()
        self.check_transform()

    def check_velocity(self, topic):
        publisher = rospy.Publisher(EGO + topic, Twist, queue_size=1)
        odometry = MessageListener(EGO + "/odometry", Odometry)
        wait_for_subscriber(publisher)
        twist = Twist()
        twist.linear.x, twist.angular.z = 5.0, 0.4

        def moves(message):
            publisher.publish(twist)
            return message.twist.twist.linear.x > 4.5 and message.twist.twist.angular.z > 0.05

        odometry.wait_for(moves)

    def check_cameras(self):
        """Weather, the camera behind the car, and the camera that a person moves."""
        pictures = TOPICS["0.9.11"]["pictures"]
        front = MessageListener(pictures["front"], Image)
        day = pixels(front.wait_for()).mean()
        weather = rospy.Publisher("/carla/weather_control", CarlaWeatherParameters, queue_size=1)
        wait_for_subscriber(weather)
        weather.publish(CarlaWeatherParameters(sun_altitude_angle=30.0))
        front.wait_for(lambda image: abs(pixels(image).mean() / day - 0.5) < 0.1)
        weather.publish(CarlaWeatherParameters(sun_altitude_angle=90.0))

        view = MessageListener(pictures["view"], Image).wait_for()
        self.assertEqual((view.width, view.height, view.encoding), (800, 600, "bgra8"))
        self.assertEqual(view.header.frame_id, "hero/rgb_view")

        pose = rospy.Publisher(EGO + "/spectator_pose", PoseStamped, queue_size=1)
        wait_for_subscriber(pose)
        spectator = MessageListener(pictures["spectator"], Image)
        spectator.wait_for_publisher()
        self.assertEqual(spectator.messages, [])
        message = PoseStamped()
        message.header.frame_id = "hero"
        message.pose.position.x, message.pose.position.z = -8.0, 3.0
        # x right, y up, z backward: it looks ahead.
        q = message.pose.orientation
        q.x, q.y, q.z, q.w = 0.5, -0.5, -0.5, 0.5
        pose.publish(message)
        self.assertEqual(spectator.wait_for().header.frame_id, "hero/spectator_view")

    def check_transform(self):
        publisher = rospy.Publisher(EGO + "/control/set_transform", Pose, queue_size=1)
        odometry = MessageListener(EGO + "/odometry", Odometry)
        wait_for_subscriber(publisher)
        pose = Pose()
        pose.position.x, pose.position.y, pose.orientation.w = 12.0, 3.0, 1.0
        publisher.publish(pose)
        placed = odometry.wait_for(lambda message: message.pose.pose.position.x == 12.0)
        self.assertEqual(pose_and_speed(placed)[1:], (3.0, 0.0, 0.0))
        pose.position.x = math.nan
        publisher.publish(pose)
        later = odometry.wait_for(after=len(odometry.messages))
        self.assertEqual(later.pose.pose.position.x, 12.0)


if __name__ == "__main__":
    rospy.init_node("generations_test")
    rostest.rosrun("sdc_sim", "generations_test", GenerationsTest)
