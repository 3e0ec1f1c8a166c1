"""Checks of both planners: the rows that they publish must be those of the solution."""

from __future__ import annotations

import contextlib
import math
import signal
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, Callable, Sequence

import numpy as np
import psutil
import yaml

from sdc_workshop.exam.answer import Answer, listed, mistake
from sdc_workshop.exam.node import Node, running_node
from sdc_workshop.exam.node_check import NodeCheck, configuration_problem, delay_problem, first_of
from sdc_workshop.exam.output import warnings
from sdc_workshop.exam.probes.library_probe import evaluate
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

MISSION = "/planner/mission_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
_OBSTACLES = "/carla/ego_vehicle/obstacles"
_LIGHTS = "/carla/traffic_lights/info"
_OTHER_INPUTS = (_OBSTACLES, _LIGHTS, "/carla/traffic_lights/status")
_WRONG_ANSWERS = 4
_BAD_FILE = "x,y\n1.0,1.0\n2.0,left\n"
# A ROS node ends within this time after it has unregistered its topics, on a busy machine, too.
_SHUTDOWN_S = 20.0
_SPEED_MPS = 9.0
# A light in this place is too near for one of these scenes, and far enough for the other.
_LIGHT_S_M = 163.0
_OBSTACLE_M = 15.0
_POINT_M = 0.8
# The route: straight on, then three arcs with this radius that turn the car, and the same way back.
_STRAIGHT_M, _RADIUS_M = 48.0, 10.0
_TURNS_RAD = (-math.pi / 3, 5 * math.pi / 3, -math.pi / 3)
# Distance of the car along the route, and what is ahead: in the turn, on the way out and back.
_SCENES = (
    (70.0, "a pedestrian ahead"),
    (122.0, "a red light ahead"),
    (30.0, "a place that the route passes twice"),
    (155.0, "a red light that is too near to stop"),
)
_TOLERANCE = 1e-3
_ROW_MISTAKES = Path(__file__).with_name("row_mistakes.yaml")


