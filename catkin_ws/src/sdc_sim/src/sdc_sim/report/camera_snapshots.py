"""Snapshots of the camera for the report."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import rospy
from sensor_msgs.msg import Image

# Channel indices of red, green and blue, and number of channels, by encoding.
_ENCODINGS = {
    "bgra8": ((2, 1, 0), 4),
    "bgr8": ((2, 1, 0), 3),
    "rgba8": ((0, 1, 2), 4),
    "rgb8": ((0, 1, 2), 3),
    "mono8": ((0, 0, 0), 1),
}
_WIDTH_PX = 480
_BUFFER_BYTES = 4 * 1024 * 1024


class CameraSnapshot(NamedTuple):
    """A JPEG of the camera, its simulated time [s] and the completed share of the route [%]."""

    time_s: float
    percent: float
    jpeg: bytes


class CameraSnapshots:
    """Snapshots at equal distances along the route.

    An image is about a megabyte, so the topic is subscribed to only while a snapshot is due.
    """

    def __init__(
        self, topics: Sequence[str], count: int, on_taken: Callable[[CameraSnapshot], None]
    ):
        """Plan the snapshots.

        Args:
            topics: of the camera's images; only one of them has a publisher
            count: number of snapshots in a completed drive
            on_taken: called with each snapshot
        """
        self._topics = tuple(topics)
        self._on_taken = on_taken
        self._due = [100.0 * (number + 0.5) / count for number in range(count)]
        self._percent = 0.0
        self._subscribers: list[rospy.Subscriber] = []
        self._received = threading.Event()

    def update(self, percent: float) -> None:
        """Subscribe if a snapshot is due at this share of the route [%], else unsubscribe."""
        self._percent = percent
        if self._subscribers and self._received.is_set():
            self.close()
        if not self._subscribers and self._due and percent >= self._due[0]:
            self._due = [due for due in self._due if due > percent]
            self._received.clear()
            self._subscribers = [
                rospy.Subscriber(
                    topic, Image, self._on_image, queue_size=1, buff_size=_BUFFER_BYTES
                )
                for topic in self._topics
            ]

    def _on_image(self, message: Image) -> None:
        if self._received.is_set():
            return
        jpeg = encode_jpeg(message)
        if jpeg is not None:
            self._received.set()
            self._on_taken(CameraSnapshot(message.header.stamp.to_sec(), self._percent, jpeg))

    def close(self) -> None:
        """Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers = []


def encode_jpeg(message: Image) -> bytes | None:
    """Return a small JPEG of an image, or None if its encoding or size is not supported."""
    from PIL import Image as Picture  # not needed in a drive without a camera

    order, channels = _ENCODINGS.get(message.encoding, ((), 0))
    row_bytes = message.width * channels
    if (
        not row_bytes
        or not message.height
        or message.step < row_bytes
        or len(message.data) != message.step * message.height
    ):
        return None
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    pixels = rows[:, :row_bytes].reshape(message.height, message.width, channels)[:, :, order]
    picture = Picture.fromarray(np.ascontiguousarray(pixels))
    picture.thumbnail((_WIDTH_PX, message.height))
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=80)
    return file.getvalue()
