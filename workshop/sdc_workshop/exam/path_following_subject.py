"""Check of the second part of the controller: it follows the local path."""

from __future__ import annotations

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.controller_scenes import PATH, SCENES, Drive
from sdc_workshop.exam.controller_subject import (
    COMMANDS,
    FIELDS,
    ODOMETRY,
    SETTINGS,
    ControllerSubject,
    command_text,
)
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_subject import (
    ENDLESS_LOOP,
    configuration_problem,
    message_name,
    refusal,
)
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant

# Hints on a wrong command whose steer is right, by region.
_PEDAL_HINTS = {
    "2.8": "The steering is right, the pedals are not: self.speed_control.acceleration takes the "
    "target's speed, the target's acceleration, the car's speed and the step, in this order.",
    "2.9": "The steering is right, the pedals are not: pedals(acceleration) returns (throttle, "
    "brake), and publish takes stamp, throttle, steer, brake in this order.",
}
_STEER_HINTS = {
    "2.8": "The steering is wrong: self.steering.wheel_angle takes the path, x, y, yaw, speed and "
    "yaw rate, in this order; angles are in radians.",
    "2.9": "The steering is wrong: self.steering_map.command(wheel_angle, speed) returns the steer "
    "command, and whether it was limited.",
}
_SILENCE_HINTS = {
    "2.2": "The third argument of rospy.Subscriber is the callback: self.on_path.",
    "2.3": "self.inputs.add_path(rows) hands the path on: do not return before.",
    "2.8": "After this region the command is computed: do not return before.",
    "2.9": "self.publish(motion.stamp, throttle, self.steer, brake) publishes the command.",
}


class PathFollowingSubject(ControllerSubject):
    """TODO 2.1 to 2.3, 2.8 and 2.9: follow the path ahead."""

    todos = ("2.1", "2.2", "2.3", "2.8", "2.9")
    needs = ("CarlaVehicleControl", "Waypoint", "LocalPath")

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        with stage.node(variant, {**SETTINGS, "basic_control": False}) as node:
            how = node.wait_until(
                lambda: (
                    node.subscribes(ODOMETRY) and node.publishes(COMMANDS) and node.subscribes(PATH)
                )
            )
            found = self._connection_problem(node, how, variant) or self.subscriber_problem(
                node, PATH, message_name("LocalPath"), "2.2"
            )
            if found is not None:
                return found
            drive = Drive(node, stage.configuration("simple_controller"))
            try:
                drive.wanted(SCENES[0])
            except (TypeError, ValueError, KeyError) as error:
                return configuration_problem("simple_controller", error)
            for scene in SCENES:
                how = drive.play(scene)
                if how == "true":
                    continue
                found = self.crash_problem(node, variant)
                if found is not None:
                    return found
                if drive.answer is None:
                    return _silence(node, how, variant)
                wanted = drive.wanted(scene)
                got = {name: getattr(drive.answer, name) for name in FIELDS}
                todo = _first_of(("2.9", "2.8", "2.3"), variant)
                expected = f"{scene.text}: {command_text(wanted)}"
                return Problem(expected, command_text(got), _hint(wanted, got, todo), todo)
            return self.crash_problem(node, variant)


def _first_of(todos: tuple, variant: Variant) -> str | None:
    return next((todo for todo in todos if todo in variant.judged), None)


def _near(a: float, b: float) -> bool:
    return abs(a - b) < 0.02


def _hint(wanted: dict, got: dict, todo: str | None) -> str:
    """Return a hint on a wrong command."""
    if todo == "2.3":
        return (
            "The path is another one than was received: each row is (point.x, point.y, point.v), "
            "in this order."
        )
    if todo == "2.9":
        if _near(got["steer"], -wanted["steer"]) and abs(wanted["steer"]) > 0.03:
            return (
                "The sign of steer is wrong: a positive wheel angle turns left, a positive steer "
                "command turns right; self.steering_map.command converts it."
            )
        if _near(got["throttle"], wanted["brake"]) and _near(got["brake"], wanted["throttle"]):
            return (
                "throttle and brake are swapped: pedals() returns (throttle, brake), publish() "
                "takes stamp, throttle, steer, brake."
            )
    if _near(got["steer"], wanted["steer"]):
        return _PEDAL_HINTS.get(str(todo), "The pedals are wrong.")
    return _STEER_HINTS.get(str(todo), "The steering is wrong.")


def _silence(node: Node, how: str, variant: Variant) -> Problem:
    """Return why the node publishes no command."""
    expected = f"a command on {COMMANDS} for each pair of odometry and path"
    if how == "busy":
        return Problem(expected, "a callback never returns", ENDLESS_LOOP)
    logged = refusal(node)
    if logged is not None and PATH in logged:
        return Problem(
            "the path is accepted",
            f"the node logs: {logged}",
            "Each row of the list is (point.x, point.y, point.v): three numbers.",
            "2.3",
        )
    todo = _first_of(("2.9", "2.8", "2.3", "2.2"), variant)
    return Problem(
        expected,
        "both were sent, and no command with the odometry's stamp was published",
        _SILENCE_HINTS.get(str(todo), "Is every input handed on?"),
        todo,
    )