class MissionPlannerCheck(NodeCheck):
    """mission_planner.py, TODO 1 to 8: it gets a file and must publish its route, latched."""

    file = f"{PACKAGE}/scripts/mission_planner.py"
    todos = tuple("12345678")
    init_todo = "2"
    needs = ("BaseWaypoint", "Path")
    topics = (("publishes", MISSION, f"{PACKAGE}/Path", "3"),)
    answer = f"the mission on {MISSION}"

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        found = super().problems(variant, stage)
        if not found and "5" in variant.judged:
            found = self._refusal_problems(variant, stage)
        return found

    def _route(self, stage: Stage) -> list:
        """Return the points of the file, in CARLA coordinates."""
        random = stage.random(self.file)
        bend = random.uniform(0.2, 0.6)
        return [
            (round(10.0 + 3 * i + random.random(), 3), round(1.0 + bend * i * i, 3))
            for i in range(5)
        ]

    def parameters(self, stage: Stage) -> dict:
        """See NodeCheck.parameters."""
        path = stage.folder / "mission.csv"
        rows = [f"{x},{y}" for x, y in self._route(stage)]
        path.write_text("\n".join(["x,y", *rows, ""]), encoding="utf-8")
        return {"waypoints_path": str(path)}

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
        """Return what is wrong with the mission that the node publishes, or None."""
        from sdc_package.msg import Path

        received = node.subscriber(MISSION, Path)
        how = _settled(node, node.program.wait_until(lambda: received.messages))
        if how == "ended":
            return self.ended_problem(node, variant)
        if how != "true":
            found = self.start_problem(node, how, variant)
            if found is None and "published a route" in node.program.output:
                found = listed("late_subscriber") if "3" in variant.judged else None
            return found or self.silence_problem(node, how, variant)
        points = [(point.x, point.y) for point in received.messages[-1].waypoints]
        route = [(x, -y) for x, y in self._route(stage)]
        problem = rows_problem(points, route, "the waypoints of the file")
        if problem is not None:
            return self._points(problem, variant, points)
        if not received.latched:
            return listed("not_latched")
        how = _settled(node, node.program.wait_until(lambda: False))
        if how == "ended":
            return self.ended_problem(node, variant)
        found = self.crash_problem(node, variant)
        return found or (self._waiting_problem(node, how) if "8" in variant.judged else None)

    @staticmethod
    def _waiting_problem(node: Node, how: str) -> Answer | None:
        """Return what is wrong with how the node waits: without work, and until Ctrl-C."""
        if how == "busy":
            return listed("busy_loop")
        with contextlib.suppress(psutil.Error):
            node.program.main.send_signal(signal.SIGINT)
        return listed("endless_loop") if node.program.wait(_SHUTDOWN_S) is None else None

    @staticmethod
    def _points(problem: Answer, variant: Variant, points: list) -> Answer:
        if "4" in variant.judged and "6" not in variant.judged:
            return listed("another_file", seen=f"another route of {len(points)} points")
        todo = first_of(("6", "5", "7"), variant)
        if not points and todo == "5":
            hint = "Assign the result of load_waypoints(waypoints_path) to self.waypoints."
            return mistake(problem.expected, "an empty path", hint, "5")
        return replace(problem, todo=todo)

    def ended_problem(self, node: Node, variant: Variant) -> Answer:
        """See NodeCheck.ended_problem."""
        if self.crash_problem(node, variant) is None:
            if node.program.status == 0:
                return listed("ended")
            if variant.judged == ("4",) and "cannot be read" in node.program.output:
                return listed("another_file", seen="a file that is not there")
        return super().ended_problem(node, variant)

    def _refusal_problems(self, variant: Variant, stage: Stage) -> list:
        """Return what is wrong with how the node refuses a bad file."""
        path = stage.folder / "bad.csv"
        path.write_text(_BAD_FILE, encoding="utf-8")
        with running_node(stage, variant, {"waypoints_path": str(path)}) as node:
            # A ROS node takes a while to end, during which it only waits.
            results = (node.program.wait_until(lambda: False) for _ in range(4))
            how = next((how for how in results if how != "idle"), "idle")
            output, status = node.program.output, node.program.status
        if "Traceback" in output:
            last = output.rpartition("During handling of the above exception")[2]
            found = self.exception_problem(last, node.path, variant)
            if found is not None and not found.seen.split(":")[0].endswith("WaypointError"):
                return [found]
            return [listed("bad_file_traceback")]
        if how != "ended":
            seen = f"it continues, although row 3 of the file is '{_BAD_FILE.splitlines()[2]}'"
        elif status != 1:
            seen = f"it ends with status {status}"
        elif f"{path}, row 3" not in output:
            seen = "its output does not say that row 3 of the file is bad"
        else:
            return []
        return [listed("bad_file", seen=seen)]


def _settled(node: Node, how: str) -> str:
    """Return "ended" for a node that is shutting down, else `how`.

    A ROS node first unregisters its topics, then waits for its threads, and ends after that.
    """
    has_published = node.type_of("publishes", MISSION) is not None
    unregistered = how == "idle" and has_published and MISSION not in node.topics()[0]
    return "ended" if unregistered and node.program.wait(_SHUTDOWN_S) is not None else how


