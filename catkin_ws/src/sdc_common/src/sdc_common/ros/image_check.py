"""Checks a sensor_msgs/Image before anybody reads its pixels."""

from __future__ import annotations


def check_image(message) -> None:
    """Raises ValueError for a size of nothing, and for data that are not of the size that the message tells."""
    if not (
        0 < message.width <= message.step and 0 < message.height * message.step <= len(message.data)
    ):
        raise ValueError(
            f"{message.width} x {message.height} pixels in rows of {message.step} bytes do not come with "
            f"{len(message.data)} bytes"
        )
