"""Publish what limits the planned speed at the car."""

from __future__ import annotations

import time

import rospy
from sdc_msgs.msg import SpeedReason

from sdc_common.driving import REASON_REPEAT_NS
from sdc_common.ros.node import LoopPublisher

TOPIC = "/planner/speed_reason"
DETAIL_TOPIC = TOPIC + "_detail"  # because of whom, in words
# Wall time in which the nodes of a drive start [s]: start_patience_s of the simulator.
_START_S = 20.0


class SpeedReasonPublisher:
    """Publishes the reason when it changes and every 0.25 s, which is cheaper than every tick."""

    def __init__(self):
        self._publisher = LoopPublisher(TOPIC, SpeedReason, latch=True)
        self._detail_publisher = LoopPublisher(DETAIL_TOPIC, SpeedReason, latch=True)
        self._last = "", ""
        self._stamp_ns = 0
        self._started_s = time.monotonic()

    def update(self, stamp: rospy.Time, reason: str, detail: str = "") -> None:
        """Set the reason from the odometry with this stamp on; see report_page.yaml."""
        stamp_ns, last = stamp.to_nsec(), self._last
        if (reason, detail) == last and 0 <= stamp_ns - self._stamp_ns < REASON_REPEAT_NS:
            return
        self._last, self._stamp_ns = (reason, detail), stamp_ns
        texts = (self._publisher, reason), (self._detail_publisher, detail)
        for publisher, text in texts if detail or last[1] else texts[:1]:
            message = SpeedReason(reason=text)
            message.header.stamp = stamp
            publisher.publish(message)

    def timed_out(self, missing: str, stamp: rospy.Time) -> None:
        """Publish that an input of the controller is missing, `path` or `odometry`, and warn.

        While the nodes of a drive start, the first message is awaited without a warning.
        """
        if time.monotonic() - self._started_s > _START_S:
            name = rospy.get_name().lstrip("/")
            rospy.logwarn_throttle(5.0, f"{name}: no {missing}, braking")
        self.update(stamp, f"{missing}_timeout")
