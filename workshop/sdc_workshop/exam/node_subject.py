"""What all nodes have in common when they are tried: they start, take their name, and are connected to their topics."""

from __future__ import annotations

import difflib
import re

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.output import crash, last_words, meaning, warnings
from sdc_workshop.exam.subject import Subject, name_of
from sdc_workshop.workspace import PACKAGE, SOLUTION

_MISSING_PARAMETER = re.compile(r"parameter (/\S*?)/?(\w+) is missing")


class NodeSubject(Subject):
    """A script that is a node. `init_todo` is where it takes its name."""

    init_todo: str

    @property
    def node_name(self) -> str:
        return name_of(self.file)

    def crash_problem(self, node, variant) -> Problem | None:
        """An error that the node did not catch, in its main thread or in a callback."""
        found = crash(node.output, node.path)
        if found is None:
            return None
        todo = variant.region_of(found.line) if found.line is not None else None
        shown = variant.text.split("\n")[found.line - 1].strip() if found.line else None
        place = f", in `{shown}`" if shown else ""
        place += (
            f" (called from there: {found.library_line})" if found.library_line and shown else ""
        )
        return Problem(
            f"{self.node_name}.py runs without an error",
            f"{found.error[:300]}{place}",
            meaning(found),
            todo,
            found.line,
            True,
        )

    def start_problem(self, node, how: str, variant) -> Problem | None:
        """Why a node that was just started did not come to where it was waited for; None when that is not known. `how`: as
        Program.wait_until has it."""
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how in ("busy", "late"):
            return Problem(
                f"{self.node_name}.py gets ready and then waits for messages",
                "it runs in circles and never gets ready",
                "Is there a loop that never ends? Where a node waits, rospy.spin() does it.",
            )
        missing = _MISSING_PARAMETER.search(node.output)
        if missing:
            name, parameter = missing.groups()
            if name == f"/{self.node_name}":
                return Problem(
                    "only parameters that the launch file and config set",
                    f"{parameter} is asked for, which nobody sets",
                    f"The parameter {parameter} does not exist: is its name misspelt?",
                )
            return self._name_problem(name if name not in ("", "/unnamed") else None)
        names = node.names
        if names and names != [f"/{self.node_name}"]:
            return self._name_problem(names[0])
        return None

    def _name_problem(self, name):
        right = f'rospy.init_node("{self.node_name}")'
        if name is None:
            return Problem(
                f"a node called {self.node_name}",
                "nothing has been registered with ROS",
                f"{right} belongs here, with parentheses and the name in quotes.",
                self.init_todo,
            )
        return Problem(
            f"a node called /{self.node_name}",
            f"it is called {name}",
            f"Call it {self.node_name}: {right}. Its parameters, and others who look for it, know it by exactly this name.",
            self.init_todo,
        )

    def ended_problem(self, node, variant) -> Problem:
        """Why a node ended that should not have."""
        found = self.start_problem(node, "ended", variant)
        if found is not None:
            return found
        return Problem(
            f"{self.node_name}.py keeps running",
            f"it ended with status {node.program.status}; its last words: {last_words(node.output)}",
            "Its last words say why.",
        )

    def subscriber_problem(self, node, topic, kind, todo) -> Problem | None:
        """Whether it listens where it should."""
        got = node.subscribes(topic)
        if got in (kind, "?"):
            return None
        if got is not None:
            return Problem(
                f"it listens to {topic} for messages of type {kind}",
                f"it takes them for {got}",
                f"The second argument of rospy.Subscriber is the message's class: {kind.rpartition('/')[2]}, of {kind.partition('/')[0]}.",
                todo,
            )
        _, mine = node.topics()
        others = [name for name in mine if name not in self.usual_topics]
        near = difflib.get_close_matches(topic, others, 1, 0.5)
        if near:
            return Problem(
                f"it listens to {topic}",
                f"it listens to {near[0]}",
                f"The topic's name is {topic}, to the letter: on another one nothing ever comes, and nobody complains.",
                todo,
            )
        published, _ = node.topics()
        if topic in published:
            return Problem(
                f"it listens to {topic}",
                "it publishes there",
                "rospy.Subscriber listens, rospy.Publisher speaks.",
                todo,
            )
        return Problem(
            f"it listens to {topic}",
            f"it listens to {', '.join(others or mine) or 'nothing'}",
            f"rospy.Subscriber takes the topic {topic}, the class of its messages, and the function to call.",
            todo,
        )

    def publisher_problem(self, node, topic, kind, todo) -> Problem | None:
        """Whether it publishes where it should."""
        got = node.publishes(topic)
        if got in (kind, "?"):
            return None
        if got is not None:
            return self.type_problem(got, kind, todo)
        published, subscribed = node.topics()
        if topic in subscribed and topic not in self.usual_topics:
            return Problem(
                f"it publishes on {topic}",
                "it listens there",
                "rospy.Publisher speaks, rospy.Subscriber listens.",
                todo,
            )
        others = [name for name in published if name not in self.usual_topics]
        return Problem(
            f"it publishes on {topic}",
            f"it publishes on {', '.join(others) or 'nothing'}",
            f"The topic's name is {topic}, to the letter: others listen there and nowhere else.",
            todo,
        )

    @staticmethod
    def type_problem(got, kind, todo) -> Problem:
        """A publisher for another kind of message."""
        return Problem(
            f"a publisher of {kind}",
            f"the publisher is for {got}",
            f"The second argument is the message's class: {kind.rpartition('/')[2]}, of {kind.partition('/')[0]}.",
            todo,
        )

    # Topics that the file as it is given uses already.
    usual_topics: tuple = ()


def configuration_problem(name: str, error: Exception) -> Problem:
    """A configuration that the finished car cannot drive with either."""
    return Problem(
        f"figures in config/{name}.yaml that a car can drive with",
        f"{type(error).__name__}: {error}",
        f"Compare config/{name}.yaml with {SOLUTION / PACKAGE / 'config' / name}.yaml.",
    )


def message_name(name: str) -> str:
    return f"{PACKAGE}/{name}"


def refusal(node) -> str | None:
    """What it has complained about last."""
    said = warnings(node.output)
    return said[-1] if said else None
