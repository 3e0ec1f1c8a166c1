from itertools import permutations
from types import SimpleNamespace

import pytest
import rospy

from sdc_localization.sensor_pairing import SensorPairing

WHEELS, IMU, GNSS = range(3)


def message(tick):
    return SimpleNamespace(header=SimpleNamespace(stamp=rospy.Time(0, tick * 50_000_000)))


def ticks(messages):
    return tuple(one and one.header.stamp.nsecs // 50_000_000 for one in messages)


@pytest.fixture
def answers():
    return []


@pytest.fixture
def pairing(answers):
    """GNSS is due in every second tick."""
    found = SensorPairing(lambda *messages: answers.append(ticks(messages)), [0.1])
    found.start()
    return found


@pytest.mark.parametrize("order", permutations(range(3)))
def test_tick_is_answered_once_in_any_order_of_its_messages(pairing, answers, order):
    for sensor in order:
        assert answers == []
        pairing.add(sensor, message(2))
    assert answers == [(2, 2, 2)]
    for sensor in order:
        pairing.add(sensor, message(2))
    assert answers == [(2, 2, 2)]


def test_tick_without_gnss_waits_for_none(pairing, answers):
    pairing.add(IMU, message(1))
    pairing.add(WHEELS, message(1))
    assert answers == [(1, 1, None)]


def test_missing_gnss_is_not_waited_for_when_the_next_tick_arrives(pairing, answers):
    for tick in (2, 3):
        pairing.add(IMU, message(tick))
        pairing.add(WHEELS, message(tick))
    assert answers == [(2, 2, None), (3, 3, None)]


def test_what_arrives_before_the_start_is_answered_at_the_start(answers):
    pairing = SensorPairing(lambda *messages: answers.append(ticks(messages)), [0.1])
    for tick in (1, 2):
        for sensor in (GNSS, IMU, WHEELS):
            pairing.add(sensor, message(tick))
    assert answers == []
    pairing.start()
    assert [row[0] for row in answers] == [1, 2]
