"""Topics whose messages of one stamp are answered together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import rospy
from sensor_msgs.msg import Image

from sdc_perception.stamp_pairing import StampPairing

EGO = "/carla/ego_vehicle"
CAMERA = f"{EGO}/camera/rgb/front"
_PICTURE_BYTES = 4 * 1024 * 1024


def answer_together(topics: Sequence[tuple[str, type]], answer: Callable[..., None]) -> None:
    """Call `answer(*messages)` once for each stamp, with a message of each topic."""
    inputs = StampPairing(len(topics), answer)
    for number, (topic, message_class) in enumerate(topics):
        options: dict[str, Any] = {"queue_size": 10, "tcp_nodelay": True}
        if message_class is Image:
            options["buff_size"] = _PICTURE_BYTES
        rospy.Subscriber(topic, message_class, partial(inputs.add, number), **options)
