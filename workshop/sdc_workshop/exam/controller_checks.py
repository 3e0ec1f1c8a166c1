"""Checks of both parts of the controller: constant commands, and following the path ahead."""

from __future__ import annotations

from typing import Any, Callable

from sdc_workshop.exam.answer import Problem, listed
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_check import NodeCheck, configuration_problem, delay_problem, first_of
from sdc_workshop.exam.planner_checks import ODOMETRY, PATH, mistake_in_rows
from sdc_workshop.exam.probes.library_probe import (
    STEP_NS,
    TICKS,
    controller_answer,
    evaluate,
    path_with,
)
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

COMMANDS = "/carla/ego_vehicle/vehicle_control_cmd"
_TOPICS = (
    ("publishes", COMMANDS, f"{PACKAGE}/CarlaVehicleControl", "1.3"),
    ("subscribes", ODOMETRY, "nav_msgs/Odometry", "1.4"),
)
_NOT_SET = {"brake": 0.0, "hand_brake": False, "reverse": False}
# The brake of a controller whose inputs time out, which distinguishes such commands from answers.
_STOP_BRAKE = 0.987
_TOLERANCE = 1e-3
# So many wrong commands are enough.
_WRONG_ANSWERS = 2
# Parameters of both parts: inputs do not time out, and the textbook law steers.
_SETTINGS = {"patience_s": 1000.0, "stop_brake": _STOP_BRAKE, "steering_method": "stanley"}


class BasicControlCheck(NodeCheck):
    """TODO 1.1 to 1.5: the controller answers each odometry with a constant command."""

    file = f"{PACKAGE}/scripts/simple_controller.py"
    init_todo = "1.2"
    todos = ("1.1", "1.2", "1.3", "1.4", "1.5")
    left_empty = ("2.1", "2.2", "2.3")
    needs = ("CarlaVehicleControl",)
    topics = _TOPICS
    answer = f"a command on {COMMANDS} for each odometry"

    def parameters(self, stage: Stage) -> dict:
        """See NodeCheck.parameters."""
        basic = _basic(stage)
        wanted = {"basic_throttle": basic["throttle"], "basic_steer": basic["steer"]}
        return {**_SETTINGS, "basic_control": True, **wanted}

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Problem | None:
        """See NodeCheck.answer_problem."""
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl

        from sdc_common.ros.odometry import odometry_message

        received = node.subscriber(COMMANDS, CarlaVehicleControl)
        odometry = node.publisher(ODOMETRY, Odometry)
        # The world's time is not that of the machine.
        late = rospy.Duration(stage.random(self.file).randint(100, 900))
        basic, stamps = _basic(stage), []

        def send() -> None:
            stamps.append(rospy.Time.now() - late)
            odometry.publish(odometry_message(stamps[-1], (5.0, 2.0, 0.3), (1.5, 0.0, 0.0)))

        def answers() -> list:
            return [command for command in list(received.messages) if not _is_stop(command)]

        def wrong_fields(command: CarlaVehicleControl) -> list:
            got = _fields(command, *basic)
            return [name for name in basic if abs(got[name] - basic[name]) > _TOLERANCE]

        def nearest() -> CarlaVehicleControl:
            return min(answers()[::-1], key=lambda command: len(wrong_fields(command)))

        # The first commands may be those of a controller that waits for its inputs.
        how = node.send_until(
            send,
            lambda: answers() and (not wrong_fields(nearest()) or len(answers()) > _WRONG_ANSWERS),
        )
        if not answers():
            return self.silence_problem(node, how, variant)
        command = nearest()
        got, wrong = _fields(command, *basic), wrong_fields(command)
        if wrong:
            swapped = [("throttle", "steer"), ("steer", "throttle")]
            swapped += [("brake", "throttle"), ("brake", "steer")]
            is_swapped = any(abs(got[a] - basic[b]) < _TOLERANCE for a, b in swapped)
            is_negated = abs(got[wrong[0]] + basic[wrong[0]]) < _TOLERANCE
            key = "field_sign" if is_negated else "another_field"
            key = "fields_swapped" if is_swapped else key
            times = got[wrong[0]] / basic[wrong[0]] if basic[wrong[0]] else 0.0
            known = f" It is {times:.4g} times as large." if times and not is_swapped else ""
            return listed(key, wanted=_text(basic), got=_text(got), field=wrong[0], times=known)
        stamp = command.header.stamp
        if stamp in stamps:
            delays_s = node.delays_s(send, received.messages)
            if len(answers()) > len(stamps):
                return listed("answered_twice", got=len(answers()), wanted=len(stamps))
            return delay_problem(delays_s, "1.5")
        is_now = abs((stamp - stamps[-1] - late).to_sec()) < late.to_sec() / 2
        return listed(
            "stamp",
            got=stamp.to_sec(),
            wanted=stamps[-1].to_sec(),
            note="The current time is not the stamp. " if is_now else "",
        )


