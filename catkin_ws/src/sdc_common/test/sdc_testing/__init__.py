"""Helpers of tests: wait for messages with a timeout, import the script of a node.

Tests run without ROS, too: what needs it is imported where it is used.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import threading
from collections.abc import Callable
from types import ModuleType
from typing import Any

# Characters of an unexpected message that an error shows: a picture has millions.
_MAX_SHOWN = 2000


class MessageListener:
    """Collects the messages of a topic; waiting uses the wall clock and needs no /clock.

    Attributes:
        topic: name of the topic
        messages: the collected messages
    """

    def __init__(
        self, topic: str, message_class: type, collects: Callable[[Any], bool] = lambda _: True
    ):
        """Subscribe to a topic.

        Args:
            topic: name of the topic
            message_class: type of its messages
            collects: returns whether to collect a message
        """
        self.topic = topic
        self._collects = collects
        self.messages: list = []
        self._changed = threading.Condition()
        import rospy

        self._subscriber = rospy.Subscriber(
            topic, message_class, self._on_message, tcp_nodelay=True
        )

    def wait_for_publisher(self, seconds: float = 15.0) -> None:
        """Wait until a publisher is connected; raise TimeoutError after `seconds`."""
        from sdc_common.processes import wait_until

        wait_until(self._subscriber.get_num_connections, seconds, f"a publisher of {self.topic}")

    def _on_message(self, message: Any) -> None:
        if self._collects(message):
            with self._changed:
                self.messages.append(message)
                self._changed.notify_all()

    def wait_for(
        self, accepts: Callable[[Any], bool] = lambda _: True, seconds: float = 15.0, after: int = 0
    ) -> Any:
        """Return the first message that is accepted.

        Args:
            accepts: returns whether to accept a message
            seconds: timeout [s]
            after: index of the first message to look at

        Raises:
            TimeoutError: there is none after `seconds`
        """
        accepted: list = []

        def is_accepted() -> bool:
            nonlocal after
            for message in self.messages[after:]:
                after += 1
                if accepts(message):
                    accepted.append(message)
                    return True
            return False

        with self._changed:
            if self._changed.wait_for(is_accepted, seconds):
                return accepted[0]
        last = str(self.messages[-1])[:_MAX_SHOWN] if self.messages else "none"
        raise TimeoutError(
            f"no such message on {self.topic} within {seconds:g} s; "
            f"{len(self.messages)} received, the last:\n{last}"
        )


def wait_for_subscriber(publisher: Any, seconds: float = 15.0) -> None:
    """Wait until a subscriber of `publisher` is connected; raise TimeoutError after `seconds`."""
    from sdc_common.processes import wait_until

    wait_until(publisher.get_num_connections, seconds, f"a subscriber of {publisher.resolved_name}")


def load_script(path: str) -> ModuleType:
    """Return the script of a node as a new module, without starting the node."""
    name = os.path.basename(path).partition(".")[0] + "_script"
    loader = importlib.machinery.SourceFileLoader(name, path)
    spec = importlib.util.spec_from_loader(name, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module
