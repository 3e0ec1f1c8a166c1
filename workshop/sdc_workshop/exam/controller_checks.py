"""Checks of both parts of the controller: constant commands, and following the path ahead."""

from __future__ import annotations

from functools import partial
from random import Random
from typing import TYPE_CHECKING, Any, Callable

from sdc_workshop.exam.answer import Answer, listed
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

if TYPE_CHECKING:
    import rospy

COMMANDS = "/carla/ego_vehicle/vehicle_control_cmd"
_TOPICS = (
    ("publishes", COMMANDS, f"{PACKAGE}/CarlaVehicleControl", "1.3"),
    ("subscribes", ODOMETRY, "nav_msgs/Odometry", "1.4"),
)
_NOT_SET = {"brake": 0.0, "hand_brake": False, "reverse": False}
# The command of a controller whose inputs time out: its brake distinguishes it from answers.
_STOP = {"throttle": 0.0, "steer": 0.0, "brake": 0.987}
_TOLERANCE = 1e-3
# So many wrong commands are enough.
_WRONG_ANSWERS = 2
# Parameters of both parts: inputs do not time out, and the textbook law steers.
_SETTINGS = {"patience_s": 1000.0, "stop_brake": _STOP["brake"], "steering_method": "stanley"}


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

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
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

        # The first command is that of a controller that waits for its inputs: it brakes.
        node.send_until(lambda: None, lambda: received.messages)
        first = received.messages[:1]

        def answers() -> list:
            stops = [_fields(command) for command in first]
            return [sent for sent in list(received.messages) if _fields(sent) not in stops]

        def nearest() -> list:
            return sorted(answers()[::-1], key=lambda command: len(_wrong(command, basic)))[:1]

        how = node.send_until(
            send,
            lambda: (
                answers() and (not _wrong(*nearest(), basic) or len(answers()) > _WRONG_ANSWERS)
            ),
        )
        found = [_field_problem(command, basic, "for an odometry") for command in nearest()]
        stopped = {**_NOT_SET, **_STOP}
        found += [_field_problem(stop, stopped, "before the first odometry") for stop in first]
        if any(found):
            return next(filter(None, found))
        if len(found) == 1 and "1.5" in variant.judged:
            return self.crash_problem(node, variant) or listed("some_published")
        if not answers():
            return self.silence_problem(node, how, variant)
        stamp = nearest()[0].header.stamp
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

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
        """See NodeCheck.answer_problem."""
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl, LocalPath

        random, parameters = stage.random(self.file), stage.configuration("simple_controller")
        try:
            scenes = [Scene(row, random, parameters) for row in self._table["scenes"]]
        except (TypeError, ValueError, KeyError) as error:
            return configuration_problem("simple_controller", error)
        received = node.subscriber(COMMANDS, CarlaVehicleControl)
        ends = node.publisher(ODOMETRY, Odometry), node.publisher(PATH, LocalPath)
        stamp, todo, delays_s = rospy.Time.now(), first_of(("2.3",), variant), []
        for scene in scenes:
            for _ in range(TICKS):
                stamp += rospy.Duration(nsecs=STEP_NS)
                answers = partial(_answers, received.messages, stamp)
                how = node.send_until(partial(scene.send, ends, stamp), answers)
                delays_s.append(node.waited_s)
                if how != "true":
                    return self.silence_problem(node, how, variant)
                scene.got = _fields(answers()[0])
                if scene.is_right():
                    break
        for scene in scenes:
            if not scene.is_right():
                hint = mistake_in_rows(
                    lambda change: all(scene.is_right(change) for scene in scenes)
                )
                texts = {"wanted": _text(scene.wanted()), "got": _text(scene.got)}
                found = listed("another_path", todo=todo, what=scene.text, hint=hint, **texts)
                return self.crash_problem(node, variant) or found
        return delay_problem(delays_s, todo)


