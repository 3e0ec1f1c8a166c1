#!/usr/bin/env python3
"""Simulator: waits for the command that answers the last odometry, steps, and publishes."""

import time

import rospy

from sdc_common.ros.node import spin_with
from sdc_sim.ros.command_input import CommandInput
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.ros.services import SimulationServices
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.ros.simulation_topics import SimulationTopics
from sdc_sim.ros.start_handshake import StartHandshake
from sdc_sim.simulation.pause import PauseControl

# In real time a picture, which needs both cores, starts after the answer, but no later than this.
PICTURE_DELAY_S = 0.01
REPEAT_AFTER_S = 0.5


class Sim:
    def __init__(self):
        rospy.init_node("sim", disable_rostime=True)  # This node publishes the time.
        setup = SimulationSetup()
        self.simulation = setup.simulation
        self.lockstep = setup.lockstep
        self.timeouts = setup.timeouts
        self.pause = PauseControl()

        self.requests = RequestQueue()
        self.commands = CommandInput(
            setup.ego,
            setup.bridge.control_class,
            self.simulation,
            self.requests,
            setup.lockstep,
            setup.ackermann_cmd,
            setup.drive_log,
        )
        self.topics = SimulationTopics(setup)
        if setup.services:
            SimulationServices(
                self.requests, setup, self.pause, on_pause=self.on_pause, on_change=self.on_change
            )
        self.handshake = StartHandshake(
            self.commands.subscribers,
            self.topics.odometry.resolved_name,
            self.topics.tick_topics,
            setup.wait_for_nodes,
            setup.timeouts.first_answer_s,
        )
        self.starting = True
        self.start_deadline_s = time.monotonic() + self.timeouts.start_s
        self.picture_due = False

    def loop(self):
        self.topics.start_clock()
        self.wait_for_connections()
        self.publish()
        while not rospy.is_shutdown():
            if self.lockstep:
                self.wait_for_answer()
            else:
                self.wait_for_clock()
            if self.pause.take():
                self.simulation.step()
                self.commands.expect()
                self.publish()

    def wait_for_connections(self):
        # In real time a stack may connect at any time.
        if self.lockstep:
            self.handshake.wait(self.start_deadline_s, self.requests)
        self.next_tick_s = time.monotonic()
        answer_s = self.handshake.answer_timeout_s
        self.start_deadline_s = min(self.start_deadline_s, self.next_tick_s + answer_s)

    def wait_for_answer(self):
        """Process requests until a command answers the last odometry, or until the timeout."""
        while not rospy.is_shutdown():
            if self.requests.process_until(time.monotonic() + self.timeout_s(), self.is_answered):
                break
            if self.pause.waiting:
                continue
            if self.starting and time.monotonic() < self.start_deadline_s:
                rospy.loginfo_once(f"sim: waiting for a command on {self.commands.topic}")
                self.topics.publish()  # for a node that could not use the first odometry yet
                self.topics.publish_picture(again=True)
                continue
            self.commands.give_up()
            break
        self.starting = False

    def timeout_s(self):
        if self.starting and not self.pause.waiting:
            return max(min(self.start_deadline_s - time.monotonic(), REPEAT_AFTER_S), 0.0)
        if self.commands.by_stamp or self.pause.waiting:
            return self.timeouts.answer_s
        return self.timeouts.unstamped_answer_s

    def is_answered(self):
        return self.commands.has_answer and not self.pause.waiting

    def wait_for_clock(self):
        """Process requests until the wall clock reaches the next tick."""
        if self.picture_due:
            picture_s = time.monotonic() + PICTURE_DELAY_S
            self.requests.process_until(picture_s, lambda: self.commands.received)
            self.topics.publish_picture()
            self.picture_due = False
        # An overloaded machine slows the simulation down; it does not catch up.
        self.next_tick_s = max(self.next_tick_s + self.simulation.tick_s, time.monotonic())
        self.requests.process_until(self.next_tick_s)

    def publish(self):
        self.topics.publish()
        if self.lockstep:
            self.topics.publish_picture()
        else:
            self.picture_due = True
        if self.simulation.command_timed_out:
            rospy.logwarn_throttle(5.0, f"sim: no command on {self.commands.topic}, braking")

    def on_pause(self):
        self.topics.bridge.publish_running(not self.pause.paused)

    def on_change(self):
        self.topics.bridge.reset_lane_invasion()
        if self.pause.waiting:
            self.simulation.observe_again()
            self.publish()

    def run(self):
        spin_with(self.loop)


if __name__ == "__main__":
    Sim().run()
