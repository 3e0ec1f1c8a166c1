"""Conversion of what world and car exchange to and from messages."""

from __future__ import annotations

import rospy

from sdc_common.driving import Command, Observation


def stamp_of(content: Observation | Command) -> rospy.Time:
    """Return the stamp of an observation or a command as a message has it."""
    return rospy.Time(*divmod(content.stamp_ns, 1_000_000_000))
