"""What the checks of both parts of the controller share."""

from __future__ import annotations

from typing import Any

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_subject import NodeSubject, message_name
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

COMMANDS = "/carla/ego_vehicle/vehicle_control_cmd"
ODOMETRY = "/carla/ego_vehicle/odometry"
FIELDS = ("throttle", "steer", "brake")
# The brake of a controller whose inputs time out, which distinguishes such commands from answers.
STOP_BRAKE = 0.987
TOLERANCE = 1e-3
# Parameters of both parts: inputs do not time out, and the textbook law steers.
SETTINGS = {"patience_s": 1000.0, "stop_brake": STOP_BRAKE, "steering_method": "stanley"}


class ControllerSubject(NodeSubject):
    """A part of simple_controller.py."""

    file = f"{PACKAGE}/scripts/simple_controller.py"
    init_todo = "1.2"

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        found = self._problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        raise NotImplementedError

    def _connection_problem(self, node: Node, how: str, variant: Variant) -> Problem | None:
        found = self.start_problem(node, how, variant)
        if found is not None:
            return found
        if how == "ended":
            return self.ended_problem(node, variant)
        return self.publisher_problem(
            node, COMMANDS, message_name("CarlaVehicleControl"), "1.3"
        ) or self.subscriber_problem(node, ODOMETRY, "nav_msgs/Odometry", "1.4")


def is_stop(command: Any) -> bool:
    """Return whether this is the command of a controller whose inputs time out."""
    return abs(command.brake - STOP_BRAKE) < TOLERANCE


def command_text(values: dict) -> str:
    """Return a command as text."""
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())
