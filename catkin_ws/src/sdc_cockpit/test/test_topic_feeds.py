"""Messages of topics, as they arrive."""

import struct
from types import SimpleNamespace

from sdc_cockpit.topic_feeds import Feed


def message(number):
    return SimpleNamespace(_buff=struct.pack("<III", number, 1, 0) + b"rest")


def test_messages_without_a_header_are_counted():
    seen = []
    feed = Feed("/topic", callback=seen.append)
    for number in (7, 9):
        feed.receive(message(number))
    assert feed.count == 2
    assert feed.newest is seen[-1]


def test_messages_that_a_burst_dropped_are_counted():
    for feed in (Feed("/topic", rests=True), Feed("/topic", picture=True)):
        for number in (7, 9):
            feed.receive(message(number))
        assert feed.count == 9
