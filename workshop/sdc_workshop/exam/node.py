"""A student's node that runs for a check, and the check's ends of its topics."""

from __future__ import annotations

import contextlib
import glob
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Iterator

from sdc_workshop.exam.process import Program
from sdc_workshop.exam.stage import NAME, Stage
from sdc_workshop.exam.variant import Variant

if TYPE_CHECKING:
    import rospy

# A message that is not answered is sent again after this time [s].
_REPEAT_S = 0.2
_POLL_S = 0.02
_CONNECTION_TIMEOUT_S = 10.0
# Number of answers whose delays are measured.
_ANSWERS = 8


@contextlib.contextmanager
def running_node(
    stage: Stage, variant: Variant, parameters: dict, **environment: str
) -> Iterator[Node]:
    """Run a variant of scripts/NAME.py, with parameters that replace those of config/NAME.yaml.

    Raises:
        NotBuilt: see Student.environment
    """
    name = Path(variant.name).stem
    stage.student.environment  # noqa: B018  without a build, not even a master is needed
    api = stage.master.handler
    api.setParam(NAME, f"/{name}", {**stage.configuration(name), **parameters})
    path, python_path = stage.build(variant)
    command = ["/usr/bin/env", "python3", path]
    node = Node(stage, stage.program(command, PYTHONPATH=python_path, **environment), path)
    try:
        yield node
    finally:
        node.close()
        stage.unregister_nodes()
        api.deleteParam(NAME, f"/{name}")


class Received:
    """The messages that a subscriber of the check has received on a topic, in order."""

    def __init__(self, topic: str, message_class: type):
        import rospy

        self.messages: list[Any] = []
        self.subscriber = rospy.Subscriber(
            topic, message_class, self.messages.append, tcp_nodelay=True
        )

    @property
    def latched(self) -> bool:
        """Whether the publisher of the last message is latched."""
        return bool(self.messages) and self.messages[-1]._connection_header.get("latching") == "1"


class Node:
    """A running node: its stage, its process and the path of its file.

    `waited_s` is how long it has slept before its last answer [s].
    """

    def __init__(self, stage: Stage, program: Program, path: Path):
        self.stage = stage
        self.program = program
        self.path = path
        self.waited_s = 0.0
        self._types: dict = {}
        self._ends: list = []
        self._awaited: list = []

    def type_of(self, does: str, topic: str) -> str | None:
        """Return the type with which it uses a topic, or did when it was asked for first, or None.

        It "publishes", or "subscribes", which is unknown once the check publishes the topic.
        """
        published, subscribed, types = self.stage.state()
        if topic in (published if does == "publishes" else subscribed):
            self._types.setdefault((does, topic), types.get(topic, "?"))
        return self._types.get((does, topic))

    def topics(self) -> tuple:
        """Return the topics that it publishes and subscribes to, without those of every node."""
        published, subscribed, _ = self.stage.state()
        return sorted(set(published) - {"/rosout"}), sorted(set(subscribed) - {"/clock"})

    def publisher(self, topic: str, message_class: type, latch: bool = False) -> rospy.Publisher:
        """Return a publisher of the check."""
        import rospy

        end = rospy.Publisher(topic, message_class, queue_size=20, latch=latch, tcp_nodelay=True)
        self._ends.append(end)
        return end

    def subscriber(self, topic: str, message_class: type) -> Received:
        """Return the messages that a new subscriber of the check receives."""
        received = Received(topic, message_class)
        self._ends.append(received.subscriber)
        return received

    def send_until(self, send: Callable[[], object], is_answered: Callable[[], object]) -> str:
        """Call `send()` repeatedly until `is_answered()`; return as Program.wait_until.

        It is repeated because messages are lost while a connection is set up.
        """
        self._wait_for_connections()
        sent_at = [0.0]
        self.waited_s = 0.0
        how = "true"

        def condition() -> bool:
            if is_answered():
                return True
            self.waited_s += 0.0 if self._is_running() else _POLL_S
            if time.monotonic() - sent_at[0] > _REPEAT_S:
                send()
                sent_at[0] = time.monotonic()
            return False

        for _ in range(2):
            how = self.program.wait_until(condition)
            if how != "idle":
                return how
        return how

    def delays_s(self, send: Callable[[], object], received: list) -> list:
        """Send messages, each when the last one is answered; return `waited_s` of each."""
        delays: list = []
        for count in range(len(received), len(received) + _ANSWERS):
            self.send_until(send, lambda count=count: len(received) > count)  # type: ignore[misc]
            delays.append(self.waited_s)
        return delays

    def _is_running(self) -> bool:
        """Return whether one of its threads computes, or would if it had a processor."""
        running = False
        for path in glob.glob(f"/proc/{self.program.main.pid}/task/*/stat"):
            with contextlib.suppress(OSError):
                state = Path(path).read_text(encoding="utf-8").rpartition(") ")[2][:1]
                running = running or state in "RD"
        return running

    def _wait_for_connections(self) -> None:
        """Wait for the connections to new ends: a node that is not connected yet is not idle."""
        import rospy

        published, subscribed, _ = self.stage.state()
        new = [end for end in self._ends if end not in self._awaited]
        self._awaited += new
        limit = time.monotonic() + _CONNECTION_TIMEOUT_S
        for end in new:
            peers = subscribed if isinstance(end, rospy.Publisher) else published
            while (
                end.resolved_name in peers
                and not end.get_num_connections()
                and self.program.status is None
                and time.monotonic() < limit
            ):
                time.sleep(_POLL_S)

    def close(self) -> None:
        """End it, and the check's ends of its topics."""
        for end in self._ends:
            end.unregister()
        self.program.end()
