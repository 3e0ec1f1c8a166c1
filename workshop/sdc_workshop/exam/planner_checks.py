"""Checks of both planners: the rows that they publish must be those of the solution."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Callable, Sequence

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_check import NodeCheck, configuration_problem, first_of
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

if TYPE_CHECKING:
    import numpy as np
    import rospy
    from nav_msgs.msg import Odometry

MISSION = "/planner/mission_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
_OTHER_INPUTS = (
    "/carla/ego_vehicle/obstacles",
    "/carla/traffic_lights/info",
    "/carla/traffic_lights/status",
)
_FILE = "x,y\n10.0,1.0\n12.0,2.5\n14.5,5.0\n15.0,9.0\n13.5,13.25\n"
_FILE_ROUTE = [(10.0, -1.0), (12.0, -2.5), (14.5, -5.0), (15.0, -9.0), (13.5, -13.25)]
_BAD_FILE = "x,y\n1.0,1.0\n2.0,left\n"
# A ROS node ends within this time after it has unregistered its topics.
_SHUTDOWN_S = 5.0
# A bend to the left from x = 30, y = 5, on which all coordinates differ.
_ROUTE = [
    (30.0 + 40.0 * math.sin(0.02 * i), 5.0 + 40.0 * (1.0 - math.cos(0.02 * i))) for i in range(90)
]
# x, y, yaw of the car, a little off the route.
_POSES = [(38.3, 6.3, 0.25), (57.9, 16.6, 0.78)]
_SPEED_MPS = 4.0
# The path ahead of a pose begins within this distance of it.
_NEAR_M = 8.0
_TOLERANCE = 1e-3
_ORDER = "x, y and v are in the wrong order."
# What students confuse: the wrong row as a function of the right one, and the hint.
_MISTAKES = (
    (lambda x, y, *v: (y, x, *v), "x and y are swapped."),
    (
        lambda x, y, *v: (x, -y, *v),
        "The sign of y is wrong: it is negated once too often, or not at all.",
    ),
    (lambda x, y, *v: (x, *v, y), "y and v are swapped."),
    (lambda x, y, *v: (*v, y, x), "x and v are swapped."),
    (lambda x, y, *v: (*v, x, y), _ORDER),
    (lambda x, y, *v: (y, *v, x), _ORDER),
)


class MissionPlannerCheck(NodeCheck):
    """mission_planner.py, TODO 1 to 8: it gets a file and must publish its route, latched."""

    file = f"{PACKAGE}/scripts/mission_planner.py"
    todos = tuple("12345678")
    init_todo = "2"
    needs = ("BaseWaypoint", "Path")
    answer = f"the mission on {MISSION}"

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        found = self._problem(variant, stage)
        if found is None and "5" in variant.judged:
            found = self._refusal_problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        path = stage.folder / "mission.csv"
        path.write_text(_FILE, encoding="utf-8")
        kind = f"{PACKAGE}/Path"
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            how = _settled(node, node.wait_until(lambda: node.publishes(MISSION)))
            if node.seen_types.get(MISSION, kind) != kind:
                return self.publisher_problem(node, MISSION, kind, "3")
            if how == "true":
                return self._mission_problem(node, variant)
            found = self.start_problem(node, how, variant)
            if found is None and how == "ended":
                found = self._ended(node, variant)
            return found or self.publisher_problem(node, MISSION, kind, "3")

    def _mission_problem(self, node: Node, variant: Variant) -> Problem | None:
        """Return what is wrong with the mission that the node publishes, or None."""
        from sdc_package.msg import Path

        received = node.subscriber(MISSION, Path)
        how = _settled(node, node.wait_until(lambda: received.messages))
        if how != "true":
            found = self.start_problem(node, how, variant)
            if found is not None or how == "ended":
                return found or self._ended(node, variant)
            if "published a route" in node.program.output and "3" in variant.judged:
                return Problem(
                    "a subscriber that starts later receives the mission, too",
                    "the mission was published, and a later subscriber received nothing",
                    "The mission is published once: rospy.Publisher(..., latch=True) sends it to "
                    "new subscribers.",
                    "3",
                )
            return self.silence_problem(node, how, variant)
        points = [(point.x, point.y) for point in received.messages[-1].waypoints]
        problem = rows_problem(points, _FILE_ROUTE, "the waypoints of the file")
        if problem is not None:
            return self._points(problem, variant, points)
        if not received.latched:
            return Problem(
                "a latched publisher",
                "it is not latched",
                "rospy.Publisher(..., latch=True) sends the last message to new subscribers.",
                "3",
            )
        if _settled(node, node.wait_until(lambda: False)) == "ended":
            return self._ended(node, variant)
        return self.crash_problem(node, variant)

    @staticmethod
    def _points(problem: Problem, variant: Variant, points: list) -> Problem:
        if "4" in variant.judged and "6" not in variant.judged:
            return Problem(
                "the route of the file that the parameter waypoints_path names",
                f"another route of {len(points)} points",
                'The launch file sets the file: parameter("waypoints_path"). A name in the program '
                "is right on one machine only.",
                "4",
            )
        todo = first_of(("6", "5", "7"), variant)
        if not points and todo == "5":
            hint = "Assign the result of load_waypoints(waypoints_path) to self.waypoints."
            return Problem(problem.expected, "an empty path", hint, "5")
        return Problem(problem.expected, problem.seen, problem.hint, todo)

    def _ended(self, node: Node, variant: Variant) -> Problem:
        found = self.crash_problem(node, variant)
        if found is not None or node.program.status != 0:
            return found or self.ended_problem(node, variant)
        return Problem(
            "the node keeps running after it has published",
            "it ended at once, and its latched message with it",
            "rospy.spin() keeps a node running until ROS ends it. A latched message exists as long "
            "as its publisher.",
            "8",
        )

    def _refusal_problem(self, variant: Variant, stage: Stage) -> Problem | None:
        path = stage.folder / "bad.csv"
        path.write_text(_BAD_FILE, encoding="utf-8")
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            # A ROS node takes a while to end, during which it only waits.
            results = (node.wait_until(lambda: False) for _ in range(4))
            how = next((how for how in results if how != "idle"), "idle")
            output = node.program.output
            if "Traceback" in output:
                found = self.crash_problem(node, variant)
                if found is not None and "WaypointError" not in found.seen:
                    return found
                return Problem(
                    "a bad file ends the node with one clear line",
                    "it ends with a traceback",
                    "Catch it: try: ... except WaypointError as error: refuse(error).",
                    "5",
                )
            if how == "ended" and node.program.status == 1 and f"{path}, row 3" in output:
                return None
            seen = f"it continues, although row 3 of the file is '{_BAD_FILE.splitlines()[2]}'"
            if how == "ended":
                seen = f"it ends with status {node.program.status}"
            return Problem(
                "a bad file ends the node with one clear line and exit status 1",
                seen,
                "except WaypointError as error: refuse(error) logs one line and ends the node.",
                "5",
            )


def _settled(node: Node, how: str) -> str:
    """Return "ended" for a node that is shutting down, else `how`.

    A ROS node first unregisters its topics, then waits for its threads, and ends after that.
    """
    unregistered = how == "idle" and node.publishes(MISSION) is None
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

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Problem | None:
        """See NodeCheck.answer_problem."""
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import BaseWaypoint, LocalPath, Path

        received = node.subscriber(PATH, LocalPath)
        mission = node.publisher(MISSION, Path, latch=True)
        odometry = node.publisher(ODOMETRY, Odometry)
        mission.publish(Path([BaseWaypoint(x, y) for x, y in _ROUTE]))
        try:
            reference = _reference(stage)
        except (TypeError, ValueError, KeyError) as error:
            return configuration_problem("local_planner", error)
        for pose in _POSES:
            before = len(received.messages)
            wanted = [tuple(row) for row in reference(*pose).tolist()]

            def send(pose: tuple = pose) -> None:
                odometry.publish(odometry_at(*pose, _SPEED_MPS, rospy.Time.now()))

            def answered(before: int = before, pose: tuple = pose) -> bool:
                # Answers to the last pose may still arrive.
                return any(
                    math.dist((message.waypoints[0].x, message.waypoints[0].y), pose[:2]) < _NEAR_M
                    for message in received.messages[before:]
                    if message.waypoints
                )

            how = node.send_until(send, answered)
            found = None
            for message in received.messages[before:][-1:]:
                rows = [(point.x, point.y, point.v) for point in message.waypoints]
                found = rows_problem(rows, wanted, "the path ahead", "x, y, v")
            if found is not None:
                found = self.crash_problem(node, variant) or Problem(
                    found.expected, found.seen, found.hint, first_of(("8", "7", "4"), variant)
                )
            if how != "true":
                return found or self.silence_problem(node, how, variant)
            if found is not None:
                return found
        return None


def _reference(stage: Stage) -> Callable[[float, float, float], np.ndarray]:
    """Return the solution's planner, which maps x, y, yaw to the rows of the path ahead."""
    import numpy as np

    from sdc_package.local_planner import LocalPlanner, PlannerSettings
    from sdc_package.waypoint_search import WaypointSearch

    settings = PlannerSettings.read(stage.configuration("local_planner").__getitem__)
    planner = LocalPlanner(np.array(_ROUTE, np.float32).astype(float), settings)
    search = WaypointSearch(planner.route.points)
    return lambda x, y, yaw: planner.plan(search.first_ahead(x, y), x, y, yaw)