class LocalPlannerCheck(NodeCheck):
    """local_planner.py, TODO 1 to 4, 7 and 8: it gets a mission and poses."""

    file = f"{PACKAGE}/scripts/local_planner.py"
    todos = ("1", "2", "3", "4", "7", "8")
    init_todo = "2"
    needs = ("Waypoint", "BaseWaypoint", "Path", "LocalPath")
    given_topics = (ODOMETRY, PATH, *_OTHER_INPUTS)
    topics = (
        ("publishes", PATH, f"{PACKAGE}/LocalPath", "1"),
        ("subscribes", MISSION, f"{PACKAGE}/Path", "3"),
        ("subscribes", ODOMETRY, "nav_msgs/Odometry", None),
    )
    answer = "a path ahead for each odometry"

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
        """See NodeCheck.answer_problem."""
        from carla_msgs.msg import CarlaTrafficLightInfoList
        from nav_msgs.msg import Odometry
        from sdc_msgs.msg import ObstacleArray
        from sdc_package.msg import BaseWaypoint, LocalPath, Path

        received = node.subscriber(PATH, LocalPath)
        ends = [
            node.publisher(MISSION, Path, latch=True),
            node.publisher(_LIGHTS, CarlaTrafficLightInfoList, latch=True),
            node.publisher(_OBSTACLES, ObstacleArray),
            node.publisher(ODOMETRY, Odometry),
        ]
        random = stage.random(self.file)
        try:
            scenes = [Scene(stage, random, *row) for row in _SCENES]
        except (TypeError, ValueError, KeyError) as error:
            return configuration_problem("local_planner", error)
        ends[0].publish(Path([BaseWaypoint(x, y) for x, y in scenes[0].mission]))
        ends[1].publish(scenes[-1].lights)
        answers: list = []
        for scene in scenes:
            before = len(received.messages)
            how = node.send_until(
                partial(scene.send, ends[2:]), partial(scene.is_decided, received.messages, before)
            )
            answers.append(paths(received.messages[before:]))
            if not answers[-1]:
                found = self._refused(node, variant, scene)
                return found or self.silence_problem(node, how, variant)
        found = self._rows_problem(scenes, answers, first_of(("8", "7", "4"), variant))
        if found is not None:
            return self.crash_problem(node, variant) or found
        delays_s = node.delays_s(partial(scenes[-1].send, ends[2:]), received.messages)
        return delay_problem(delays_s, first_of(("8", "7"), variant))

    def _rows_problem(self, scenes: list, answers: list, todo: str | None) -> Answer | None:
        """Return what is wrong with the rows of all messages about each scene, or None."""
        for scene, got in zip(scenes, answers):
            parts = [rows for rows in got if 0 < len(rows) < len(scene.wanted)]
            if any(_equal(rows, scene.wanted[: len(rows)]) for rows in parts):
                return listed("part_of_path", todo=todo, count=len(parts[0]), all=len(scene.wanted))
        wrong = [scene for scene, got in zip(scenes, answers) if not scene.is_right(got)]
        if not wrong:
            return None
        got = answers[scenes.index(wrong[0])][-1]
        found = rows_problem(got, wrong[0].wanted, "the path ahead", "x, y, v")
        assert found is not None
        hint = self._mistake(todo, list(zip(scenes, answers))) or found.hint
        return mistake(f"{wrong[0].text}: {found.expected}", found.seen, hint, todo)

    def _refused(self, node: Node, variant: Variant, scene: Scene) -> Answer | None:
        """Return the problem of a planner that refuses what a known mistake gives, or None."""
        todo = first_of(("7", "4"), variant)
        for text in warnings(node.program.output)[-1:]:
            hint = self._mistake(todo, [(scene, [text])])
            if hint:
                return mistake(self.answer, f"the node logs: {text}", hint, todo)
        return None

    def _mistake(self, todo: str | None, received: list) -> str:
        """Return the hint of the mistake that explains what was received of each scene, or ""."""
        if todo == "4":
            return mistake_in_rows(
                lambda change: all(
                    is_explained(scene.planned, change, got[-1]) for scene, got in received
                )
            )
        hints = [
            hint
            for expression, hint in self._table["instead"]
            if all(is_explained(scene.evaluated, expression, got[-1]) for scene, got in received)
        ]
        return " Or: ".join(dict.fromkeys(hints))


def _route(random: Random) -> list:
    """Return the points of a route that leads out and, after a turn, back along the same line."""
    # Neither this heading nor its opposite is that of its mirror image, -heading.
    heading = random.choice((-0.5, 0.5)) * math.pi + random.uniform(-0.5, 0.5)
    side = random.choice((-1.0, 1.0))
    x, y = random.uniform(200.0, 240.0), random.uniform(-20.0, 20.0)
    turns = [(abs(turn) * _RADIUS_M, turn * side) for turn in _TURNS_RAD]
    points = []
    for length, turn in ((_STRAIGHT_M, 0.0), *turns, (_STRAIGHT_M, 0.0)):
        count = round(length / _POINT_M)
        for _ in range(count):
            points.append((x, y))
            heading += 0.5 * turn / count
            x += length / count * math.cos(heading)
            y += length / count * math.sin(heading)
            heading += 0.5 * turn / count
    return points


def paths(messages: list) -> list:
    """Return the rows x, y, v of each path."""
    return [[(point.x, point.y, point.v) for point in path.waypoints] for path in messages]


