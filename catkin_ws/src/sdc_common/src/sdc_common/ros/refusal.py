"""Refuse bad messages: warn about them and keep the last good state."""

from __future__ import annotations

import contextlib
import time
from typing import Iterator

import rospy

_WARN_EVERY_S = 1.0
_last_warning_s: dict[str, float] = {}


@contextlib.contextmanager
def refusing(topic: str, *errors: type[Exception]) -> Iterator[None]:
    """Log a ValueError, or one of these errors, that a message on a topic causes, and continue.

    At most one warning per topic and second of wall time is logged. Simulated time may stop or
    run many times faster.

    Raises:
        ROSException: the block publishes to a closed topic, unless the node shuts down
    """
    try:
        yield
    except (ValueError, *errors) as error:  # type: ignore[misc]
        now_s = time.monotonic()
        if now_s - _last_warning_s.get(topic, -_WARN_EVERY_S) >= _WARN_EVERY_S:
            _last_warning_s[topic] = now_s
            node = rospy.get_name().lstrip("/")
            rospy.logwarn("%s: refused a message on %s: %s", node, topic, error)
    except rospy.ROSException:
        # While the node shuts down, rospy closes the publishers before the last callbacks end.
        if not rospy.core.is_shutdown_requested():
            raise
