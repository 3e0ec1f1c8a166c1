"""The mission planner: given a file of its own, it is to publish just that, to those who come late."""

from __future__ import annotations

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node_subject import NodeSubject, message_name
from sdc_workshop.exam.points import points_problem
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

TOPIC = "/planner/mission_waypoints"
FILE = "x,y\n10.0,1.0\n12.0,2.5\n14.5,5.0\n15.0,9.0\n13.5,13.25\n"
ROUTE = [(10.0, -1.0), (12.0, -2.5), (14.5, -5.0), (15.0, -9.0), (13.5, -13.25)]
BAD_FILE = "x,y\n1.0,1.0\n2.0,left\n"


class MissionPlannerSubject(NodeSubject):
    """mission_planner.py, TODO 1 to 9."""

    file = f"{PACKAGE}/scripts/mission_planner.py"
    todos = tuple("123456789")
    init_todo = "2"
    needs = ("BaseWaypoint", "Path")

    def problems(self, variant: Variant, stage) -> list:
        found = self._problem(variant, stage)
        if found is None and "5" in variant.judged:
            found = self._refusal_problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant, stage):
        from sdc_package.msg import Path

        path = stage.folder / "mission.csv"
        path.write_text(FILE, encoding="utf-8")
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            how = node.wait_until(lambda: node.publishes(TOPIC))
            if node.seen_types.get(TOPIC, message_name("Path")) != message_name("Path"):
                return self.type_problem(node.seen_types[TOPIC], message_name("Path"), "3")
            if how == "true" and not self.publisher_problem(node, TOPIC, message_name("Path"), "3"):
                heard = node.listener(TOPIC, Path)
                how = node.wait_until(lambda: heard.messages)
                if how != "true":
                    return self._silence(node, how, variant)
                problem = points_problem(
                    [(point.x, point.y) for point in heard.messages[-1].waypoints],
                    ROUTE,
                    "the file's waypoints",
                )
                if problem is not None:
                    return self._points(problem, variant, heard.messages[-1].waypoints)
                if not heard.latched:
                    return Problem(
                        "a latched publisher",
                        "it is not latched",
                        "rospy.Publisher(..., latch=True) repeats the last message to all who come later.",
                        "3",
                    )
                if node.wait_until(lambda: False) == "ended":
                    return self._ended(node, variant)
                return self.crash_problem(node, variant)
            found = self.start_problem(node, how, variant)
            if found is not None:
                return found
            if how == "ended" and node.program.status == 0:
                return self._ended(node, variant)
            if how == "ended":
                return self.ended_problem(node, variant)
            return self.publisher_problem(node, TOPIC, message_name("Path"), "3")

    def _points(self, problem, variant, points):
        if "4" in variant.judged and "8" not in variant.judged:
            return Problem(
                "the route of the file that the parameter waypoints_path names",
                f"a route of {len(points)} other points",
                'The launch file says which file it is: parameter("waypoints_path"). A name that is written into the program holds on '
                "one machine only.",
                "4",
            )
        todo = next((todo for todo in ("8", "5", "9", "6") if todo in variant.judged), None)
        if not points and todo == "5":
            return Problem(
                problem.expected,
                "an empty path",
                "self.waypoints is to hold what load_waypoints(waypoints_path) returns.",
                "5",
            )
        return Problem(problem.expected, problem.seen, problem.hint, todo)

    def _silence(self, node, how, variant):
        found = self.start_problem(node, how, variant)
        if found is not None:
            return found
        if how == "ended":
            return self._ended(node, variant)
        if "published a route" in node.output and "3" in variant.judged:
            return Problem(
                "who asks for the mission later gets it, too",
                "it was published, and who came later got nothing",
                "A mission is published once: rospy.Publisher(..., latch=True) keeps it for all who come later.",
                "3",
            )
        if "6" in variant.judged:
            return Problem(
                f"the mission on {TOPIC}",
                "the node runs, and publishes nothing",
                "run() has to call self.publish().",
                "6",
            )
        return Problem(
            f"the mission on {TOPIC}",
            "the node runs, and publishes nothing",
            "self.publisher.publish(Path(waypoints)) sends it: making a Path alone does not.",
            "9",
        )

    def _ended(self, node, variant):
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if node.program.status != 0:
            return self.ended_problem(node, variant)
        return Problem(
            "the node stays after it has published",
            "it ended at once, and took the mission along",
            "rospy.spin() keeps a node alive until ROS ends it. A latched message lives as long as its publisher.",
            "7",
        )

    def _refusal_problem(self, variant, stage):
        path = stage.folder / "bad.csv"
        path.write_text(BAD_FILE, encoding="utf-8")
        with stage.node(variant, {"waypoints_path": str(path)}) as node:
            # The end of a node of ROS takes a while, in which it only waits.
            how = next(
                (
                    how
                    for how in (node.wait_until(lambda: False) for _ in range(4))
                    if how != "idle"
                ),
                "idle",
            )
            if (
                how == "ended"
                and node.program.status == 1
                and f"{path}, row 3" in node.output
                and "Traceback" not in node.output
            ):
                return None
            if "Traceback" in node.output:
                found = self.crash_problem(node, variant)
                if "WaypointError" in found.seen:
                    return Problem(
                        "a bad file ends the node with one clear line",
                        "it ends with a traceback, which nobody reads",
                        "Catch it: try: ... except WaypointError as error: refuse(error).",
                        "5",
                    )
                return found
            return Problem(
                "a bad file ends the node with one clear line and exit status 1",
                f"it goes on with a bad file (row 3 of it is '{BAD_FILE.splitlines()[2]}')"
                if how != "ended"
                else f"it ends with status {node.program.status}",
                "except WaypointError as error: refuse(error) says it in one line and ends the node.",
                "5",
            )
