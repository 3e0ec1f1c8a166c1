#!/usr/bin/python3
"""Lockstep: pause, step and resume; a picture of every tick, also after a crash of the camera."""

import contextlib
import os
import signal
import subprocess
import threading
import time
import unittest
from xmlrpc.client import ServerProxy

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from sdc_common.processes import wait_until
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000
TICKS = 24


def camera_pid():
    """Return the process id of the node, or None while it restarts."""
    try:
        uri = rospy.get_master().lookupNode("/front_camera")[2]
        return ServerProxy(uri).getPid("/lockstep_test")[2]
    except (OSError, rospy.ROSException):
        return None


class LockstepTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.answering = threading.Event()
        cls.answering.set()
        cls.images = MessageListener("/remapped_image", Image)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        topic = EGO + "/vehicle_control_cmd"
        cls.command = rospy.Publisher(topic, CarlaVehicleControl, queue_size=100)
        wait_for_subscriber(cls.command)
        rospy.Subscriber(EGO + "/odometry", Odometry, cls.answer, tcp_nodelay=True)
        cls.images.wait_for(seconds=60.0)

    @classmethod
    def answer(cls, odometry):
        if cls.answering.is_set():
            cls.command.publish(CarlaVehicleControl(header=odometry.header, throttle=0.4))

    def setUp(self):
        self.call("resume")

    def call(self, service):
        """Call a service of the sim; return the tick in its answer."""
        answer = rospy.ServiceProxy("/sim/" + service, Trigger)()
        self.assertTrue(answer.success)
        return int(answer.message.rsplit(" ", 1)[1])

    def picture_stamps(self):
        return [image.header.stamp.to_nsec() for image in self.images.messages]

    def stamps(self):
        return [odometry.header.stamp.to_nsec() for odometry in self.odometry.messages]

    def wait_for_tick(self, tick):
        wait_until(lambda: self.stamps()[-1] == tick * TICK_NS, 60.0, f"tick {tick}")

    def wait_for_pictures(self):
        """Return the stamps of the next pictures."""
        start = len(self.images.messages)
        wait_until(lambda: len(self.images.messages) >= start + TICKS, 60.0, f"{TICKS} pictures")
        return self.picture_stamps()[start : start + TICKS]

    def test_pause_stops_step_takes_one_tick_and_resume_loses_none(self):
        paused_at = self.call("pause")
        self.wait_for_tick(paused_at)
        for step in range(1, 4):
            self.assertEqual(self.call("pause"), paused_at + step - 1, "it does not advance")
            self.call("step")
            self.wait_for_tick(paused_at + step)
        self.call("resume")
        later_ns = (paused_at + 50) * TICK_NS
        wait_until(lambda: self.stamps()[-1] > later_ns, 60.0, "ticks after resuming")
        stamps = self.stamps()
        self.assertEqual({b - a for a, b in zip(stamps[5:], stamps[6:])}, {TICK_NS})

    def test_nodes_that_only_watch_receive_the_odometry_last(self):
        topic, order = EGO + "/odometry", []
        self.call("pause")  # the nodes start faster

        def is_connected(name):
            listed = ServerProxy(rospy.get_master().lookupNode("/sim")[2]).getBusInfo("/lockstep")
            order[:] = [one[1] for one in listed[2] if one[4] == topic]
            return name in order

        with contextlib.ExitStack() as stack:
            for name in ("/referee", "/planner"):
                command = ["rostopic", "echo", topic, "__name:=" + name[1:]]
                node = stack.enter_context(subprocess.Popen(command, stdout=subprocess.DEVNULL))
                stack.callback(node.terminate)
                wait_until(lambda name=name: is_connected(name), 30.0, name)
        self.assertEqual((order[0], order[-1]), ("/planner", "/referee"))

    def test_late_subscriber_receives_each_tick_once_from_the_first_one(self):
        first = self.stamps()[:15]
        self.assertEqual(first, [n * TICK_NS for n in range(1, 16)])

    def test_only_the_command_with_the_stamp_of_the_last_odometry_answers_it(self):
        paused_at = self.call("pause")
        self.wait_for_tick(paused_at)
        self.answering.clear()
        try:
            self.call("step")
            self.wait_for_tick(paused_at + 1)
            self.call("step")
            last = self.odometry.messages[-1]
            for ticks in (-3, 0, 400):
                header = Header(stamp=rospy.Time(nsecs=(paused_at + ticks) * TICK_NS))
                self.command.publish(CarlaVehicleControl(header=header, throttle=0.5))
            time.sleep(0.3)
            # A reset does not change the tick in its answer.
            self.assertEqual(self.call("reset"), paused_at + 1, "there is no answer yet")
        finally:
            self.answering.set()
        self.answer(last)
        self.wait_for_tick(paused_at + 2)

    def test_every_tick_has_a_picture(self):
        first = self.wait_for_pictures()[-1]
        last = self.wait_for_pictures()[-1]
        stamps = [stamp for stamp in self.picture_stamps() if first <= stamp <= last]
        self.assertEqual(stamps, list(range(first, last + TICK_NS, TICK_NS)))

    def test_killed_camera_starts_again_while_the_simulation_continues(self):
        pid = camera_pid()
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: camera_pid() not in (None, pid), 60.0, "a new process")
        self.wait_for_pictures()


if __name__ == "__main__":
    rospy.init_node("lockstep_test")
    rostest.rosrun("sdc_sim", "lockstep_test", LockstepTest)
