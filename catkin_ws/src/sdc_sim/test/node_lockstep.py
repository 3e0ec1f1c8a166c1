#!/usr/bin/python3
"""Pause, step and resume in lockstep; the test is the stack."""

import threading
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from sdc_common.processes import wait_until
from sdc_testing import MessageListener, wait_for_subscriber

EGO = "/carla/ego_vehicle"
TICK_NS = 50_000_000


class LockstepTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.answering = threading.Event()
        cls.answering.set()
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=100
        )
        wait_for_subscriber(cls.command)
        cls.odometry = MessageListener(EGO + "/odometry", Odometry)
        rospy.Subscriber(EGO + "/odometry", Odometry, cls.answer, tcp_nodelay=True)
        cls.odometry.wait_for(lambda odometry: odometry.header.stamp.to_nsec() > 20 * TICK_NS)

    @classmethod
    def answer(cls, odometry):
        if cls.answering.is_set():
            cls.command.publish(CarlaVehicleControl(header=odometry.header, throttle=0.5))

    def setUp(self):
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
                self.command.publish(CarlaVehicleControl(header=header, throttle=0.5))
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


if __name__ == "__main__":
    rospy.init_node("lockstep_test")
    rostest.rosrun("sdc_sim", "lockstep_test", LockstepTest)
