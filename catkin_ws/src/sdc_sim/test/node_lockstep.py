#!/usr/bin/env python3
"""Pause, step, resume, reset and manual control in lockstep; the test is the stack."""

import re
import subprocess
import threading
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger

from sdc_common.processes import wait_until
from sdc_common.ros.odometry import pose_and_speed
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000


class LockstepTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.throttle = 0.5
        cls.answering = threading.Event()
        cls.answering.set()
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        cls.manual = rospy.Publisher(
            EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl, queue_size=100
        )
        cls.override = rospy.Publisher(
            EGO + "/vehicle_control_manual_override", Bool, queue_size=10
        )
        for publisher in (cls.command, cls.manual, cls.override):
            wait_for_subscriber(publisher)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        rospy.Subscriber(EGO + "/odometry", Odometry, cls.answer, tcp_nodelay=True)
        cls.odometry.wait_for(lambda odometry: odometry.header.stamp.to_nsec() > 20 * TICK_NS)

    @classmethod
    def answer(cls, odometry):
        if cls.answering.is_set():
            cls.command.publish(CarlaVehicleControl(header=odometry.header, throttle=cls.throttle))

    def setUp(self):
        self.__class__.throttle = 0.5
        self.call("resume")

    def call(self, service):
        """Call a service of the sim; return the tick in its answer."""
        answer = rospy.ServiceProxy("/sim/" + service, Trigger)()
        self.assertTrue(answer.success)
        return int(answer.message.rsplit(" ", 1)[1])

    def stamps(self):
        return [odometry.header.stamp.to_nsec() for odometry in self.odometry.messages]

    def test_pause_stops_step_takes_one_tick_and_resume_loses_none(self):
        paused_at = self.call("pause") * TICK_NS
        wait_until(lambda: self.stamps()[-1] == paused_at, what="the tick of the pause")
        for step in range(1, 4):
            self.assertEqual(
                self.call("pause") * TICK_NS,
                paused_at + (step - 1) * TICK_NS,
                "a paused simulation does not advance",
            )
            self.call("step")
            wait_until(
                lambda due=paused_at + step * TICK_NS: self.stamps()[-1] == due, what=f"step {step}"
            )
        self.call("resume")
        wait_until(
            lambda: self.stamps()[-1] > paused_at + 50 * TICK_NS, what="ticks after resuming"
        )
        stamps = self.stamps()
        self.assertEqual({b - a for a, b in zip(stamps[5:], stamps[6:])}, {TICK_NS})

    def test_late_subscriber_receives_each_tick_once_from_the_first_one(self):
        first = self.stamps()[:15]
        self.assertEqual(first, [n * TICK_NS for n in range(1, 16)])

    def test_node_that_connects_during_a_pause_receives_the_present_tick(self):
        paused_at = self.call("pause") * TICK_NS
        echo = ["rostopic", "echo", "-n", "1", EGO + "/odometry/header/stamp"]
        output = subprocess.run(echo, capture_output=True, text=True, check=True, timeout=30.0)
        seconds, nanoseconds = map(int, re.findall(r"secs: *(\d+)", output.stdout))
        self.assertEqual(seconds * 10**9 + nanoseconds, paused_at)

    def test_only_the_command_with_the_stamp_of_the_last_odometry_answers_it(self):
        paused_at = self.call("pause") * TICK_NS
        wait_until(lambda: self.stamps()[-1] == paused_at, what="the tick of the pause")
        self.answering.clear()
        try:
            self.call("step")
            wait_until(
                lambda: self.stamps()[-1] == paused_at + TICK_NS,
                what="a step, whose odometry has its answer",
            )
            self.call("step")
            last = self.odometry.messages[-1]
            for ticks in (-3, 0, 400):
                header = Header(stamp=rospy.Time(nsecs=paused_at + ticks * TICK_NS))
                self.command.publish(CarlaVehicleControl(header=header, throttle=self.throttle))
            time.sleep(0.3)
            self.assertEqual(self.call_tick(), paused_at // TICK_NS + 1, "there is no answer yet")
        finally:
            self.answering.set()
        self.answer(last)
        wait_until(
            lambda: self.stamps()[-1] == paused_at + 2 * TICK_NS,
            what="the step that waited for the answer",
        )

    def call_tick(self):
        """Return the present tick; a reset does not change it."""
        return self.call("reset")

    def test_reset_places_the_car_at_its_start_while_time_continues(self):
        self.odometry.wait_for(lambda odometry: pose_and_speed(odometry)[3] > 3.0)
        before = self.call("reset")
        after = self.odometry.wait_for(
            lambda odometry: odometry.header.stamp.to_nsec() > before * TICK_NS
        )
        self.assertLess(abs(pose_and_speed(after)[0]), 0.5)
        self.assertLess(pose_and_speed(after)[3], 0.5)

    def test_manual_commands_drive_while_the_stack_keeps_answering(self):
        self.call("reset")
        self.__class__.throttle = 0.0
        self.override.publish(True)

        def accepts(odometry):
            self.manual.publish(CarlaVehicleControl(throttle=0.7))
            return pose_and_speed(odometry)[3] > 5.0

        try:
            self.odometry.wait_for(accepts, after=len(self.odometry.messages))
        finally:
            self.override.publish(False)
        fast = pose_and_speed(self.odometry.messages[-1])[3]
        self.odometry.wait_for(
            lambda odometry: pose_and_speed(odometry)[3] < fast - 1.0,
            after=len(self.odometry.messages),
        )


if __name__ == "__main__":
    rospy.init_node("lockstep_test")
    rostest.rosrun("sdc_sim", "lockstep_test", LockstepTest)