def odometry_at(x: float, y: float, yaw: float, speed: float, stamp: rospy.Time) -> Odometry:
    """Return an odometry message: position [m], yaw [rad], speed [m/s], stamp."""
    from nav_msgs.msg import Odometry

    message = Odometry()
    message.header.stamp, message.header.frame_id = stamp, "map"
    message.child_frame_id = "ego_vehicle"
    pose = message.pose.pose
    pose.position.x, pose.position.y = x, y
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    message.twist.twist.linear.x = speed
    return message


def rows_problem(got: list, wanted: list, what: str, columns: str = "x, y") -> Problem | None:
    """Return what is wrong with rows of numbers, or None.

    Args:
        got: rows x, y, and perhaps v
        wanted: the right rows
        what: what the rows are, for the message
        columns: names of the columns, for the message
    """
    if _equal(got, wanted):
        return None
    expected = f"{what}: {len(wanted)} rows {columns}, the first {_row(wanted[0])}"
    if not got:
        hint = "No rows were received: is the list empty, or built from something else?"
        return Problem(expected, "no rows", hint)
    seen = f"{len(got)} rows, the first {_row(got[0])}"
    for mistake, hint in _MISTAKES:
        if _equal(got, [mistake(*row) for row in wanted]):
            return Problem(expected, seen, hint)
    if _equal([row[:2] for row in got], [row[:2] for row in wanted]):
        hint = "The speed v is missing: each row has x, y and v, and so has each point."
        return Problem(expected, seen, hint)
    shifts = (1, 2, 3, -1, -2, -3) if len(got) != len(wanted) else ()
    if any(
        _equal(got, wanted[shift:]) or _equal(got[max(-shift, 0) :], wanted) for shift in shifts
    ):
        return Problem(expected, seen, "It begins at the wrong point.")
    distance = math.dist(got[0][:2], wanted[0][:2])
    hint = "Compare the numbers: what causes the first difference?"
    return Problem(expected, f"{seen}, {distance:.2f} m away", hint)


def _equal(a: Sequence, b: Sequence) -> bool:
    return len(a) == len(b) and all(
        len(p) == len(q) and all(abs(x - y) < _TOLERANCE for x, y in zip(p, q))
        for p, q in zip(a, b)
    )


def _row(row: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in row) + ")"
