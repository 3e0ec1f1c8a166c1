"""Takes a picture of the camera now and then: a picture is a megabyte, so nobody listens in between."""

from __future__ import annotations

import io
import threading
from typing import NamedTuple

import numpy as np
import rospy
from sensor_msgs.msg import Image

# Encodings by the places of red, green and blue among their channels; the number of channels.
_ENCODINGS = {
    "bgra8": ((2, 1, 0), 4),
    "bgr8": ((2, 1, 0), 3),
    "rgba8": ((0, 1, 2), 4),
    "rgb8": ((0, 1, 2), 3),
    "mono8": ((0, 0, 0), 1),
}
_WIDTH_PX = 480


class CameraSnapshot(NamedTuple):
    """A picture of the camera: when (simulated time) and how far along the route, and a JPEG of it."""

    time_s: float
    percent: float
    jpeg: bytes


class CameraSnapshots:
    """Takes `count` pictures, evenly over the route. `look` is called often, and listens to the topic only while one is due."""

    def __init__(self, topic: str, count: int):
        self.taken = []
        self._topic = topic
        self._due = [100.0 * (number + 0.5) / count for number in range(count)]
        self._percent = 0.0
        self._subscriber = None
        self._got = threading.Event()

    def look(self, percent: float) -> None:
        """The drive has come this far."""
        self._percent = percent
        if self._subscriber is not None and self._got.is_set():
            self.close()
        if self._subscriber is None and self._due and percent >= self._due[0]:
            self._due = [due for due in self._due if due > percent]
            self._got.clear()
            self._subscriber = rospy.Subscriber(
                self._topic, Image, self._on_image, queue_size=1, buff_size=4 * 1024 * 1024
            )

    def _on_image(self, message) -> None:
        if not self._got.is_set():
            jpeg = jpeg_of(message)
            if jpeg is not None:
                self._got.set()
                self.taken.append(
                    CameraSnapshot(message.header.stamp.to_sec(), self._percent, jpeg)
                )

    def close(self) -> None:
        """Listen no more."""
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None


def jpeg_of(message):
    """A sensor_msgs/Image as a small JPEG; None for an encoding or a size that is not understood."""
    from PIL import Image as Picture  # not needed where no camera is

    order, channels = _ENCODINGS.get(message.encoding, (None, 0))
    wide = message.width * channels
    if (
        order is None
        or not wide
        or not message.height
        or message.step < wide
        or len(message.data) != message.step * message.height
    ):
        return None
    pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)[:, :wide]
    pixels = pixels.reshape(message.height, message.width, channels)[:, :, order]
    picture = Picture.fromarray(np.ascontiguousarray(pixels))
    picture.thumbnail((_WIDTH_PX, message.height))
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=80)
    return file.getvalue()
