"""Each odometry is answered once, when its path has arrived, whichever of the two arrives first."""

import math

import pytest
import rospy
from nav_msgs.msg import Odometry

from sdc_package.input_pairing import InputPairing


def odometry(seconds, x=0.0):
    message = Odometry()
    message.header.stamp = rospy.Time.from_sec(seconds)
    message.pose.pose.position.x = x
    message.pose.pose.orientation.w = 1.0
    return message


class Record:
    """An InputPairing with a timeout of 0.25 s, and what it has called."""

    def __init__(self, path_needed=True):
        self.answers = []
        self.stops = []
        self.inputs = InputPairing(self.answer, self.stop, 0.25, path_needed)

    def answer(self, observation, path):
        self.answers.append((observation.stamp_s, path.rows[0][2] if path.rows else None))

    def stop(self, missing, observation, path):
        speed = path.rows[0][2] if path.rows else None
        self.stops.append((missing, observation and observation.stamp_s, speed))

    def receive(self, events):
        """Add an odometry for "o" and its stamp [s], and a path for "p" and its speed [m/s]."""
        for event in events.split():
            number = float(event[1:])
            if event[0] == "o":
                self.inputs.add_odometry(odometry(number))
            else:
                self.inputs.add_path([(0.0, 0.0, number), (10.0, 0.0, number)])


@pytest.mark.parametrize(
    ("events", "answers"),
    [
        ("o1", []),
        ("p5", []),
        ("o1 p5", [(1.0, 5.0)]),
        ("p5 o1", [(1.0, 5.0)]),
        ("o1 p5 o1.05", [(1.0, 5.0)]),
        # An odometry without an answer is replaced by the next one.
        ("o1 o1.05 p5", [(1.05, 5.0)]),
        # The last of several paths answers, and only one odometry.
        ("p5 p6 o1 o1.05", [(1.0, 6.0)]),
        # A repeated odometry is answered once.
        ("o1 p5 p6 o1", [(1.0, 5.0)]),
        ("o1 p5 p6 o1 o1.05", [(1.0, 5.0), (1.05, 6.0)]),
    ],
)
def test_one_path_answers_one_odometry_whichever_arrives_first(events, answers):
    record = Record()
    record.receive(events)
    assert record.answers == answers


def test_bad_path_answers_no_odometry():
    record = Record()
    with pytest.raises(ValueError, match="path"):
        record.inputs.add_path([(0.0, 0.0, math.nan), (10.0, 0.0, 5.0)])
    record.receive("o1")
    assert record.answers == []


def test_basic_control_answers_each_odometry_without_a_path():
    record = Record(path_needed=False)
    record.receive("o1 p5 o1.05")
    assert record.answers == [(1.0, None), (1.05, 5.0)]
    record.inputs.check(round(1.3 * 1e9))
    assert record.stops == []
    record.inputs.check(round(1.31 * 1e9))
    assert record.stops == [("odometry", 1.05, 5.0)]


def test_missing_odometry_stops_the_car():
    record = Record()
    record.inputs.check(0)
    assert record.stops == []
    record.inputs.check(round(0.3 * 1e9))
    assert record.stops == [("odometry", None, None)]


def test_missing_path_stops_the_car_along_the_last_path_at_the_next_odometry():
    record = Record()
    record.receive("o1 p5 o1.05 o1.25 o1.3")
    assert record.stops == [("path", 1.3, 5.0)]
    record.receive("p6")
    assert record.answers == [(1.0, 5.0), (1.3, 6.0)]
