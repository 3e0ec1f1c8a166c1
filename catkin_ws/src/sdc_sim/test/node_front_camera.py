#!/usr/bin/env python3
"""The processes of the camera in lockstep: a picture of every tick, also after a crash."""

import unittest
from xmlrpc.client import ServerProxy

import psutil
import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from sensor_msgs.msg import Image

from sdc_common.testing.message_listener import MessageListener, wait_for_subscriber, wait_until

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000
TICKS = 60


def camera_pid():
    """Return the process id of the node, or None while it restarts."""
    try:
        uri = rospy.get_master().lookupNode("/front_camera")[2]
        return ServerProxy(uri).getPid("/front_camera_test")[2]
    except (OSError, rospy.ROSException):
        return None


class FrontCameraTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.images = MessageListener("/remapped_image", Image)
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        wait_for_subscriber(cls.command)
        rospy.Subscriber(EGO + "/odometry", Odometry, cls.answer, tcp_nodelay=True)
        cls.images.wait_for(seconds=60.0)

    @classmethod
    def answer(cls, odometry):
        cls.command.publish(CarlaVehicleControl(header=odometry.header, throttle=0.4))

    def stamps(self):
        return [image.header.stamp.to_nsec() for image in self.images.messages]

    def wait_for_pictures(self):
        """Return the stamps of the next pictures."""
        start = len(self.images.messages)
        wait_until(lambda: len(self.images.messages) >= start + TICKS, 60.0, f"{TICKS} pictures")
        return self.stamps()[start : start + TICKS]

    def test_every_tick_has_a_picture(self):
        first = self.wait_for_pictures()[-1]
        last = self.wait_for_pictures()[-1]
        stamps = [stamp for stamp in self.stamps() if first <= stamp <= last]
        self.assertEqual(stamps, list(range(first, last + TICK_NS, TICK_NS)))

    def test_killed_objects_process_restarts_while_the_simulation_continues(self):
        self.kill_and_wait(psutil.Process(camera_pid()))

    def test_killed_background_process_restarts_while_the_simulation_continues(self):
        self.kill_and_wait(psutil.Process(camera_pid()).parent())

    def kill_and_wait(self, process):
        pid = camera_pid()
        process.kill()
        wait_until(lambda: camera_pid() not in (None, pid), 60.0, "a new process")
        self.wait_for_pictures()


if __name__ == "__main__":
    rospy.init_node("front_camera_test")
    rostest.rosrun("sdc_sim", "front_camera", FrontCameraTest)
