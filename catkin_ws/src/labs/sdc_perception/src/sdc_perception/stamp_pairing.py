"""Pair the messages of several topics by their stamps."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

_LONGEST_WAIT = 40


class StampPairing:
    """Calls `answer(*messages)` once for each stamp, when every topic has a message with it.

    Stamps that are not later than the last answered one are ignored. A lock serializes the calls of
    several threads.
    """

    def __init__(self, topics: int, answer: Callable[..., None]):
        self._answer = answer
        self._waiting: list[dict[int, Any]] = [{} for _ in range(topics)]
        self._answered_ns = -1
        self._lock = threading.Lock()

    def add(self, topic: int, message: Any) -> None:
        """Add a message with a header, of the topic with this number."""
        with self._lock:
            stamp_ns = message.header.stamp.to_nsec()
            if stamp_ns <= self._answered_ns:
                return
            waiting = self._waiting[topic]
            waiting[stamp_ns] = message
            if len(waiting) > _LONGEST_WAIT:
                del waiting[min(waiting)]
            messages = messages_with_stamp(self._waiting, stamp_ns)
            if messages is not None:
                self._answered_ns = stamp_ns
                for others in self._waiting:
                    for old in [other for other in others if other <= stamp_ns]:
                        del others[old]
                self._answer(*messages)


def messages_with_stamp(waiting: list[dict[int, Any]], stamp_ns: int) -> list[Any] | None:
    """Return the message of each topic with a stamp, or None while one of them has not arrived.

    Args:
        waiting: for each topic, its messages by their stamps [ns]
        stamp_ns: the stamp [ns]
    """
    # TODO 10: one message of each topic, all of the same instant (until then: return None)
    if all(stamp_ns in messages for messages in waiting):
        return [messages[stamp_ns] for messages in waiting]
    return None
    # ----------------------------------------------------------------------------