class Scene:
    """A car near s_m [m] on the route, with an obstacle or a red light ahead of it.

    Attributes:
        mission: the points of the route
        wanted: the rows of the solution
        lights: the message of the traffic lights
        text: what there is, for people

    Raises:
        TypeError, ValueError, KeyError: the planner refuses its configuration
    """

    def __init__(self, stage: Stage, random: Random, s_m: float, text: str):
        from carla_msgs.msg import CarlaTrafficLightInfo, CarlaTrafficLightInfoList
        from geometry_msgs.msg import Pose

        from sdc_package.local_planner import LocalPlanner, PlannerSettings
        from sdc_package.waypoint_search import WaypointSearch

        self.text = text
        self.mission = _route(stage.random("route"))
        self._settings = PlannerSettings.read(stage.configuration("local_planner").__getitem__)
        self._points = np.array(self.mission, np.float32).astype(float)
        route = LocalPlanner(self._points, self._settings).route
        self._search = WaypointSearch(route.points)
        # A little beyond a point, which is the nearest one, or before it, and to the side of it.
        place = int(np.searchsorted(route.s, s_m))
        (x, y), yaw = route.points[place].tolist(), float(route.heading[place])
        along, side = random.uniform(0.1, 0.3), random.uniform(0.2, 0.5)
        along *= 1.0 if "light" in text else -1.0
        self._car = (
            x + along * math.cos(yaw) - side * math.sin(yaw),
            y + along * math.sin(yaw) + side * math.cos(yaw),
            yaw + random.uniform(-0.1, 0.1),
        )
        has_light = "light" in text
        place = int(np.searchsorted(route.s, _LIGHT_S_M if has_light else s_m + _OBSTACLE_M))
        self._thing = Pose()
        self._thing.position.x, self._thing.position.y = route.points[place].tolist()
        self._thing.orientation.w = 1.0
        light = CarlaTrafficLightInfo(id=1, transform=self._thing)
        light.trigger_volume.size.y = 6.0
        self.lights = CarlaTrafficLightInfoList([light] if has_light else [])
        self.wanted = self._plan(self._search.first_ahead(*self._car[:2]), *self._car)

    def send(self, ends: list) -> None:
        """Publish the obstacles and the odometry of this time at these ends."""
        for end, message in zip(ends, self._messages()):
            end.publish(message)

    def is_decided(self, messages: list, before: int) -> bool:
        """Return whether the answers after the first ones are right, or wrong often enough."""
        got = paths(messages[before:])
        # The first answer may be that to the scene before.
        return len(got) >= 2 and self.is_right(got) or len(got) >= _WRONG_ANSWERS

    def _messages(self) -> list:
        """Return the obstacles and the odometry of this time."""
        import rospy
        from carla_msgs.msg import CarlaTrafficLightStatus
        from geometry_msgs.msg import Vector3
        from sdc_msgs.msg import Obstacle, ObstacleArray

        from sdc_common.ros.odometry import odometry_message

        obstacles = ObstacleArray()
        obstacles.header.stamp = rospy.Time.now()
        if "pedestrian" in self.text:
            size = Vector3(0.5, 0.5, 1.8)
            obstacles.obstacles = [Obstacle(1, "pedestrian", self._thing, size, 0.0)]
        # An odometry waits for this message, because there is the state of a light in it.
        status = CarlaTrafficLightStatus
        state = status.RED if self.lights.traffic_lights else status.GREEN
        obstacles.traffic_lights = [status(1, state)]
        stamp = obstacles.header.stamp
        return [obstacles, odometry_message(stamp, self._car, (_SPEED_MPS, 0.0, 0.0))]

    def is_right(self, answers: list) -> bool:
        """Return whether the last of these answers is that of the solution."""
        return _equal(answers[-1], self.wanted)

    def planned(self, change: Callable[[list], list]) -> list:
        """Return the rows of the solution on the mission with a change."""
        from sdc_package.local_planner import LocalPlanner
        from sdc_package.waypoint_search import WaypointSearch

        points = np.array(change(self._points.tolist()), float)
        search = WaypointSearch(LocalPlanner(points, self._settings).route.points)
        return self._plan(search.first_ahead(*self._car[:2]), *self._car, points=points)

    def evaluated(self, expression: str) -> list:
        """Return the rows of an expression `instead` of checks.yaml."""
        x, y, yaw = self._car
        yaw = math.remainder(yaw, math.tau)  # as the node reads it from the quaternion
        names = {
            "x": x,
            "y": y,
            "yaw": yaw,
            "speed": _SPEED_MPS,
            "plan": self._plan,
            "first": self._search.first_ahead(x, y),
            "nearest": self._search.nearest(x, y),
            "search": self._search,
        }
        rows: list = evaluate(expression, names)  # type: ignore[assignment]
        return rows

    def _plan(
        self,
        first: int,
        x: float,
        y: float,
        yaw: float,
        speed: float = _SPEED_MPS,
        blind: bool = False,
        points: Any = None,
    ) -> list:
        """Return the rows of the solution; a blind planner knows no obstacles.

        Raises:
            ValueError: the planner refuses the mission, or the place of the car
        """
        from sdc_common.ros.conversion import detected_obstacles, stop_lines
        from sdc_package.local_planner import LocalPlanner
        from sdc_package.traffic_lights import TrafficLightMonitor

        message = self._messages()[0]
        planner = LocalPlanner(self._points if points is None else points, self._settings)
        lights = TrafficLightMonitor(self._settings.traffic_lights)
        lights.lines = stop_lines(self.lights)
        lights.set_states(message.traffic_lights, stamped=True)
        rows = planner.plan(first, x, y, yaw, () if blind else detected_obstacles(message))
        return [tuple(row) for row in planner.stop_for(lights, rows, speed).tolist()]


