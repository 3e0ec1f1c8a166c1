"""Control commands from ROS topics to the simulation."""

from __future__ import annotations

from typing import Any

import rospy
from ackermann_msgs.msg import AckermannDrive
from std_msgs.msg import Bool

from sdc_sim.ros.ackermann_switch import AckermannSwitch
from sdc_sim.ros.drive_log import DriveLog
from sdc_sim.ros.message_conversion import ackermann_target, vehicle_command
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.simulation.answer_tracker import UNSTAMPED, AnswerTracker, Stamp
from sdc_sim.simulation.command_arbiter import CommandArbiter
from sdc_sim.simulation.command_mux import Command
from sdc_sim.simulation.simulation import Simulation

# After this time without a command of the active publisher, another one may take control.
_HANDOVER_S = 0.5


class CommandInput:
    """Gives commands to the simulation; the loop executes all of it.

    Args:
        ego: prefix of the topics of the vehicle
        control_class: message class of the control commands
        simulation: the simulation
        requests: requests to the loop
        lockstep: whether the stamp of a command decides which observation it answers
        ackermann_cmd: whether to serve ackermann_cmd; "auto": unless another node does
        drive_log: receives the commands

    Attributes:
        received: whether a software command was accepted since `expect`
        subscribers: subscribers to software commands
    """

    def __init__(
        self,
        ego: str,
        control_class: type,
        simulation: Simulation,
        requests: RequestQueue,
        lockstep: bool,
        ackermann_cmd: str | bool = "auto",
        drive_log: DriveLog | None = None,
    ):
        self.topic = ego + "/vehicle_control_cmd"
        self.received = False
        self._simulation = simulation
        self._drive_log = drive_log
        self._lockstep = lockstep
        self._answers = AnswerTracker()
        self._requests = requests
        self._arbiter = CommandArbiter(round(_HANDOVER_S / simulation.tick_s))

        def subscriber(topic: str, message_class: type, callback: Any) -> rospy.Subscriber:
            return rospy.Subscriber(
                topic, message_class, requests.deferred(callback), queue_size=10, tcp_nodelay=True
            )

        self.subscribers = [subscriber(self.topic, control_class, self._on_control)]
        targets = ego + "/ackermann_cmd"
        self._ackermann = AckermannSwitch(ackermann_cmd, targets, self.topic)
        if self._ackermann.subscribes:
            self.subscribers.append(
                rospy.Subscriber(
                    targets, AckermannDrive, self._on_target, queue_size=10, tcp_nodelay=True
                )
            )
        subscriber(self.topic + "_manual", control_class, self._on_manual_control)
        subscriber(ego + "/vehicle_control_manual_override", Bool, self._on_override)

    @property
    def by_stamp(self) -> bool:
        """Whether the last command had a stamp that decides which observation it answers."""
        return self._answers.by_stamp

    @property
    def has_answer(self) -> bool:
        """Whether a command has answered the last observation."""
        return self._answers.answered

    def expect(self) -> None:
        """Expect the answer to a new observation."""
        self._answers.expect()
        self.received = False

    def give_up(self) -> None:
        """Record that the next tick starts without an answer; any publisher may take control."""
        if self.by_stamp:
            rospy.logwarn_throttle(
                5.0, "sim: no command has the stamp of the last odometry; the next tick starts"
            )
        self._answers.give_up()
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
        if self._drive_log is not None:
            self._drive_log.add_command(message)
        stamp = message.header.stamp.secs, message.header.stamp.nsecs
        observed = self._simulation.observation.stamp
        if self._lockstep and self._answers.is_repeated(stamp, observed):
            return
        if self._accept(vehicle_command(message), self.topic):
            self._record(stamp)

    def _on_target(self, message: AckermannDrive) -> None:
        # In the thread of the subscriber: the loop does not wait for the ROS master.
        if self._ackermann.is_on():
            self._requests.post(self._on_ackermann, message)

    def _on_ackermann(self, message: AckermannDrive) -> None:
        if self._accept(ackermann_target(message), "ackermann_cmd"):
            self._record(UNSTAMPED)

    def _record(self, stamp: Stamp) -> None:
        self._answers.record(stamp, self._simulation.observation.stamp)
        self.received = True
        if self._lockstep and not self.by_stamp:
            rospy.loginfo_once(
                "sim: commands have no stamp of an odometry; the first one after a tick answers it"
            )

    def _on_manual_control(self, message: Any) -> None:
        self._accept(vehicle_command(message), self.topic + "_manual", manual=True)

    def _on_override(self, message: Bool) -> None:
        self._simulation.set_manual_override(message.data)

    def _accept(self, command: Command, topic: str, manual: bool = False) -> bool:
        """Give a command to the simulation; return whether it was accepted."""
        try:
            if self._simulation.accept(command, manual):
                rospy.logwarn_throttle(1.0, f"sim: clamped a command on {topic} to its range")
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a command on {topic}: {error}")
            return False
        return True
