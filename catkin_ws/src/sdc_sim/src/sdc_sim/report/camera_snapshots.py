"""Snapshots of the camera for the report."""

from __future__ import annotations

import base64
import math
import threading
from collections.abc import Callable, Sequence

import rospy
from sensor_msgs.msg import Image

from sdc_sim.evaluation.drive_evaluation import PICTURE

_SNAPSHOT_PX, _SNAPSHOT_QUALITY = 480, 80
_PICTURE_PX, _PICTURE_QUALITY = 320, 60
# Simulated time between two pictures of the strip. It doubles whenever this many are taken, so that
# a drive of many hours does not fill the disk.
_PICTURE_INTERVAL_S = 1.5
_PICTURES_PER_INTERVAL = 400
# A subscription costs both processes some time, and in lockstep a simulated second is short.
_MIN_WALL_INTERVAL_S = 0.5
_BUFFER_BYTES = 4 * 1024 * 1024


class CameraSnapshots:
    """Snapshots at equal distances along the route, and a strip of small pictures over the time.

    An image is about a megabyte, so the topic is subscribed to only while one is due.
    """

    def __init__(self, topics: Sequence[str], count: int, add: Callable[..., object]):
        """Plan the snapshots.

        Args:
            topics: of the camera's images; only one of them has a publisher
            count: number of snapshots in a completed drive; 0: no small pictures either
            add: called with the name and the arguments of an event of DriveEvaluation
        """
        self._topics = tuple(topics)
        self._add = add
        self._enabled = count > 0
        self._due = [100.0 * (number + 0.5) / count for number in range(count)]
        self._percent = self._now_s = 0.0
        self._picture_at_s = self._subscribed_at_s = -math.inf
        self._pictures = 0
        self._subscribers: list[rospy.Subscriber] = []
        self._received = threading.Event()

    def update(self, percent: float, now_s: float, wall_s: float) -> None:
        """Subscribe if a picture is due on the route or by both times [s], else unsubscribe."""
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
            options = {"queue_size": 1, "buff_size": _BUFFER_BYTES}
            self._subscribers = [
                rospy.Subscriber(topic, Image, self._on_image, **options) for topic in self._topics
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
        time_s, percent = message.header.stamp.to_sec(), self._percent
        self._add("scene", PICTURE, time_s, jpeg)
        if self._snapshot_due:
            self._due = [due for due in self._due if due > percent]
            snapshot = encode_jpeg(message, _SNAPSHOT_PX, _SNAPSHOT_QUALITY)
            self._add("snapshot", time_s, percent, snapshot)
        self._received.set()

    def close(self) -> None:
        """Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers = []


def encode_jpeg(message: Image, width_px: int, quality: int) -> str | None:
    """Return a small JPEG in base64, or None if the encoding or size is not supported."""
    import cv2  # a drive without a camera needs neither

    from sdc_common.ros.pictures import pixels_of

    try:
        pixels = pixels_of(message)
    except ValueError:
        return None
    scale = min(1.0, width_px / message.width)
    small = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    jpeg = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return base64.b64encode(jpeg).decode()
