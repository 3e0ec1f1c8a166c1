"""The local planner: given a mission and a place, it is to answer with the road ahead."""

from __future__ import annotations

import math

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node_subject import NodeSubject, configuration_problem, message_name, refusal
from sdc_workshop.exam.points import points_problem
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

MISSION = "/planner/mission_waypoints"
ODOMETRY = "/carla/ego_vehicle/odometry"
OBSTACLES = "/carla/ego_vehicle/obstacles"
ROAD = "/planner/local_waypoints"
# A bend to the left that begins at x = 30, y = 5: no coordinate is like another.
ROUTE = [
    (30.0 + 40.0 * math.sin(0.02 * i), 5.0 + 40.0 * (1.0 - math.cos(0.02 * i))) for i in range(90)
]
# x, y, yaw of the car: a little beside the route.
PLACES = [(38.3, 6.3, 0.25), (57.9, 16.6, 0.78)]


class LocalPlannerSubject(NodeSubject):
    """local_planner.py, TODO 1 to 4, 7 and 8."""

    file = f"{PACKAGE}/scripts/local_planner.py"
    todos = ("1", "2", "3", "4", "7", "8")
    init_todo = "2"
    needs = ("Waypoint", "BaseWaypoint", "Path", "LocalPath", "ObstacleArray")
    usual_topics = (ODOMETRY, OBSTACLES, ROAD)

    def problems(self, variant: Variant, stage) -> list:
        found = self._problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant, stage):
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import BaseWaypoint, LocalPath, Path

        with stage.node(variant, {}) as node:
            how = node.wait_until(
                lambda: (
                    node.subscribes(MISSION) and node.subscribes(ODOMETRY) and node.publishes(ROAD)
                )
            )
            found = self.start_problem(node, how, variant)
            if found is not None:
                return found
            if how == "ended":
                return self.ended_problem(node, variant)
            found = self.publisher_problem(
                node, ROAD, message_name("LocalPath"), "1"
            ) or self.subscriber_problem(node, MISSION, message_name("Path"), "3")
            if found is not None or variant.judged == ("2",):
                return found
            heard, mission, odometry = (
                node.listener(ROAD, LocalPath),
                node.publisher(MISSION, Path, latch=True),
                node.publisher(ODOMETRY, Odometry),
            )
            mission.publish(Path([BaseWaypoint(x, y) for x, y in ROUTE]))
            try:
                reference = self._reference(stage)
            except (TypeError, ValueError, KeyError) as error:
                return configuration_problem("local_planner", error)
            for place in PLACES:
                before = len(heard.messages)

                def say(place=place):
                    odometry.publish(odometry_at(*place, 4.0, rospy.Time.now()))

                wanted = [tuple(row) for row in reference(*place).tolist()]

                def answered(before=before, place=place):
                    # Answers to the place before may still be on their way.
                    return any(
                        math.dist((message.waypoints[0].x, message.waypoints[0].y), place[:2]) < 8.0
                        for message in heard.messages[before:]
                        if message.waypoints
                    )

                how = node.ask(say, answered)
                if how != "true":
                    return self._silence(node, how, variant, heard.messages[before:], wanted)
                got = [(point.x, point.y, point.v) for point in heard.messages[-1].waypoints]
                problem = points_problem(got, wanted, "the road ahead", "x, y, v")
                if problem is not None:
                    todo = next((todo for todo in ("8", "7", "4") if todo in variant.judged), None)
                    return Problem(problem.expected, problem.seen, problem.hint, todo)
            return self.crash_problem(node, variant)

    @staticmethod
    def _reference(stage):
        """The road ahead of a car at x, y, yaw, as the finished car plans it with the student's configuration."""
        import numpy as np

        from sdc_common.planning.speed_profile import SpeedLimits
        from sdc_package.local_planner import LocalPlanner
        from sdc_package.obstacles import ObstacleMargins
        from sdc_package.waypoint_search import WaypointSearch

        figures = stage.configuration("local_planner")
        limits = SpeedLimits(
            figures["planned_speed_mps"],
            figures["lateral_acceleration_mps2"],
            figures["acceleration_mps2"],
            figures["braking_mps2"],
            figures["lateral_jerk_mps3"],
        )
        route = np.array(ROUTE, np.float32).astype(float)
        planner = LocalPlanner(
            route,
            limits,
            figures["lookahead_m"],
            figures["join_within_m"],
            ObstacleMargins(**figures["caution"]),
        )
        search = WaypointSearch(planner.route.points)
        return lambda x, y, yaw: planner.plan(search.first_ahead(x, y), x, y, yaw)

    def _silence(self, node, how, variant, messages, wanted):
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        said = refusal(node)
        if messages:
            got = [(point.x, point.y, point.v) for point in messages[-1].waypoints]
            problem = points_problem(got, wanted, "the road ahead", "x, y, v")
            if problem is not None:
                return Problem(
                    problem.expected,
                    problem.seen,
                    problem.hint,
                    next((todo for todo in ("8", "7", "4") if todo in variant.judged), None),
                )
        if how == "busy":
            return Problem(
                "a road ahead for each odometry",
                "a callback runs in circles",
                "Is there a loop in it that never ends?",
            )
        if said is not None and "mission" in said:
            return Problem(
                "the mission is taken",
                f"the node says: {said}",
                "waypoints is an array of rows (x, y), one for each point of path.waypoints.",
                "4",
            )
        if said is not None:
            hint = (
                "The first waypoint ahead is that of this very place: self.search.first_ahead(x, y), with x and y of pose_and_speed in "
                "this order; then self.planner.plan(first, x, y, yaw, self.obstacles)."
                if "7" in variant.judged
                else "Are x and y of the mission swapped? Each row of the array is (point.x, point.y)."
            )
            return Problem(
                "a road ahead for each odometry",
                f"the node says: {said}",
                hint,
                "7" if "7" in variant.judged else "4",
            )
        if "3" in variant.judged and len(variant.judged) == 1:
            return Problem(
                "the mission arrives in on_mission",
                "the mission was published, and nothing happened",
                "The third argument of rospy.Subscriber is the function that is called with each message: self.on_mission.",
                "3",
            )
        todo = next((todo for todo in ("8", "7", "4", "3") if todo in variant.judged), None)
        return Problem(
            f"a LocalPath on {ROAD} for each odometry",
            "mission and odometry came, and nothing was published",
            {
                "8": "self.publisher.publish(...) sends the LocalPath: making one alone does not.",
                "7": "After this region `rows` is published: nothing before it may return.",
                "4": "After this region `waypoints` becomes the plan: nothing before it may return.",
            }.get(todo, "Is everything handed on?"),
            todo,
        )


def odometry_at(x, y, yaw, speed, stamp):
    """An odometry message: metres, radians, m/s."""
    from nav_msgs.msg import Odometry

    message = Odometry()
    message.header.stamp, message.header.frame_id, message.child_frame_id = (
        stamp,
        "map",
        "ego_vehicle",
    )
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = (
        math.sin(yaw / 2),
        math.cos(yaw / 2),
    )
    message.twist.twist.linear.x = speed
    return message
