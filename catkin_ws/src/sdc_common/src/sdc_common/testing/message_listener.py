"""Waits for messages: for tests and checks, which must neither sleep a guess nor hang."""

from __future__ import annotations

import threading
import time

import rospy

# Of a message that was not the awaited one, so many letters are shown: a picture has millions.
_SHOWN = 2000


class MessageListener:
    """Collects the messages of a topic that `heeds` says True to. Waiting is done on the wall clock, so that it ends even where
    no /clock runs."""

    def __init__(self, topic: str, message_class, heeds=lambda message: True):
        self.topic = topic
        self._heeds = heeds
        self.messages = []
        self._changed = threading.Condition()
        self._subscriber = rospy.Subscriber(
            topic, message_class, self._on_message, tcp_nodelay=True
        )

    def wait_for_publisher(self, seconds: float = 15.0) -> None:
        """Wait until somebody publishes to this listener. Raises TimeoutError."""
        wait_until(self._subscriber.get_num_connections, seconds, f"a publisher of {self.topic}")

    def _on_message(self, message):
        if not self._heeds(message):
            return
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait_for(self, accepts=lambda message: True, seconds: float = 15.0, after: int = 0):
        """Return the first message, from number `after` on, that `accepts` says True to. Raises TimeoutError after `seconds`."""
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
                    last = str(self.messages[-1])[:_SHOWN] if self.messages else "none"
                    raise TimeoutError(
                        f"no such message on {self.topic} within {seconds:g} s; "
                        f"{len(self.messages)} came, the last:\n{last}"
                    )
                self._changed.wait(left)


def wait_until(condition, seconds: float = 15.0, what: str = "the condition"):
    """Return the first true value of `condition()`, polled. Raises TimeoutError after `seconds` of wall time."""
    limit = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > limit:
            raise TimeoutError(f"{what} did not come true within {seconds:g} s")
        time.sleep(0.01)


def wait_for_subscriber(publisher, seconds: float = 15.0):
    """Wait until somebody listens to `publisher`. Raises TimeoutError."""
    wait_until(publisher.get_num_connections, seconds, f"a connection to {publisher.resolved_name}")
