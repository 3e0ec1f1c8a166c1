"""Control commands from ROS topics to the simulation."""

from __future__ import annotations

from typing import Any

import rospy
from ackermann_msgs.msg import AckermannDrive
from std_msgs.msg import Bool

from sdc_sim.ros.connections import is_connected
from sdc_sim.ros.loop_lock import LoopLock
from sdc_sim.ros.message_conversion import ackermann_target, command_of
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.simulation.command_mux import AnswerTracker, AnyCommand, CommandArbiter

# After this time without a command of the active publisher, another one may take control.
_HANDOVER_S = 0.5


class CommandInput:
    """Gives commands to the simulation while the loop waits.

    Args:
        setup: the simulation, its topics, and who serves ackermann_cmd
        lock: the lock of the loop
    """

    def __init__(self, setup: SimulationSetup, lock: LoopLock):
        self.topic = setup.ego + "/vehicle_control_cmd"  # name of the topic of control commands
        self.answers = AnswerTracker()  # which observation the commands have answered
        self._simulation = setup.simulation
        self._lockstep = setup.values.sync
        self._drive_log = setup.drive_log
        self._arbiter = CommandArbiter(round(_HANDOVER_S / setup.simulation.tick_s))
        self._targets = setup.ego + "/ackermann_cmd"
        self._leaves_targets = setup.values.ackermann_cmd == "auto"
        control_class = setup.bridge.control_class

        def subscriber(topic: str, message_class: type, callback: Any) -> rospy.Subscriber:
            on_message = lock.guarded(callback)
            return rospy.Subscriber(
                topic, message_class, on_message, queue_size=10, tcp_nodelay=True
            )

        self._subscribers = [subscriber(self.topic, control_class, self._on_control)]
        if setup.values.ackermann_cmd:
            self._subscribers.append(subscriber(self._targets, AckermannDrive, self._on_target))
        subscriber(self.topic + "_manual", control_class, self._on_manual_control)
        subscriber(setup.ego + "/vehicle_control_manual_override", Bool, self._on_override)

    @property
    def has_publisher(self) -> bool:
        """Whether a publisher of software commands is connected."""
        return any(map(is_connected, self._subscribers))

    def give_up(self) -> None:
        """Record that the next tick starts without an answer; any publisher may take control."""
        if self.answers.by_stamp:
            rospy.logwarn_throttle(
                5.0, "sim: no command has the stamp of the last odometry; the next tick starts"
            )
        self.answers.give_up()
        self._arbiter.release()

    def _on_control(self, message: Any) -> None:
        publisher = message._connection_header["callerid"]
        if not self._arbiter.admits(publisher, self._simulation.tick):
            rospy.logwarn_throttle(
                5.0,
                f"sim: ignored commands of {publisher} on {self.topic}: {self._arbiter.active} "
                "has control; stop one of the two nodes",
            )
            return
        if self._drive_log:
            self._drive_log.add_command(message)
        stamp_ns, observed_ns = message.header.stamp.to_nsec(), self._simulation.snapshot.stamp_ns
        if self._lockstep and self.answers.is_repeated(stamp_ns, observed_ns):
            return
        if self._accept(command_of(message), self.topic):
            self.answers.record(stamp_ns, observed_ns)
            if self._lockstep and not self.answers.by_stamp:
                rospy.loginfo_once(
                    "sim: commands have no stamp of an odometry; the first one after a tick "
                    "answers it"
                )

    def _on_target(self, message: AckermannDrive) -> None:
        # Such as carla_ackermann_control, which turns the targets into control commands.
        if self._leaves_targets and self._arbiter.in_control(self._simulation.tick):
            rospy.logwarn_throttle(
                5.0,
                f"sim: ignored targets on {self._targets}: {self._arbiter.active} sends commands "
                f"on {self.topic} (parameter ackermann_cmd)",
            )
        elif self._accept(target := ackermann_target(message), self._targets):
            observed_ns = self._simulation.snapshot.stamp_ns
            if self._drive_log:
                self._drive_log.add_target(observed_ns, target)
            self.answers.record(0, observed_ns)

    def _on_manual_control(self, message: Any) -> None:
        self._accept(command_of(message), self.topic + "_manual", manual=True)

    def _on_override(self, message: Bool) -> None:
        self._simulation.commands.set_manual_override(message.data, self._simulation.tick)

    def _accept(self, command: AnyCommand, topic: str, manual: bool = False) -> bool:
        """Give a command to the simulation; return whether it was accepted."""
        try:
            if self._simulation.accept(command, manual):
                rospy.logwarn_throttle(1.0, f"sim: clamped a command on {topic} to its range")
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a command on {topic}: {error}")
            return False
        return True
