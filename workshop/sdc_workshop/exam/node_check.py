"""Check nodes: what all share is that a node starts, has its name, and connects to its topics.

What a node must do with messages is in the subclasses; what a student reads about a node that does
not answer is in checks.yaml.
"""

from __future__ import annotations

import difflib
import re
from pathlib import Path

from sdc_workshop.exam.answer import Answer, listed, mistake
from sdc_workshop.exam.node import Node, running_node
from sdc_workshop.exam.output import Crash, last_line, meaning, warnings
from sdc_workshop.exam.region_check import RegionCheck
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE, SOLUTION

_MISSING_PARAMETER = re.compile(r"parameter (/\S*?)/?(\w+) is missing")
_ENDLESS_LOOP = "Is there a loop that never ends?"
# A node sleeps for less than this before an answer; on a busy machine it may be more at times.
_PROMPT_S, _PROMPT_ANSWERS = 0.1, 3


class NodeCheck(RegionCheck):
    """Checks a script that is a node, by its entry of checks.yaml.

    There `refused` and `silent` are rows about a node that logs a warning or publishes nothing; the
    first row about a judged region counts.
    """

    init_todo: str  # the region that names the node
    given_topics: tuple = ()  # topics that the given lines of the file use
    # (publishes or subscribes, topic, type, region that connects it or None) of each topic that the
    # node must connect to before it gets messages
    topics: tuple = ()
    answer: str  # what the node publishes, for people
    waits_for = "the node starts, connects and answers messages"

    def __init__(self, table: dict):
        self._table = table
        self.node_name = Path(self.file).stem

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        with running_node(stage, variant, self.parameters(stage)) as node:
            found = self.connection_problem(node, variant)
            if found is None and variant.judged != (self.init_todo,):
                found = self.answer_problem(node, variant, stage)
                found = found or self.crash_problem(node, variant)
        return [found] if found is not None else []

    def parameters(self, stage: Stage) -> dict:
        """Return parameters that replace those of the node's configuration."""
        return {}

    def answer_problem(self, node: Node, variant: Variant, stage: Stage) -> Answer | None:
        """Send messages to the node that is connected; return what is wrong with its answers."""
        raise NotImplementedError

    def connection_problem(self, node: Node, variant: Variant) -> Answer | None:
        """Return why the node does not start or connect, or None."""
        how = node.program.wait_until(
            lambda: all(node.type_of(does, topic) for does, topic, _, _ in self.topics)
        )
        found = self.start_problem(node, how, variant)
        if found is not None or how == "ended":
            return found or self.ended_problem(node, variant)
        for does, topic, kind, todo in filter(lambda row: row[3], self.topics):
            found = found or self.topic_problem(node, does, topic, kind, todo)
        return found

    def crash_problem(self, node: Node, variant: Variant) -> Answer | None:
        """Return the exception that the node did not catch, or None."""
        return self.exception_problem(node.program.output, node.path, variant)

    def start_problem(self, node: Node, how: str, variant: Variant) -> Answer | None:
        """Return why a node did not get ready, or None where that is unknown.

        `how` is the result of Program.wait_until.
        """
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how == "busy":
            node.stage.report("it never got ready, and was ended")
            return listed("never_ready", node_name=self.node_name, loop=_ENDLESS_LOOP)
        missing = _MISSING_PARAMETER.search(node.program.output)
        if missing:
            name, parameter = missing.groups()
            if name == f"/{self.node_name}":
                return listed("unknown_parameter", parameter=parameter)
            return self._name_problem(name if name not in ("", "/unnamed") else None)
        uses = [nodes for topics in node.stage.state()[:2] for nodes in topics.values()]
        names = sorted({name for nodes in uses for name in nodes})
        if names and names != [f"/{self.node_name}"]:
            return self._name_problem(names[0])
        return None

    def _name_problem(self, name: str | None) -> Answer:
        texts = {"node_name": self.node_name, "right": f'rospy.init_node("{self.node_name}")'}
        key = "no_name" if name is None else "node_name"
        key = "anonymous" if str(name).startswith(f"/{self.node_name}_") else key
        return listed(key, todo=self.init_todo, name=name, **texts)

    def ended_problem(self, node: Node, variant: Variant) -> Answer:
        """Return why a node ended that must keep running."""
        return self.start_problem(node, "ended", variant) or listed(
            "node_ended",
            node_name=self.node_name,
            status=node.program.status,
            last=last_line(node.program.output),
        )

    def topic_problem(
        self, node: Node, does: str, topic: str, kind: str, todo: str
    ) -> Answer | None:
        """Return why the node does not use a topic as a row of `topics` says, or None."""
        got = node.type_of(does, topic)
        if got in (kind, "?"):
            return None
        published, subscribed = node.topics()
        mine, others = (published, subscribed) if does == "publishes" else (subscribed, published)
        own = [name for name in mine if name not in self.given_topics]
        near = difflib.get_close_matches(topic, own, 1, 0.5)
        if got is not None:
            key = "another_type"
        elif near:
            key, got = "misspelt_topic", near[0]
        elif topic in others and topic not in self.given_topics:
            key = "other_direction"
        else:
            key, got = "no_topic", ", ".join(own or mine) or "nothing"
        return listed(f"{does}_{key}", todo=todo, topic=topic, kind=kind, got=got)

    def silence_problem(self, node: Node, how: str, variant: Variant) -> Answer:
        """Return why a connected node does not answer; `how` is as in Program.wait_until."""
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how == "busy":
            return mistake(self.answer, "a callback never returns", _ENDLESS_LOOP)
        logged = warnings(node.program.output)[-1:]
        for text in logged:
            for row in self._table.get("refused", ()):
                if row["todo"] in variant.judged and row.get("word", "") in text:
                    seen = f"the node logs: {text}"
                    # The class of an exception is not logged.
                    known = (Crash(f"{kind}: {text}", None) for kind in ("TypeError", "ValueError"))
                    hints = (meaning(crash, unknown="") for crash in known if "word" not in row)
                    hint = next(filter(None, hints), row["hint"])
                    return mistake(row["expected"], seen, hint, row["todo"])
        rows = [row for row in self._table["silent"] if row["todo"] in self.todos]
        row = next((row for row in rows if row["todo"] in variant.judged), rows[-1])
        return mistake(row.get("expected", self.answer), row["seen"], row["hint"], row["todo"])


def delay_problem(delays_s: list, todo: str | None) -> Answer | None:
    """Return the problem of a node that sleeps before nearly all answers, or None."""
    delay_s = sorted(delays_s)[:_PROMPT_ANSWERS][-1]
    if delay_s < _PROMPT_S:
        return None
    return listed("sleeps", todo=todo, delay_s=delay_s)


def first_of(todos: tuple, variant: Variant) -> str | None:
    """Return the first of some regions that is judged, or None."""
    return next((todo for todo in todos if todo in variant.judged), None)


def configuration_problem(name: str, error: Exception) -> Answer:
    """Return the problem of a configuration that the solution cannot use either."""
    seen = f"{type(error).__name__}: {error}"
    return listed("configuration", name=name, seen=seen, right=SOLUTION / PACKAGE / "config")
