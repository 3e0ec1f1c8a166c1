#!/usr/bin/python3
"""The contract of the bridge in real time: topics, frames, stamps, commands, obstacles."""

import unittest

import cv2
import numpy as np
import rospy
import rostest
from carla_msgs.msg import CarlaCollisionEvent
from geometry_msgs.msg import PointStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl, ObstacleArray
from sensor_msgs.msg import CompressedImage, Image
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.processes import wait_until
from sdc_common.ros.odometry import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"


class ContractTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        def publisher(topic, kind):
            made = rospy.Publisher(topic, kind, queue_size=100)
            wait_for_subscriber(made)
            return made

        cls.command = publisher(EGO + "/vehicle_control_cmd", CarlaVehicleControl)
        cls.click = publisher("/clicked_point", PointStamped)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        cls.collision = MessageListener(EGO + "/collision", CarlaCollisionEvent)
        cls.obstacles = MessageListener(EGO + "/obstacles", ObstacleArray)
        for listener in (cls.odometry, cls.obstacles):
            listener.wait_for()
        cls.collision.wait_for_publisher()

    def setUp(self):
        self.call("resume")
        self.call("reset")
        self.next(self.odometry, lambda odometry: abs(odometry.pose.pose.position.x) < 0.1)

    def call(self, service):
        return rospy.ServiceProxy("/sim/" + service, Trigger)()

    def next(self, listener, accepts=lambda message: True, seconds=20.0):
        """Return the next message from now on that is accepted."""
        return listener.wait_for(accepts, seconds, after=len(listener.messages))

    def drive_until(self, condition, seconds=20.0, **command):
        """Send a command at each odometry until one fulfils the condition."""

        def accepts(odometry):
            self.command.publish(CarlaVehicleControl(**command))
            return condition(*pose_and_speed(odometry))

        return self.next(self.odometry, accepts, seconds)

    def click_at(self, x, y):
        message = PointStamped()
        message.header.frame_id = "map"
        message.point.x, message.point.y = x, y
        self.click.publish(message)

    def test_clicked_obstacle_is_published_rendered_and_stops_the_car(self):
        images = MessageListener(EGO + "/camera/rgb/front/image_color", Image)
        before = self.pixels(images.wait_for())
        markers = MessageListener("/carla/markers", MarkerArray)
        self.click_at(15.0, 0.0)
        array = self.next(self.obstacles, lambda message: len(message.obstacles) == 1)
        obstacle = array.obstacles[0]
        found = obstacle.kind, obstacle.pose.position.x, obstacle.speed
        self.assertEqual(found, ("obstacle", 15.0, 0.0))
        marker = markers.wait_for(lambda message: len(message.markers) > 1).markers[1]
        shown = marker.id, marker.action, marker.scale.x
        self.assertEqual(shown, (obstacle.id, Marker.ADD, obstacle.size.x))
        topic = EGO + "/camera/rgb/front/image_color/compressed"
        jpeg = MessageListener(topic, CompressedImage).wait_for()
        decoded = cv2.imdecode(np.frombuffer(jpeg.data, np.uint8), cv2.IMREAD_COLOR)
        self.assertEqual(decoded.shape, (480, 640, 3))
        # A part of its 23 x 23 pixels, 13.8 m in front of the camera.
        face = np.s_[256:274, 312:328]
        change = lambda image: np.abs(self.pixels(image)[face] - before[face]).mean()  # noqa: E731
        self.next(images, lambda image: change(image) > 20.0)

        seen = len(self.collision.messages)
        self.drive_until(lambda x, y, yaw, speed: len(self.collision.messages) > seen, throttle=0.7)
        event = self.collision.messages[seen]
        self.assertEqual(event.other_actor_id, obstacle.id)
        self.assertLess(event.normal_impulse.x, -1845.0)
        for _ in range(20):
            self.drive_until(lambda *pose: True, throttle=0.7)
        x, _, _, speed = pose_and_speed(self.odometry.messages[-1])
        self.assertAlmostEqual(x, 15.0 - 0.5 - 2.35, delta=0.05)
        self.assertLess(speed, 0.3)
        self.assertEqual(len(self.collision.messages), seen + 1, "a contact is one event")

        self.drive_until(lambda x, y, yaw, speed: x < 9.0, throttle=0.6, reverse=True)
        self.click_at(15.2, 0.3)
        self.next(self.obstacles, lambda message: not message.obstacles)
        markers.wait_for(lambda message: [m.action for m in message.markers] == [Marker.DELETEALL])

    @staticmethod
    def pixels(image):
        return np.frombuffer(image.data, np.uint8).reshape(480, 640, 4)[:, :, :3].astype(int)

    def test_clock_advances_at_100_hz_and_odometry_by_ticks(self):
        clock, first = MessageListener("/clock", Clock), len(self.odometry.messages)
        wait_until(lambda: len(clock.messages) > 20, what="twenty messages on /clock")
        steps = np.diff([message.clock.to_nsec() for message in clock.messages[:21]])
        self.assertEqual(set(steps), {10_000_000})
        self.odometry.wait_for(after=first + 3)
        stamps = [message.header.stamp.to_nsec() for message in self.odometry.messages[first:]]
        self.assertEqual(set(np.diff(stamps)), {50_000_000})
        odometry = self.odometry.messages[-1]
        frames = odometry.header.frame_id, odometry.child_frame_id
        self.assertEqual(frames, ("map", "ego_vehicle"))

    def test_clock_does_not_go_back_when_a_paused_world_is_reset(self):
        clock = MessageListener("/clock", Clock)
        for count in range(7, 42, 7):
            wait_until(lambda count=count: len(clock.messages) > count)
            self.call("pause")
            self.call("reset")
            self.call("resume")
        stamps = [message.clock.to_nsec() for message in clock.messages]
        self.assertGreaterEqual(min(np.diff(stamps)), 0)

    def test_flood_of_commands_does_not_stop_the_simulation(self):
        """Send far more commands than there are ticks."""
        before = len(self.odometry.messages)
        for number in range(5000):
            self.command.publish(CarlaVehicleControl(throttle=0.6, steer=(-1.0) ** number))
        self.odometry.wait_for(lambda odometry: pose_and_speed(odometry)[3] > 0.5, after=before)
        self.drive_until(lambda x, y, yaw, speed: speed == 0.0, brake=1.0)


if __name__ == "__main__":
    # Of two waiting ticks, a node with simulated time receives only the last.
    rospy.init_node("contract_test", disable_rostime=True)
    rostest.rosrun("sdc_sim", "contract_test", ContractTest)
