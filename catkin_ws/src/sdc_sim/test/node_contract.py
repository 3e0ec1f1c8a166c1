#!/usr/bin/env python3
"""The contract of the bridge in real time: obstacles, placing, pausing, and commands in excess."""

import math
import unittest

import numpy as np
import rospy
import rostest
from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import CarlaCollisionEvent
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_msgs.msg import CarlaVehicleControl, ObstacleArray
from sensor_msgs.msg import Image
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
        cls.manual = publisher(EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl)
        cls.ackermann = publisher(EGO + "/ackermann_cmd", AckermannDrive)
        cls.pose = publisher("/initialpose", PoseWithCovarianceStamped)
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

    def drive_until(self, condition, publish=None, seconds=20.0, **command):
        """Send a command at each odometry until one fulfils the condition."""
        publish = publish or (lambda: self.command.publish(CarlaVehicleControl(**command)))

        def accepts(odometry):
            publish()
            return condition(*pose_and_speed(odometry))

        return self.next(self.odometry, accepts, seconds)

    def click_at(self, x, y, frame="map"):
        message = PointStamped()
        message.header.frame_id = frame
        message.point.x, message.point.y = x, y
        self.click.publish(message)

    def place(self, x, y, yaw=0.0):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = (
            math.sin(0.5 * yaw),
            math.cos(0.5 * yaw),
        )
        self.pose.publish(message)

    def test_clicked_obstacle_is_published_rendered_and_stops_the_car(self):
        images = MessageListener(EGO + "/camera/rgb/front/image_color", Image)
        before = self.pixels(images.wait_for())
        markers = MessageListener("/carla/markers", MarkerArray)
        self.click_at(15.0, 0.0)
        array = self.next(self.obstacles, lambda message: len(message.obstacles) == 1)
        obstacle = array.obstacles[0]
        self.assertEqual(
            (obstacle.kind, obstacle.pose.position.x, obstacle.speed), ("obstacle", 15.0, 0.0)
        )
        marker = markers.wait_for(lambda message: message.markers).markers[0]
        self.assertEqual(
            (marker.id, marker.action, marker.scale.x), (obstacle.id, Marker.ADD, obstacle.size.x)
        )
        # A part of its 23 x 23 pixels, 13.8 m in front of the camera.
        face = np.s_[256:274, 312:328]
        self.next(
            images, lambda image: np.abs(self.pixels(image)[face] - before[face]).mean() > 20.0
        )

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
        markers.wait_for(
            lambda message: (
                [m.action for m in message.markers if m.id == obstacle.id] == [Marker.DELETE]
            )
        )

    @staticmethod
    def pixels(image):
        return np.frombuffer(image.data, np.uint8).reshape(480, 640, 4)[:, :, :3].astype(int)

    def test_invalid_ackermann_and_manual_commands_are_refused_or_limited(self):
        self.drive_until(lambda x, y, yaw, speed: speed > 2.0, throttle=0.6)
        for bad in (math.nan, math.inf, -math.inf):
            self.ackermann.publish(AckermannDrive(speed=bad, steering_angle=bad))
            self.manual.publish(CarlaVehicleControl(throttle=bad, steer=bad, brake=bad))
        self.drive_until(lambda x, y, yaw, speed: speed == 0.0, brake=1.0)
        self.drive_until(
            lambda x, y, yaw, speed: speed > 2.0,
            publish=lambda: self.ackermann.publish(AckermannDrive(speed=1e9, steering_angle=-1e9)),
        )
        self.assertTrue(all(map(math.isfinite, pose_and_speed(self.odometry.messages[-1]))))

    def test_flood_of_commands_does_not_stop_the_simulation(self):
        """Send far more commands than there are ticks."""
        before = len(self.odometry.messages)
        for number in range(5000):
            self.command.publish(CarlaVehicleControl(throttle=0.6, steer=(-1.0) ** number))
        self.odometry.wait_for(lambda odometry: pose_and_speed(odometry)[3] > 0.5, after=before)
        self.drive_until(lambda x, y, yaw, speed: speed == 0.0, brake=1.0)

    def test_initial_pose_places_the_car(self):
        self.drive_until(lambda x, y, yaw, speed: speed > 2.0, throttle=0.7)
        # With the brake, the car stays where it is placed.
        self.drive_until(lambda x, y, yaw, speed: speed < 2.0, brake=1.0)
        before = len(self.odometry.messages)
        self.place(40.0, 30.0, 1.0)
        odometry = self.odometry.wait_for(
            lambda message: abs(message.pose.pose.position.x - 40.0) < 0.1, after=before
        )
        _, y, yaw, speed = pose_and_speed(odometry)
        self.assertAlmostEqual(y, 30.0)
        self.assertAlmostEqual(yaw, 1.0)
        self.assertEqual(speed, 0.0)

    def test_invalid_places_are_refused(self):
        for x, y in ((math.nan, 0.0), (math.inf, 0.0), (1e12, 0.0)):
            self.place(x, y)
        before = len(self.odometry.messages)
        self.place(40.0, 0.0)
        self.odometry.wait_for(lambda message: message.pose.pose.position.x == 40.0, after=before)
        for x, y in (
            (math.nan, 0.0),
            (math.inf, 0.0),
            (1e12, 0.0),
            (40.5, 0.0),
        ):  # The last one is on the car.
            self.click_at(x, y)
        self.click_at(20.0, 0.0, frame="camera")
        self.click_at(60.0, 0.0)
        array = self.next(self.obstacles, lambda message: message.obstacles)
        self.assertEqual([one.pose.position.x for one in array.obstacles], [60.0])

    def test_pause_step_and_resume_control_the_clock(self):
        clock = MessageListener("/clock", Clock)
        clock.wait_for()
        self.assertIn("paused", self.call("pause").message)
        paused_at = self.last_tick(clock)
        seen = len(self.odometry.messages)
        self.place(20.0, 0.0)
        shown = self.odometry.wait_for(
            lambda message: message.pose.pose.position.x == 20.0, after=seen
        )
        self.assertEqual(
            shown.header.stamp.to_nsec(),
            paused_at,
            "a paused simulation publishes a change at the same time",
        )
        for step in (1, 2):
            self.call("step")
            clock.wait_for(
                lambda message, due=paused_at + step * 50_000_000: message.clock.to_nsec() == due
            )
        self.assertIn("running", self.call("resume").message)
        clock.wait_for(lambda message: message.clock.to_nsec() > paused_at + 200_000_000)
        steps = np.diff([message.clock.to_nsec() for message in clock.messages])
        self.assertLessEqual(set(steps), {0, 50_000_000})

    def last_tick(self, clock):
        """Pause and return the time when its message has arrived."""
        frame = int(self.call("pause").message.rsplit(" ", 1)[1])
        return wait_until(
            lambda: clock.messages[-1].clock.to_nsec() == frame * 50_000_000 and frame * 50_000_000,
            what="the last tick",
        )


if __name__ == "__main__":
    # Of two waiting ticks, a node with simulated time receives only the last.
    rospy.init_node("contract_test", disable_rostime=True)
    rostest.rosrun("sdc_sim", "contract_test", ContractTest)