class Scene:
    """A car beside a path: a row of `scenes` of checks.yaml, in which `random` moves the car.

    Attributes:
        text: what there is, for people
        got: the last command of the node

    Raises:
        TypeError, ValueError, KeyError: the controller refuses its parameters
    """

    _TOLERANCES = {"throttle": 0.03, "steer": 0.002, "brake": 0.03}

    def __init__(self, row: dict, random: Random, parameters: dict):
        self.text = row["text"]
        self.got: dict = {}
        offsets = [random.uniform(-end, end) for end in (0.2, 0.05, 0.02)]
        self._pose = [sum(pair) for pair in zip(row["pose"], offsets)]
        self._speed_mps = row["speed_mps"]
        self._path = path_with(lambda i: float(str(evaluate(row["planned_mps"], {"i": i}))))
        for i, point in row.get("moved", {}).items():
            self._path[i][:2] = point
        self._parameters = parameters
        self.wanted()

    def send(self, ends: tuple, stamp: rospy.Time) -> None:
        """Publish the odometry with this stamp, and the path, at these ends."""
        from sdc_package.msg import LocalPath, Waypoint

        from sdc_common.ros.odometry import odometry_message

        ends[0].publish(odometry_message(stamp, self._pose, (self._speed_mps, 0.0, 0.0)))
        ends[1].publish(LocalPath([Waypoint(*row) for row in self._path]))

    def is_right(self, change: Callable[[list], list] = list) -> bool:
        """Return whether the command is that of the solution, on a path with a change."""
        wanted = self.wanted(change)
        near = (abs(self.got[name] - wanted[name]) < end for name, end in self._TOLERANCES.items())
        return bool(wanted) and all(near)

    def wanted(self, change: Callable[[list], list] = list) -> dict:
        """Return the command that the solution gives after all ticks of the scene."""
        motion = *self._pose, self._speed_mps, change(self._path)
        answer = controller_answer(*motion, self._parameters)
        return dict(zip(("throttle", "steer", "brake"), answer or ()))


def _answers(messages: list, stamp: rospy.Time) -> list:
    """Return the commands with a stamp."""
    with_stamp = [command for command in messages if command.header.stamp == stamp]
    return [command for command in with_stamp if not _is_stop(command)]


def _is_stop(command: Any) -> bool:
    """Return whether this is the command of a controller whose inputs time out."""
    return abs(command.brake - _STOP["brake"]) < _TOLERANCE


def _fields(command: Any, *more: str) -> dict:
    return {name: getattr(command, name) for name in ("throttle", "steer", "brake", *more)}


def _wrong(command: Any, wanted: dict) -> list:
    """Return the names of the fields that differ."""
    got = _fields(command, *wanted)
    return [name for name in wanted if abs(got[name] - wanted[name]) > _TOLERANCE]


def _field_problem(command: Any, wanted: dict, when: str) -> Answer | None:
    """Return what is wrong with the fields of a command that is published `when`, or None."""
    got = _fields(command, *wanted)
    for name in _wrong(command, wanted):
        swapped = [("throttle", "steer"), ("steer", "throttle")]
        swapped += [("brake", "throttle"), ("brake", "steer")]
        key, times = "another_field", ""
        if any(wanted[b] and abs(got[a] - wanted[b]) < _TOLERANCE for a, b in swapped):
            key = "fields_swapped"
        elif abs(got[name] + wanted[name]) < _TOLERANCE:
            key = "field_sign"
        elif got[name] and wanted[name]:
            times = f" It is {got[name] / wanted[name]:.4g} times as large."
        texts = {"wanted": f"{when}: {_text(wanted)}", "got": _text(got)}
        return listed(key, field=name, times=times, **texts)
    return None


def _basic(stage: Stage) -> dict:
    """Return the command that the node is configured to answer with, by numbers that are not round.

    A node with a constant such as 0.4 must not be right by chance.
    """
    random = stage.random("basic_control")
    throttle = random.choice((0.3, 0.35, 0.4)) + random.uniform(0.02, 0.03)
    return {"throttle": throttle, "steer": -random.uniform(0.11, 0.14), **_NOT_SET}


def _text(values: dict) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())
