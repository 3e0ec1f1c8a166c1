"""Wait for messages in tests and checks, with a timeout."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import rospy

# Characters of an unexpected message that an error shows: a picture has millions.
_MAX_SHOWN = 2000


def _any_message(_message: object) -> bool:
    return True


class MessageListener:
    """Collects the messages of a topic.

    Waiting uses the wall clock, so that it ends without a /clock, too.

    Attributes:
        topic: name of the topic
        messages: the collected messages
    """

    def __init__(
        self, topic: str, message_class: type, collects: Callable[[Any], bool] = _any_message
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
        self._subscriber = rospy.Subscriber(
            topic, message_class, self._on_message, tcp_nodelay=True
        )

    def wait_for_publisher(self, seconds: float = 15.0) -> None:
        """Wait until a publisher is connected.

        Raises:
            TimeoutError: there is none after `seconds`
        """
        wait_until(self._subscriber.get_num_connections, seconds, f"a publisher of {self.topic}")

    def _on_message(self, message: Any) -> None:
        if not self._collects(message):
            return
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait_for(
        self, accepts: Callable[[Any], bool] = _any_message, seconds: float = 15.0, after: int = 0
    ) -> Any:
        """Return the first message that is accepted.

        Args:
            accepts: returns whether to accept a message
            seconds: timeout [s]
            after: index of the first message to look at

        Raises:
            TimeoutError: there is none after `seconds`
        """
        limit = time.monotonic() + seconds
        seen = after
        with self._changed:
            while True:
                while seen < len(self.messages):
                    if accepts(self.messages[seen]):
                        return self.messages[seen]
                    seen += 1
                left = limit - time.monotonic()
                if left <= 0.0:
                    last = str(self.messages[-1])[:_MAX_SHOWN] if self.messages else "none"
                    raise TimeoutError(
                        f"no such message on {self.topic} within {seconds:g} s; "
                        f"{len(self.messages)} received, the last:\n{last}"
                    )
                self._changed.wait(left)


def wait_until(
    condition: Callable[[], Any], seconds: float = 15.0, what: str = "the condition"
) -> Any:
    """Return the first true value of a condition, which is polled.

    Args:
        condition: returns a true value when the wait is over
        seconds: timeout [s]
        what: what the error reports as missing

    Raises:
        TimeoutError: the condition is still false after `seconds`
    """
    limit = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > limit:
            raise TimeoutError(f"{what} is still missing after {seconds:g} s")
        time.sleep(0.01)


def wait_for_subscriber(publisher: rospy.Publisher, seconds: float = 15.0) -> None:
    """Wait until a subscriber of `publisher` is connected.

    Raises:
        TimeoutError: there is none after `seconds`
    """
    wait_until(publisher.get_num_connections, seconds, f"a subscriber of {publisher.resolved_name}")
