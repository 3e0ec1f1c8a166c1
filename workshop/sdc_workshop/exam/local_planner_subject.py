"""Check of the local planner: it gets a mission and a pose and must publish the path ahead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Callable

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_subject import (
    ENDLESS_LOOP,
    NodeSubject,
    configuration_problem,
    message_name,
    refusal,
)
from sdc_workshop.exam.points import points_problem
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

if TYPE_CHECKING:
    import numpy as np
    import rospy
    from nav_msgs.msg import Odometry

MISSION = "/planner/mission_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
OBSTACLES = "/carla/ego_vehicle/obstacles"
LIGHTS = ("/carla/traffic_lights/info", "/carla/traffic_lights/status")
PATH = "/planner/local_waypoints"
# A bend to the left from x = 30, y = 5, on which all coordinates differ.
ROUTE = [
    (30.0 + 40.0 * math.sin(0.02 * i), 5.0 + 40.0 * (1.0 - math.cos(0.02 * i))) for i in range(90)
]
# x, y, yaw of the car, a little off the route.
POSES = [(38.3, 6.3, 0.25), (57.9, 16.6, 0.78)]
_SPEED_MPS = 4.0
# The path ahead of a pose begins within this distance of it.
_NEAR_M = 8.0


class LocalPlannerSubject(NodeSubject):
    """local_planner.py, TODO 1 to 4, 7 and 8."""

    file = f"{PACKAGE}/scripts/local_planner.py"
    todos = ("1", "2", "3", "4", "7", "8")
    init_todo = "2"
    needs = ("Waypoint", "BaseWaypoint", "Path", "LocalPath")
    usual_topics = (ODOMETRY, OBSTACLES, PATH, *LIGHTS)

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        with stage.node(variant, {}) as node:
            found = self._connection_problem(node, variant)
            if found is None and variant.judged != ("2",):
                found = self._path_problem(node, variant, stage)
        return [found] if found is not None else []

    def _connection_problem(self, node: Node, variant: Variant) -> Problem | None:
        how = node.wait_until(
            lambda: node.subscribes(MISSION) and node.subscribes(ODOMETRY) and node.publishes(PATH)
        )
        found = self.start_problem(node, how, variant)
        if found is not None:
            return found
        if how == "ended":
            return self.ended_problem(node, variant)
        return self.publisher_problem(
            node, PATH, message_name("LocalPath"), "1"
        ) or self.subscriber_problem(node, MISSION, message_name("Path"), "3")

    def _path_problem(self, node: Node, variant: Variant, stage: Stage) -> Problem | None:
        """Return what is wrong with the paths that the node publishes, or None."""
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import BaseWaypoint, LocalPath, Path

        received = node.subscriber(PATH, LocalPath)
        mission = node.publisher(MISSION, Path, latch=True)
        odometry = node.publisher(ODOMETRY, Odometry)
        mission.publish(Path([BaseWaypoint(x, y) for x, y in ROUTE]))
        try:
            reference = _reference(stage)
        except (TypeError, ValueError, KeyError) as error:
            return configuration_problem("local_planner", error)
        for pose in POSES:
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
            messages = received.messages[before:]
            found = _points_problem(messages, wanted, variant)
            if how != "true":
                return self.crash_problem(node, variant) or found or _silence(node, how, variant)
            if found is not None:
                return found
        return self.crash_problem(node, variant)


def _reference(stage: Stage) -> Callable[[float, float, float], np.ndarray]:
    """Return the solution's planner, which maps x, y, yaw to the rows of the path ahead."""
    import numpy as np

    from sdc_package.local_planner import LocalPlanner, PlannerSettings
    from sdc_package.waypoint_search import WaypointSearch

    settings = PlannerSettings.read(stage.configuration("local_planner").__getitem__)
    planner = LocalPlanner(np.array(ROUTE, np.float32).astype(float), settings)
    search = WaypointSearch(planner.route.points)
    return lambda x, y, yaw: planner.plan(search.first_ahead(x, y), x, y, yaw)


def _points_problem(messages: list, wanted: list, variant: Variant) -> Problem | None:
    if not messages:
        return None
    got = [(point.x, point.y, point.v) for point in messages[-1].waypoints]
    problem = points_problem(got, wanted, "the path ahead", "x, y, v")
    if problem is None:
        return None
    todo = next((todo for todo in ("8", "7", "4") if todo in variant.judged), None)
    return Problem(problem.expected, problem.seen, problem.hint, todo)


def _silence(node: Node, how: str, variant: Variant) -> Problem:
    """Return why the node publishes no path."""
    logged = refusal(node)
    expected = "a path ahead for each odometry"
    if how == "busy":
        return Problem(expected, "a callback never returns", ENDLESS_LOOP)
    if logged is not None and "mission" in logged:
        return Problem(
            "the mission is accepted",
            f"the node logs: {logged}",
            "waypoints is an array of rows (x, y), one for each point of path.waypoints.",
            "4",
        )
    if logged is not None:
        todo = "7" if "7" in variant.judged else "4"
        hint = {
            "7": "The first waypoint ahead is self.search.first_ahead(x, y), with x and y of "
            "pose_and_speed in this order; then "
            "self.planner.plan(first, x, y, yaw, self.inputs.obstacles).",
            "4": "Are x and y of the mission swapped? Each row is (point.x, point.y).",
        }[todo]
        return Problem(expected, f"the node logs: {logged}", hint, todo)
    if variant.judged == ("3",):
        return Problem(
            "on_mission receives the mission",
            "the mission was published, and on_mission was not called",
            "The third argument of rospy.Subscriber is the callback: self.on_mission.",
            "3",
        )
    todo = next((todo for todo in ("8", "7", "4", "3") if todo in variant.judged), None)
    hints = {
        "8": "self.publisher.publish(...) publishes the LocalPath; LocalPath(...) alone does not.",
        "7": "After this region `rows` is published: do not return before.",
        "4": "After this region `waypoints` becomes the plan: do not return before.",
    }
    return Problem(
        f"a LocalPath on {PATH} for each odometry",
        "mission and odometry were sent, and nothing was published",
        hints.get(str(todo), "Is every input handed on?"),
        todo,
    )


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
