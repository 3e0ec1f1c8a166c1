"""Subscriptions that exist only while someone watches, and the newest message of each."""

from __future__ import annotations

import struct
import threading
import time
from dataclasses import dataclass
from typing import Any, Callable

import genpy
import rospy

# Shorter than a tick in real time, in which every message is received [s].
_REST_S = 0.02
_PICTURE_BUFFER_BYTES = 4 * 1024 * 1024
# std_msgs/Header, the first field of a message: sequence number, seconds, nanoseconds.
_HEADER = struct.Struct("<III")


@dataclass
class Feed:
    """A topic, and what arrived last. Messages stay encoded until their values are needed."""

    topic: str  # name of the topic
    # Whether it carries pictures: then only the newest of a burst is received
    picture: bool = False
    # Whether only the newest message of each _REST_S is received: in lockstep, to wake up for each
    # message costs the drive more than the page can show. It needs a header, whose sequence number
    # counts the messages
    rests: bool = False
    # Called with each message, in the thread of the subscriber
    callback: Callable[[Any], None] | None = None
    newest: Any = None  # the newest message, None before the first one
    count: int = 0  # number of messages that were published

    def receive(self, message: Any) -> None:
        """Store a message."""
        if (self.picture or self.rests) and len(message._buff) >= _HEADER.size:
            self.count = _HEADER.unpack_from(message._buff)[0]
        else:
            self.count += 1
        self.newest = message
        if self.callback is not None:
            self.callback(message)
        if self.rests:
            time.sleep(_REST_S)


class TopicFeeds:
    """Subscribes to topics, and unsubscribes, in a thread of its own: both wait for the master."""

    def __init__(self, feeds: list[Feed]):
        self.feeds = {feed.topic: feed for feed in feeds}
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self._wanted: frozenset[str] = frozenset()
        self._resting: dict[str, float] = {}
        self._changed = threading.Event()
        self._counted: tuple[float, dict[str, int]] = (time.monotonic(), {})
        threading.Thread(target=self._run, daemon=True).start()

    def want(self, topics: frozenset[str]) -> None:
        """Be subscribed to exactly these topics, soon."""
        if topics != self._wanted:
            self._wanted = topics
            self._changed.set()

    def rest(self, topic: str, seconds: float) -> None:
        """Unsubscribe from a topic for a while: its publisher spends time on every message."""
        self._resting[topic] = time.monotonic() + seconds
        self._changed.set()

    def rates(self) -> dict[str, float]:
        """Return the messages per second of the topics since the last call [1/s]."""
        now_s = time.monotonic()
        counts = {topic: self.feeds[topic].count for topic in self._wanted}
        before_s, before = self._counted
        self._counted = now_s, counts
        return {
            topic: max(count - before[topic], 0) / max(now_s - before_s, 1e-3)
            for topic, count in counts.items()
            if topic in before
        }

    def _run(self) -> None:
        while not rospy.is_shutdown():
            now_s = time.monotonic()
            ends_s = tuple(self._resting.values())
            self._changed.wait(max(min(ends_s) - now_s, 0.0) if ends_s else None)
            self._changed.clear()
            for topic, until_s in tuple(self._resting.items()):
                if until_s <= time.monotonic():
                    del self._resting[topic]
            wanted = self._wanted - set(self._resting)
            for topic in set(self._subscribers) - wanted:
                self._subscribers.pop(topic).unregister()
            # In the order of the feeds: what the page needs first is subscribed to first.
            for topic, feed in self.feeds.items():
                if topic in wanted and topic not in self._subscribers:
                    self._subscribers[topic] = _subscriber(feed)


def _subscriber(feed: Feed) -> rospy.Subscriber:
    options = {"queue_size": 1} if feed.picture or feed.rests else {}
    if feed.picture:
        options["buff_size"] = _PICTURE_BUFFER_BYTES
    return rospy.Subscriber(feed.topic, rospy.AnyMsg, feed.receive, tcp_nodelay=True, **options)


def decoded(message: Any, message_class: type) -> Any:
    """Return an encoded message as a message of a class.

    Raises:
        ValueError: its publisher has another type, or the bytes are damaged
    """
    header = message._connection_header
    if header.get("md5sum") != message_class._md5sum:  # type: ignore[attr-defined]
        raise ValueError(
            f"its type is {header.get('type')}, needed is {message_class._type}"  # type: ignore[attr-defined]
        )
    try:
        return message_class().deserialize(message._buff)
    except (genpy.MessageException, struct.error) as error:
        raise ValueError(f"the message is damaged: {error}") from error


def stamp_of(message: Any) -> tuple[int, int]:
    """Return seconds and nanoseconds of the header of an encoded message.

    Raises:
        ValueError: the message is too short for a header
    """
    try:
        _, seconds, nanoseconds = _HEADER.unpack_from(message._buff)
    except struct.error as error:
        raise ValueError(f"the message is damaged: {error}") from error
    return seconds, nanoseconds


def seconds_of(stamp: tuple[int, int]) -> float:
    """Return a stamp of seconds and nanoseconds as one number [s]."""
    return stamp[0] + 1e-9 * stamp[1]
