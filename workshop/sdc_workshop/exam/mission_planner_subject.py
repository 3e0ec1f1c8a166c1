"""Check of the mission planner: it gets a file and must publish its route, latched."""

from __future__ import annotations

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.node_subject import NodeSubject, message_name
from sdc_workshop.exam.points import points_problem
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

TOPIC = "/planner/mission_waypoints"
FILE = "x,y\n10.0,1.0\n12.0,2.5\n14.5,5.0\n15.0,9.0\n13.5,13.25\n"
ROUTE = [(10.0, -1.0), (12.0, -2.5), (14.5, -5.0), (15.0, -9.0), (13.5, -13.25)]
BAD_FILE = "x,y\n1.0,1.0\n2.0,left\n"
# A ROS node ends within this time after it has unregistered its topics.
_SHUTDOWN_S = 5.0


class MissionPlannerSubject(NodeSubject):
    """mission_planner.py, TODO 1 to 8."""

    file = f"{PACKAGE}/scripts/mission_planner.py"
    todos = tuple("12345678")
    init_todo = "2"
    needs = ("BaseWaypoint", "Path")

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        found = self._problem(variant, stage)
        if found is None and "5" in variant.judged:
            found = self._refusal_problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant: Variant, stage: Stage) -> Problem | None:
        path = stage.folder / "mission.csv"
        path.write_text(FILE, encoding="utf-8")
        kind = message_name("Path")
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            how = _settled(node, node.wait_until(lambda: node.publishes(TOPIC)))
            if node.seen_types.get(TOPIC, kind) != kind:
                return self.type_problem(node.seen_types[TOPIC], kind, "3")
            if how == "true":
                return self._mission_problem(node, variant)
            found = self.start_problem(node, how, variant)
            if found is not None:
                return found
            if how == "ended" and node.program.status == 0:
                return self._ended(node, variant)
            if how == "ended":
                return self.ended_problem(node, variant)
            return self.publisher_problem(node, TOPIC, kind, "3")

    def _mission_problem(self, node: Node, variant: Variant) -> Problem | None:
        """Return what is wrong with the mission that the node publishes, or None."""
        from sdc_package.msg import Path

        received = node.subscriber(TOPIC, Path)
        how = _settled(node, node.wait_until(lambda: received.messages))
        if how != "true":
            return self._silence(node, how, variant)
        points = [(point.x, point.y) for point in received.messages[-1].waypoints]
        problem = points_problem(points, ROUTE, "the waypoints of the file")
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
        todo = next((todo for todo in ("6", "5", "7") if todo in variant.judged), None)
        if not points and todo == "5":
            return Problem(
                problem.expected,
                "an empty path",
                "Assign the result of load_waypoints(waypoints_path) to self.waypoints.",
                "5",
            )
        return Problem(problem.expected, problem.seen, problem.hint, todo)

    def _silence(self, node: Node, how: str, variant: Variant) -> Problem:
        found = self.start_problem(node, how, variant)
        if found is not None:
            return found
        if how == "ended":
            return self._ended(node, variant)
        if "published a route" in node.output and "3" in variant.judged:
            return Problem(
                "a subscriber that starts later receives the mission, too",
                "the mission was published, and a later subscriber received nothing",
                "The mission is published once: rospy.Publisher(..., latch=True) sends it to new "
                "subscribers.",
                "3",
            )
        return Problem(
            f"the mission on {TOPIC}",
            "the node runs, and publishes nothing",
            "self.publisher.publish(Path(waypoints)) publishes it; Path(waypoints) alone does not.",
            "7",
        )

    def _ended(self, node: Node, variant: Variant) -> Problem:
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if node.program.status != 0:
            return self.ended_problem(node, variant)
        return Problem(
            "the node keeps running after it has published",
            "it ended at once, and its latched message with it",
            "rospy.spin() keeps a node running until ROS ends it. A latched message exists as long "
            "as its publisher.",
            "8",
        )

    def _refusal_problem(self, variant: Variant, stage: Stage) -> Problem | None:
        path = stage.folder / "bad.csv"
        path.write_text(BAD_FILE, encoding="utf-8")
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            # A ROS node takes a while to end, during which it only waits.
            results = (node.wait_until(lambda: False) for _ in range(4))
            how = next((how for how in results if how != "idle"), "idle")
            output = node.output
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
            seen = f"it continues, although row 3 of the file is '{BAD_FILE.splitlines()[2]}'"
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
    unregistered = how == "idle" and node.publishes(TOPIC) is None
    return "ended" if unregistered and node.program.wait(_SHUTDOWN_S) is not None else how
