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
# In real time /clock advances between two ticks as well: with steps of a tick, a loop at 50 Hz
# (rospy.Rate) would see time steps of 0.
CLOCK_STEP_S = 0.01
REPEAT_AFTER_S = 0.5


class Sim:
    def __init__(self):
        rospy.init_node("sim", disable_rostime=True)  # This node publishes the time.
        setup = SimulationSetup()
        self.world = setup.world
        self.values = setup.values
        self.lockstep = setup.values.sync
        self.pause = PauseControl()
        self.lock = LoopLock()
        self.cars = setup.cars
        self.commands = [CommandInput(car, self.lock) for car in self.cars]
        self.topics = [SimulationTopics(car) for car in self.cars]
        self.starting = True
        self.failure = None
        self.observed_s = 0.0  # wall time of the last observation
        self.picture_due = False
        if setup.values.services:
            SimulationServices(self.lock, setup, self.pause, self.on_pause, self.on_change)

    def loop(self):
        with self.lock:
            self.topics[0].start_clock()
            if self.lockstep:
                self.wait_for_connections()
            self.next_tick_s = time.monotonic()
            self.expect_answers()  # An earlier command answers nothing.
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
            self.world.step()
            self.expect_answers()
            self.publish()

    def expect_answers(self):
        for commands in self.commands:
            commands.answers.expect()

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
        missing, graph = [], Connections()
        for car, commands, topics in zip(self.cars, self.commands, self.topics):
            missing += [] if commands.has_publisher else [f"a publisher of {commands.topic}"]
            if not topics.has_camera:
                missing.append("front_camera, which takes the pictures")
            # The nodes of further cars are in groups with the names of the cars.
            group = "/" + car.values.role_name if car.number > 1 else ""
            nodes = {group + name for name in self.values.wait_for_nodes}
            names = topics.odometry_topic, topics.tick_topics, nodes
            missing += missing_connections(graph, *names)
        return missing

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
                for commands in self.unanswered:
                    commands.give_up()
                break
            names = " and ".join(commands.topic for commands in self.unanswered)
            rospy.loginfo_once(f"sim: waiting for a command on {names}")
            for topics in self.topics:
                topics.publish()  # for a node that could not use the first odometry yet
                topics.publish_picture(again=True)
            self.observed_s = time.monotonic()
        self.starting = False

    def time_left_s(self):
        values, limit_s = self.values, REPEAT_AFTER_S
        if not self.starting:
            by_stamp = any(command.answers.by_stamp for command in self.unanswered)
            limit_s = values.patience_s if by_stamp else values.unstamped_patience_s
        return self.observed_s + limit_s - time.monotonic()

    @property
    def unanswered(self):
        """Return the inputs of the cars whose last observation has no answer."""
        return [command for command in self.commands if not command.answers.answered]

    def is_answered(self):
        return not self.unanswered and not self.pause.waiting

    def wait_for_clock(self):
        """Wait until the wall clock reaches the next tick."""
        if self.picture_due:
            self.lock.wait_until(PICTURE_DELAY_S, lambda: not self.unanswered)
            self.publish_pictures()
            self.picture_due = False
        # An overloaded machine slows the simulation down; it does not catch up.
        self.next_tick_s = max(self.next_tick_s + self.world.tick_s, time.monotonic())
        steps = round(self.world.tick_s / CLOCK_STEP_S)
        for step in range(1, steps):
            left_s = self.next_tick_s - time.monotonic() - (steps - step) * CLOCK_STEP_S
            if left_s > 0.0:
                self.lock.wait_until(left_s)
            if not self.pause.waiting:
                self.topics[0].publish_clock(step * CLOCK_STEP_S)
        self.lock.wait_until(self.next_tick_s - time.monotonic())

    def publish(self):
        self.observed_s = time.monotonic()
        for topics in self.topics:
            topics.publish()
        if self.lockstep:
            self.publish_pictures()
        else:
            self.picture_due = True
        for car, commands in zip(self.cars, self.commands):
            if car.simulation.commands.timed_out(self.world.tick):
                rospy.logwarn_throttle(5.0, f"sim: no command on {commands.topic}, braking")

    def publish_pictures(self):
        for topics in self.topics:
            topics.publish_picture()

    def on_pause(self):
        self.topics[0].publish_running(not self.pause.paused)

    def on_change(self):
        for topics in self.topics:
            topics.lane_invasions.reset()  # a vehicle that was placed crossed no line
        if self.pause.waiting:
            self.world.observe_again()
            self.publish()

    def run(self):
        spin_with(self.loop)


if __name__ == "__main__":
    Sim().run()
