"""Check of the first part of the controller: it answers each odometry with a constant command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.controller_subject import (
    COMMANDS,
    ODOMETRY,
    SETTINGS,
    TOLERANCE,
    ControllerSubject,
    command_text,
    is_stop,
)
from sdc_workshop.exam.local_planner_subject import odometry_at
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_subject import ENDLESS_LOOP
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant

if TYPE_CHECKING:
    import rospy

THROTTLE, STEER = 0.37, -0.21
COMMAND = {"throttle": THROTTLE, "steer": STEER, "brake": 0.0}


class BasicControlSubject(ControllerSubject):
    """TODO 1.1 to 1.5: constant throttle and steer."""

    todos = ("1.1", "1.2", "1.3", "1.4", "1.5")
    left_empty = ("2.1", "2.2", "2.3", "2.8", "2.9")
    needs = ("CarlaVehicleControl",)

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        settings = {
            **SETTINGS,
            "basic_control": True,
            "basic_throttle": THROTTLE,
            "basic_steer": STEER,
        }
        with stage.node(variant, settings) as node:
            how = node.wait_until(lambda: node.subscribes(ODOMETRY) and node.publishes(COMMANDS))
            found = self._connection_problem(node, how, variant)
            if found is not None or variant.judged == ("1.2",):
                return found
            return self._answer_problem(node, variant)

    def _answer_problem(self, node: Node, variant: Variant) -> Problem | None:
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl

        received = node.subscriber(COMMANDS, CarlaVehicleControl)
        odometry = node.publisher(ODOMETRY, Odometry)
        stamps: list = []

        def send() -> None:
            stamps.append(rospy.Time.now())
            odometry.publish(odometry_at(5.0, 2.0, 0.3, 1.5, stamps[-1]))

        def answers() -> list:
            return [command for command in list(received.messages) if not is_stop(command)]

        how = node.send_until(send, answers)
        if how != "true":
            return self._silence(node, how, variant)
        command = answers()[0]
        return (
            _values_problem(command)
            or _stamp_problem(command.header.stamp, stamps)
            or self.crash_problem(node, variant)
        )

    def _silence(self, node: Node, how: str, variant: Variant) -> Problem:
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how == "busy":
            return Problem("a command for each odometry", "a callback never returns", ENDLESS_LOOP)
        expected = f"a command on {COMMANDS} for each odometry"
        if "1.5" in variant.judged:
            return Problem(
                expected,
                "an odometry was sent, and nothing was published",
                "self.publisher.publish(command) publishes the command; building it does not.",
                "1.5",
            )
        return Problem(
            expected,
            "an odometry was sent, and on_odometry was not called",
            "The third argument of rospy.Subscriber is the callback: self.on_odometry.",
            "1.4",
        )


def _values_problem(command: Any) -> Problem | None:
    got = {name: getattr(command, name) for name in COMMAND}
    wrong = [name for name in COMMAND if abs(got[name] - COMMAND[name]) > TOLERANCE]
    if not wrong:
        return None
    hint = (
        f"{wrong[0]} has another value: "
        "CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)."
    )
    swapped = (("throttle", STEER), ("steer", THROTTLE), ("brake", THROTTLE), ("brake", STEER))
    if any(abs(got[name] - value) < TOLERANCE for name, value in swapped):
        hint = (
            "throttle, steer and brake are swapped: pass the fields of a message by name, "
            "throttle=throttle."
        )
    return Problem(command_text(COMMAND), command_text(got), hint, "1.5")


def _stamp_problem(stamp: rospy.Time, stamps: list) -> Problem | None:
    if stamp in stamps:
        return None
    return Problem(
        "the command has the stamp of the odometry that it answers",
        f"its stamp is {stamp.to_sec():.3f}, the odometry's {stamps[-1].to_sec():.3f}",
        "command.header.stamp = stamp: by its stamp the world knows which odometry a command "
        "answers.",
        "1.5",
    )