class PathFollowingCheck(NodeCheck):
    """TODO 2.1 to 2.3: follow the path ahead."""

    file = f"{PACKAGE}/scripts/simple_controller.py"
    init_todo = "1.2"
    todos = ("2.1", "2.2", "2.3")
    needs = ("CarlaVehicleControl", "Waypoint", "LocalPath")
    topics = (*_TOPICS, ("subscribes", PATH, f"{PACKAGE}/LocalPath", "2.2"))
    answer = f"a command on {COMMANDS} for each pair of odometry and path"

    def parameters(self, stage: Stage) -> dict:
        """See NodeCheck.parameters."""
        return {**_SETTINGS, "basic_control": False}

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Problem | None:
        """See NodeCheck.answer_problem."""
        drive = Drive(node, stage.configuration("simple_controller"))
        try:
            drive.wanted(self._table["scenes"][0])
        except (TypeError, ValueError, KeyError) as error:
            return configuration_problem("simple_controller", error)
        random, todo, played = stage.random(self.file), first_of(("2.3",), variant), []
        for scene in self._table["scenes"]:
            offsets = [random.uniform(-end, end) for end in (0.2, 0.05, 0.02)]
            scene = {**scene, "pose": [sum(pair) for pair in zip(scene["pose"], offsets)]}
            how = drive.play(scene)
            if drive.answer is None:
                return self.silence_problem(node, how, variant)
            played.append((scene, _fields(drive.answer)))
        wrong = [(scene, got) for scene, got in played if not drive.is_near(got, scene)]
        for scene, got in wrong[:1]:
            hint = mistake_in_rows(
                lambda change: all(drive.is_near(got, scene, change) for scene, got in played)
            )
            texts = {"wanted": _text(drive.wanted(scene)), "got": _text(got)}
            found = listed("another_path", todo, what=scene["text"], hint=hint, **texts)
            return self.crash_problem(node, variant) or found
        return delay_problem(drive.delays_s, todo)


class Drive:
    """Sends scenes to a controller, tick by tick, until its command is right.

    Attributes:
        answer: the last command, or None without one
        delays_s: how long the node slept before each command [s]
    """

    _TOLERANCES = {"throttle": 0.03, "steer": 0.002, "brake": 0.03}

    def __init__(self, node: Node, parameters: dict):
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl, LocalPath

        self.answer: Any = None
        self._node = node
        self._parameters = parameters
        self._received = node.subscriber(COMMANDS, CarlaVehicleControl)
        self._odometry = node.publisher(ODOMETRY, Odometry)
        self._path = node.publisher(PATH, LocalPath)
        self.delays_s: list = []
        self._tick = rospy.Time.now()

    def play(self, scene: dict) -> str:
        """Send a scene; return "true" when the command is right, "false" when not.

        Without a command, the result is that of Program.wait_until.
        """
        import rospy
        from sdc_package.msg import LocalPath, Waypoint

        from sdc_common.ros.odometry import odometry_message

        path = LocalPath([Waypoint(*row) for row in _path(scene)])
        for _ in range(TICKS):
            self._tick += rospy.Duration(nsecs=STEP_NS)
            stamp, before = self._tick, len(self._received.messages)
            odometry = odometry_message(stamp, scene["pose"], (scene["speed_mps"], 0.0, 0.0))

            def send(odometry: Any = odometry) -> None:
                self._odometry.publish(odometry)
                self._path.publish(path)

            def answers(stamp: rospy.Time = stamp, before: int = before) -> list:
                return [
                    command
                    for command in self._received.messages[before:]
                    if command.header.stamp == stamp and not _is_stop(command)
                ]

            how = self._node.send_until(send, answers)
            self.delays_s.append(self._node.waited_s)
            if how != "true":
                self.answer = None
                return how
            self.answer = answers()[0]
            if self.is_near(_fields(self.answer), scene):
                return "true"
        return "false"

    def is_near(self, got: dict, scene: dict, change: Callable[[list], list] = list) -> bool:
        """Return whether a command is that of the solution, on a path with a change."""
        wanted = self.wanted(scene, change)
        near = (abs(got[name] - wanted[name]) < end for name, end in self._TOLERANCES.items())
        return bool(wanted) and all(near)

    def wanted(self, scene: dict, change: Callable[[list], list] = list) -> dict:
        """Return the command that the solution gives after all ticks of a scene."""
        motion = *scene["pose"], scene["speed_mps"], change(_path(scene))
        answer = controller_answer(*motion, self._parameters)
        return dict(zip(("throttle", "steer", "brake"), answer or ()))


def _path(scene: dict) -> list:
    """Return the rows of a scene's path."""
    return path_with(lambda i: float(str(evaluate(scene["planned_mps"], {"i": i}))))


def _is_stop(command: Any) -> bool:
    """Return whether this is the command of a controller whose inputs time out."""
    return abs(command.brake - _STOP_BRAKE) < _TOLERANCE


def _fields(command: Any, *more: str) -> dict:
    return {name: getattr(command, name) for name in ("throttle", "steer", "brake", *more)}


def _basic(stage: Stage) -> dict:
    """Return the command that the node is configured to answer with, by numbers that are not round.

    A node with a constant such as 0.4 must not be right by chance.
    """
    random = stage.random("basic_control")
    throttle = random.choice((0.3, 0.35, 0.4)) + random.uniform(0.02, 0.03)
    return {"throttle": throttle, "steer": -random.uniform(0.11, 0.14), **_NOT_SET}


def _text(values: dict) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())
