"""Snapshots of the camera for the report."""

from __future__ import annotations

import io
import math
import threading
import time
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
_SNAPSHOT_PX, _SNAPSHOT_QUALITY = 480, 80
_PICTURE_PX, _PICTURE_QUALITY = 320, 60
# Simulated time between two pictures of the strip. It doubles whenever this many are taken, so that
# a drive of many hours does not fill the disk.
_PICTURE_INTERVAL_S = 1.5
_PICTURES_PER_INTERVAL = 400
# A subscription costs both processes some time, and in lockstep a simulated second is short.
_MIN_WALL_INTERVAL_S = 0.5
_BUFFER_BYTES = 4 * 1024 * 1024
_ASK_AGAIN_S = 5.0


class CameraSnapshot(NamedTuple):
    """A JPEG of the camera, its simulated time [s] and the completed share of the route [%]."""

    time_s: float
    percent: float
    jpeg: bytes


class CameraSnapshots:
    """Snapshots at equal distances along the route, and a strip of small pictures over the time.

    An image is about a megabyte, so the topic is subscribed to only while one is due.
    """

    def __init__(
        self,
        topics: Sequence[str],
        count: int,
        on_snapshot: Callable[[CameraSnapshot], None],
        on_picture: Callable[[float, bytes], None],
    ):
        """Plan the snapshots.

        Args:
            topics: of the camera's images; only one of them has a publisher
            count: number of snapshots in a completed drive; 0: no small pictures either
            on_snapshot: called with each snapshot
            on_picture: called with the simulated time [s] and the JPEG of each small picture
        """
        self._topics = tuple(topics)
        self._on_snapshot = on_snapshot
        self._on_picture = on_picture
        self._enabled = count > 0
        self._due = [100.0 * (number + 0.5) / count for number in range(count)]
        self._percent = self._now_s = 0.0
        self._picture_at_s = -math.inf
        self._pictures = 0
        self._taken = False
        self._last: tuple[Image, float] | None = None
        self._subscribed_at_s = -math.inf
        self._subscribers: list[rospy.Subscriber] = []
        self._received = threading.Event()

    def update(self, percent: float, now_s: float, wall_s: float) -> None:
        """Subscribe if a picture is due, else unsubscribe.

        Args:
            percent: completed share of the route [%]
            now_s: simulated time of the last odometry [s]
            wall_s: wall clock [s]
        """
        self._percent, self._now_s = percent, now_s
        if self._subscribers and self._received.is_set():
            self.close()
        if self._subscribers or not self._enabled:
            return
        interval_s = _PICTURE_INTERVAL_S * 2.0 ** (self._pictures // _PICTURES_PER_INTERVAL)
        picture_due = (
            not 0.0 <= now_s - self._picture_at_s < interval_s
            and wall_s - self._subscribed_at_s >= _MIN_WALL_INTERVAL_S
        )
        if self._snapshot_due or picture_due:
            self._subscribed_at_s = wall_s
            self._received.clear()
            self._subscribers = [
                rospy.Subscriber(
                    topic, Image, self._on_image, queue_size=1, buff_size=_BUFFER_BYTES
                )
                for topic in self._topics
            ]

    @property
    def _snapshot_due(self) -> bool:
        return bool(self._due) and self._percent >= self._due[0]

    def _on_image(self, message: Image) -> None:
        if self._received.is_set():
            return
        jpeg = encode_jpeg(message, _PICTURE_PX, _PICTURE_QUALITY)
        if jpeg is None:
            return
        self._pictures += 1
        self._picture_at_s = self._now_s
        self._on_picture(message.header.stamp.to_sec(), jpeg)
        percent = self._percent
        if self._snapshot_due:
            self._due = [due for due in self._due if due > percent]
            self._take_snapshot(message, percent)
        self._last = message, percent
        self._received.set()

    def _take_snapshot(self, message: Image, percent: float) -> None:
        jpeg = encode_jpeg(message, _SNAPSHOT_PX, _SNAPSHOT_QUALITY)
        assert jpeg is not None
        self._taken = True
        self._on_snapshot(CameraSnapshot(message.header.stamp.to_sec(), percent, jpeg))

    def finish(self, timeout_s: float) -> None:
        """Take one snapshot of a drive that was too fast for all of them; unsubscribe.

        Args:
            timeout_s: longest wait for a picture, if there is a camera [s of wall time]
        """
        if self._snapshot_due and not self._taken:
            self._wait_for_picture(timeout_s)
            if self._last is not None and not self._taken:
                self._take_snapshot(*self._last)
        self.close()

    def _wait_for_picture(self, timeout_s: float) -> None:
        limit_s = time.monotonic() + timeout_s
        while self._last is None and self._has_camera():
            if time.monotonic() > limit_s:
                rospy.logwarn("referee: no picture came from the camera; the report has none")
                return
            if not self._received.wait(_ASK_AGAIN_S):
                # rospy does not repeat a connection that has failed.
                self.close()
                self.update(self._percent, self._now_s, time.monotonic())

    def _has_camera(self) -> bool:
        try:
            topics = {topic for topic, _ in rospy.get_published_topics()}
        except OSError:
            return False  # the ROS master is gone
        return bool(topics.intersection(self._topics))

    def close(self) -> None:
        """Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers = []


def encode_jpeg(message: Image, width_px: int, quality: int) -> bytes | None:
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
    picture.thumbnail((width_px, message.height))
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=quality)
    return file.getvalue()
