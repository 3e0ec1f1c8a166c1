"""Checks that all nodes share: the node starts, has its name, and connects to its topics."""

from __future__ import annotations

import difflib
import re

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.node import Node
from sdc_workshop.exam.output import crash, last_line, meaning, warnings
from sdc_workshop.exam.subject import Subject, name_of
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE, SOLUTION

_MISSING_PARAMETER = re.compile(r"parameter (/\S*?)/?(\w+) is missing")
ENDLESS_LOOP = "Is there a loop that never ends?"


class NodeSubject(Subject):
    """A script that is a node.

    Attributes:
        init_todo: the region that names the node
        usual_topics: topics that the given lines of the file use
    """

    init_todo: str
    usual_topics: tuple = ()

    @property
    def node_name(self) -> str:
        """Name of the node."""
        return name_of(self.file)

    def crash_problem(self, node: Node, variant: Variant) -> Problem | None:
        """Return the exception that the node did not catch, or None."""
        found = crash(node.output, node.path)
        if found is None:
            return None
        todo = variant.region_of(found.line) if found.line is not None else None
        shown = variant.text.split("\n")[found.line - 1].strip() if found.line else None
        place = f", in `{shown}`" if shown else ""
        if found.library_line and shown:
            place += f" (raised in {found.library_line})"
        return Problem(
            f"{self.node_name}.py runs without an error",
            f"{found.error[:300]}{place}",
            meaning(found),
            todo,
            found.line,
            True,
        )

    def start_problem(self, node: Node, how: str, variant: Variant) -> Problem | None:
        """Return why a node did not get ready, or None where that is unknown.

        Args:
            node: the node
            how: result of Program.wait_until
            variant: its file
        """
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how in ("busy", "late"):
            node.stage.report("it never got ready, and was ended")
            return Problem(
                f"{self.node_name}.py gets ready and then waits for messages",
                "it loops and never gets ready",
                f"{ENDLESS_LOOP} rospy.spin() is how a node waits.",
            )
        missing = _MISSING_PARAMETER.search(node.output)
        if missing:
            name, parameter = missing.groups()
            if name == f"/{self.node_name}":
                return Problem(
                    "only parameters that the launch file and the configuration set",
                    f"it reads the parameter {parameter}, which is not set",
                    f"There is no parameter {parameter}: is its name misspelt?",
                )
            return self._name_problem(name if name not in ("", "/unnamed") else None)
        names = node.names
        if names and names != [f"/{self.node_name}"]:
            return self._name_problem(names[0])
        return None

    def _name_problem(self, name: str | None) -> Problem:
        right = f'rospy.init_node("{self.node_name}")'
        if name is None:
            return Problem(
                f"a node with the name {self.node_name}",
                "no node is registered with ROS",
                f"Write {right}, with parentheses and the name in quotes.",
                self.init_todo,
            )
        return Problem(
            f"a node with the name /{self.node_name}",
            f"its name is {name}",
            f"Name it {self.node_name}: {right}. Its parameters are stored under this name.",
            self.init_todo,
        )

    def ended_problem(self, node: Node, variant: Variant) -> Problem:
        """Return why a node ended that must keep running."""
        found = self.start_problem(node, "ended", variant)
        if found is not None:
            return found
        return Problem(
            f"{self.node_name}.py keeps running",
            f"it ended with status {node.program.status}; its last line: {last_line(node.output)}",
            "The last line of its output gives the cause.",
        )

    def subscriber_problem(self, node: Node, topic: str, kind: str, todo: str) -> Problem | None:
        """Return why the node does not subscribe to a topic with this type, or None."""
        got = node.subscribes(topic)
        if got in (kind, "?"):
            return None
        package, _, name = kind.partition("/")
        if got is not None:
            return Problem(
                f"a subscriber to {topic} with the type {kind}",
                f"its type is {got}",
                "The second argument of rospy.Subscriber is the class of the message: "
                f"{name}, of {package}.",
                todo,
            )
        published, subscribed = node.topics()
        others = [other for other in subscribed if other not in self.usual_topics]
        near = difflib.get_close_matches(topic, others, 1, 0.5)
        expected = f"a subscriber to {topic}"
        if near:
            return Problem(
                expected,
                f"a subscriber to {near[0]}",
                f"The topic is {topic}, letter for letter: on another topic no message ever "
                "arrives, and ROS reports no error.",
                todo,
            )
        if topic in published:
            return Problem(
                expected,
                "a publisher of it",
                "rospy.Subscriber receives, rospy.Publisher sends.",
                todo,
            )
        return Problem(
            expected,
            f"it subscribes to {', '.join(others or subscribed) or 'nothing'}",
            f"rospy.Subscriber takes the topic {topic}, the class of the messages and the "
            "callback.",
            todo,
        )

    def publisher_problem(self, node: Node, topic: str, kind: str, todo: str) -> Problem | None:
        """Return why the node does not publish a topic with this type, or None."""
        got = node.publishes(topic)
        if got in (kind, "?"):
            return None
        if got is not None:
            return self.type_problem(got, kind, todo)
        published, subscribed = node.topics()
        if topic in subscribed and topic not in self.usual_topics:
            return Problem(
                f"a publisher of {topic}",
                "a subscriber to it",
                "rospy.Publisher sends, rospy.Subscriber receives.",
                todo,
            )
        others = [name for name in published if name not in self.usual_topics]
        return Problem(
            f"a publisher of {topic}",
            f"it publishes {', '.join(others) or 'nothing'}",
            f"The topic is {topic}, letter for letter: other nodes subscribe to this one.",
            todo,
        )

    @staticmethod
    def type_problem(got: str, kind: str, todo: str) -> Problem:
        """Return the problem of a publisher with another type."""
        package, _, name = kind.partition("/")
        return Problem(
            f"a publisher of {kind}",
            f"its type is {got}",
            f"The second argument is the class of the message: {name}, of {package}.",
            todo,
        )


def configuration_problem(name: str, error: Exception) -> Problem:
    """Return the problem of a configuration that the solution cannot use either."""
    return Problem(
        f"valid parameters in config/{name}.yaml",
        f"{type(error).__name__}: {error}",
        f"Compare config/{name}.yaml with {SOLUTION / PACKAGE / 'config' / name}.yaml.",
    )


def message_name(name: str) -> str:
    """Return the full name of a message of the package."""
    return f"{PACKAGE}/{name}"


def refusal(node: Node) -> str | None:
    """Return the last warning of a node, or None."""
    logged = warnings(node.output)
    return logged[-1] if logged else None
