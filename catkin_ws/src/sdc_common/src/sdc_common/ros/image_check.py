"""Validation of sensor_msgs/Image messages."""

from __future__ import annotations

from sensor_msgs.msg import Image


def check_image(message: Image) -> None:
    """Check the size of an image before its pixels are read.

    Raises:
        ValueError: the image is empty, or its data are too short for its size
    """
    if not (
        0 < message.width <= message.step and 0 < message.height * message.step <= len(message.data)
    ):
        raise ValueError(
            f"{message.width} x {message.height} pixels in rows of {message.step} bytes "
            f"do not match {len(message.data)} bytes of data"
        )