def is_explained(plan: Callable[[Any], list], argument: object, got: list | str) -> bool:
    """Return whether a plan gives the rows that were received, or the reason that was logged."""
    try:
        rows = plan(argument)
        return isinstance(got, list) and _equal(got, rows)
    except (ValueError, IndexError) as error:
        return isinstance(got, str) and str(error) in got


def mistake_in_rows(
    explains: Callable[[Callable[[list], list]], bool], first: Sequence[float] = (0.0, 0.0, 0.0)
) -> str:
    """Return the hint of the only row of row_mistakes.yaml that explains what was received, or "".

    `explains` gets a change, and returns whether rows with it are what was received; `first` is the
    first row that was received, where it is known.
    """

    def changed(expression: str) -> Callable[[list], list]:
        code = compile(expression, "<rows>", "eval")

        def change(rows: list) -> list:
            if expression.startswith("rows"):
                return list(eval(code, {"rows": rows}))
            names = [dict(zip("xyv", (*row, 0.0)), rows=rows, first=first) for row in rows]
            return [list(eval(code, known))[: len(rows[0])] for known in names]

        return change

    found = []
    for expression, hint in yaml.safe_load(_ROW_MISTAKES.read_text(encoding="utf-8")):
        with contextlib.suppress(ValueError, IndexError):
            found += [hint] * explains(changed(expression))
    return found[0] if len({*found}) == 1 else ""


def rows_problem(got: list, wanted: list, what: str, columns: str = "x, y") -> Answer | None:
    """Return what is wrong with rows of numbers, or None; the texts name the rows for people."""
    if _equal(got, wanted):
        return None
    first = next((i for i, (a, b) in enumerate(zip(got, wanted)) if not _equal([a], [b])), len(got))
    hint = mistake_in_rows(lambda change: _equal(got, change(wanted)), *got[:1])
    if not got:
        seen, hint = "no rows", "Is the list empty, or built from something else?"
    elif first < len(wanted) and _equal(got, wanted[:first] + wanted[first + 1 :]):
        seen = f"{len(got)} rows: row {first + 1}, {_row(wanted[first])}, is missing"
        hint = "One row is left out: where do the indices or the slice begin and end?"
    elif got == got[:1] * len(got):
        seen = f"{len(got)} times {_row(got[0])}"
    elif len(got) == len(wanted):
        seen = f"row {first + 1} is {_row(got[first])} in the place of {_row(wanted[first])}"
    else:
        seen = f"{len(got)} rows, the first {_row(got[0])}"
    expected = f"{what}: {len(wanted)} rows {columns}, the first {_row(wanted[0])}"
    return mistake(expected, seen, hint or "Compare the numbers: what causes the first difference?")


def _equal(a: Sequence, b: Sequence) -> bool:
    return np.shape(a) == np.shape(b) and np.allclose(a, b, 0.0, _TOLERANCE)


def _row(row: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in row) + ")"
