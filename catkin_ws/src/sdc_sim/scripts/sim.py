#!/usr/bin/env python3
"""Simulator: waits for the command that answers the last odometry, steps, and publishes."""

import time

import rospy

from sdc_common.ros.node import spin_with
from sdc_sim.ros.command_input import CommandInput
from sdc_sim.ros.connections import Connections, missing_connections, wait_for_connections
from sdc_sim.ros.loop_lock import LoopLock
from sdc_sim.ros.services import PauseControl, SimulationServices
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.ros.simulation_topics import SimulationTopics

# In real time a picture, which needs both cores, starts after the answer, but no later than this.
PICTURE_DELAY_S = 0.01
REPEAT_AFTER_S = 0.5


class Sim:
    def __init__(self):
        rospy.init_node("sim", disable_rostime=True)  # This node publishes the time.
        setup = SimulationSetup()
        self.simulation = setup.simulation
        self.values = setup.values
        self.lockstep = setup.values.sync
        self.pause = PauseControl()
        self.lock = LoopLock()
        self.commands = CommandInput(setup, self.lock)
        self.answers = self.commands.answers
        self.topics = SimulationTopics(setup)
        self.starting = True
        self.failure = None
        self.observed_s = 0.0  # wall time of the last observation
        self.picture_due = False
        if setup.values.services:
            SimulationServices(self.lock, setup, self.pause, self.on_pause, self.on_change)

    def loop(self):
        with self.lock:
            self.topics.start_clock()
            if self.lockstep:
                self.wait_for_connections()
            self.next_tick_s = time.monotonic()
            self.answers.expect()  # An earlier command answers nothing.
            self.publish()
            if self.lockstep:
                self.lock.proceed = self.proceed
            while not rospy.is_shutdown():
                if self.lockstep:
                    self.wait_for_answer()
                else:
                    self.wait_for_clock()
                if self.failure:
                    raise self.failure
                self.advance()

    def advance(self):
        if self.pause.take():
            self.simulation.step()
            self.answers.expect()
            self.publish()

    def proceed(self):
        """Take the next tick, in the thread of the callback that received the answer."""
        if self.starting or self.failure or not self.is_answered():
            return False
        try:
            self.advance()
        except Exception as error:  # noqa: BLE001  The loop raises it, which ends the node.
            self.failure = error
        return not self.failure

    def wait_for_connections(self):
        limit_s, started_s = self.values.start_patience_s, time.monotonic()
        wait_for_connections(self.lock, self.missing_connections, limit_s)
        # A machine on which the connections took long also computes the first answer slowly.
        waited_s = time.monotonic() - started_s
        timeout_s = waited_s + max(self.values.first_answer_s, waited_s)
        self.start_deadline_s = started_s + min(limit_s, timeout_s)

    def missing_connections(self):
        missing = [] if self.commands.has_publisher else [f"a publisher of {self.commands.topic}"]
        if not self.topics.has_camera:
            missing.append("front_camera, which takes the pictures")
        odometry, topics = self.topics.odometry_topic, self.topics.tick_topics
        nodes = set(self.values.wait_for_nodes)
        return missing + missing_connections(Connections(), odometry, topics, nodes)

    def wait_for_answer(self):
        """Wait until a command answers the last observation, or until the timeout."""
        while not rospy.is_shutdown():
            if self.lock.wait_until(self.time_left_s(), self.is_answered) or self.failure:
                break
            if self.pause.waiting:
                self.observed_s = time.monotonic()
            if self.time_left_s() > 0.0:
                continue
            if not self.starting or time.monotonic() > self.start_deadline_s:
                self.commands.give_up()
                break
            rospy.loginfo_once(f"sim: waiting for a command on {self.commands.topic}")
            self.topics.publish()  # for a node that could not use the first odometry yet
            self.topics.publish_picture(again=True)
            self.observed_s = time.monotonic()
        self.starting = False

    def time_left_s(self):
        values, limit_s = self.values, REPEAT_AFTER_S
        if not self.starting:
            limit_s = values.patience_s if self.answers.by_stamp else values.unstamped_patience_s
        return self.observed_s + limit_s - time.monotonic()

    def is_answered(self):
        return self.answers.answered and not self.pause.waiting

    def wait_for_clock(self):
        """Wait until the wall clock reaches the next tick."""
        if self.picture_due:
            self.lock.wait_until(PICTURE_DELAY_S, lambda: self.answers.answered)
            self.topics.publish_picture()
            self.picture_due = False
        # An overloaded machine slows the simulation down; it does not catch up.
        self.next_tick_s = max(self.next_tick_s + self.simulation.tick_s, time.monotonic())
        self.lock.wait_until(self.next_tick_s - time.monotonic())

    def publish(self):
        self.observed_s = time.monotonic()
        self.topics.publish()
        if self.lockstep:
            self.topics.publish_picture()
        else:
            self.picture_due = True
        if self.simulation.commands.timed_out(self.simulation.tick):
            rospy.logwarn_throttle(5.0, f"sim: no command on {self.commands.topic}, braking")

    def on_pause(self):
        self.topics.publish_running(not self.pause.paused)

    def on_change(self):
        self.topics.lane_invasions.reset()  # a vehicle that was placed crossed no line
        if self.pause.waiting:
            self.simulation.observe_again()
            self.publish()

    def run(self):
        spin_with(self.loop)


if __name__ == "__main__":
    Sim().run()
