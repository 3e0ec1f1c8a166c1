"""Messages are paired by stamp, whatever their order."""

from types import SimpleNamespace

import pytest

from sdc_perception.stamp_pairing import StampPairing


def message(stamp, name):
    header = SimpleNamespace(stamp=SimpleNamespace(to_nsec=lambda: stamp))
    return SimpleNamespace(header=header, name=name)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_each_stamp_is_answered_once_with_its_messages(order):
    answers = []
    pairing = StampPairing(2, lambda *pair: answers.append([one.name for one in pair]))
    for stamp in (10, 20, 30):
        for topic in order:
            pairing.add(topic, message(stamp, f"{topic}:{stamp}"))
            pairing.add(topic, message(stamp, f"{topic}:{stamp}"))
    assert answers == [["0:10", "1:10"], ["0:20", "1:20"], ["0:30", "1:30"]]


def test_late_message_of_another_tick_is_not_paired():
    answers = []
    pairing = StampPairing(2, lambda *pair: answers.append([one.name for one in pair]))
    pairing.add(0, message(10, "a10"))
    pairing.add(0, message(20, "a20"))
    pairing.add(1, message(20, "b20"))
    pairing.add(1, message(10, "b10"))
    assert answers == [["a20", "b20"]]
